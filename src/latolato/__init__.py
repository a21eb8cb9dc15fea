"""Driven and colliding pendula: simulate, map, analyse, measure and play.

Quantities are in SI units and radians; angles are measured from the downward vertical.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.observables import (
    BottomContacts,
    CompressionFraction,
    ContactWord,
    Crossings,
    EnergyLedger,
    FinalAngle,
    FinalAngularVelocity,
    FirstPassage,
    ImpactSpeed,
    LargestAngle,
    LargestAngleAfterTransient,
    MeanEnergy,
    MotionClass,
    PoincareSection,
    ResponsePeriod,
    ResponseSamples,
    RestFraction,
    Rotations,
    SelfStart,
    TopContacts,
    contact_words,
)
from latolato.physics.contacts import ClampContact, ExactContact, PassThrough
from latolato.physics.drives import (
    Chirp,
    CrankSlider,
    FixedPivot,
    FrequencySchedule,
    Harmonic,
    MeasuredPivot,
    PlanarHarmonic,
    StagedHarmonic,
)
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import (
    Ball,
    BallPair,
    LatoLato,
    Mathieu,
    Pendulum,
    equivalent_pendulum,
)
from latolato.simulation.run import simulate
from latolato.sweeps import sweep

if TYPE_CHECKING:
    from latolato import analysis
    from latolato.analysis.boundary import map_boundary
    from latolato.app.widget import play
    from latolato.core.citation import cite
    from latolato.experiment.compare import compare
    from latolato.experiment.fits.decay import fit_decay
    from latolato.experiment.fits.drive import fit_drive
    from latolato.experiment.fits.model import fit_model
    from latolato.experiment.fits.posterior import fit_posterior
    from latolato.experiment.fits.restitution import fit_restitution
    from latolato.experiment.predict import predict
    from latolato.experiment.track import track
    from latolato.experiment.trials import collect_trials
    from latolato.figures.animate import animate
    from latolato.figures.plot import plot
    from latolato.io.files import load, save
    from latolato.scenario.scenario import Scenario, load_scenario, scenarios
    from latolato.simulation.summary import summarise

# Names that are imported on first use, with the module they live in.
_LATE: dict[str, str] = {
    "Scenario": "latolato.scenario.scenario",
    "analysis": "latolato.analysis",
    "animate": "latolato.figures.animate",
    "map_boundary": "latolato.analysis.boundary",
    "cite": "latolato.core.citation",
    "compare": "latolato.experiment.compare",
    "fit_decay": "latolato.experiment.fits.decay",
    "fit_drive": "latolato.experiment.fits.drive",
    "fit_model": "latolato.experiment.fits.model",
    "fit_posterior": "latolato.experiment.fits.posterior",
    "fit_restitution": "latolato.experiment.fits.restitution",
    "collect_trials": "latolato.experiment.trials",
    "load": "latolato.io.files",
    "load_scenario": "latolato.scenario.scenario",
    "play": "latolato.app.widget",
    "plot": "latolato.figures.plot",
    "predict": "latolato.experiment.predict",
    "save": "latolato.io.files",
    "scenarios": "latolato.scenario.scenario",
    "summarise": "latolato.simulation.summary",
    "track": "latolato.experiment.track",
}

__all__ = [
    "Ball",
    "BallPair",
    "BottomContacts",
    "Chirp",
    "ClampContact",
    "CompressionFraction",
    "ContactWord",
    "CrankSlider",
    "Crossings",
    "EnergyLedger",
    "ExactContact",
    "FinalAngle",
    "FinalAngularVelocity",
    "FirstPassage",
    "FixedPivot",
    "FrequencySchedule",
    "Harmonic",
    "ImpactSpeed",
    "InputError",
    "LargestAngle",
    "LargestAngleAfterTransient",
    "LatoLato",
    "Mathieu",
    "MeanEnergy",
    "MeasuredPivot",
    "MotionClass",
    "PassThrough",
    "Pendulum",
    "PlanarHarmonic",
    "PoincareSection",
    "ResponsePeriod",
    "ResponseSamples",
    "RestFraction",
    "Rotations",
    "Scenario",
    "SelfStart",
    "StagedHarmonic",
    "TopContacts",
    "VelocityKicks",
    "analysis",
    "animate",
    "cite",
    "collect_trials",
    "compare",
    "contact_words",
    "equivalent_pendulum",
    "fit_decay",
    "fit_drive",
    "fit_model",
    "fit_posterior",
    "fit_restitution",
    "load",
    "load_scenario",
    "map_boundary",
    "play",
    "plot",
    "predict",
    "save",
    "scenarios",
    "simulate",
    "summarise",
    "sweep",
    "track",
]


def __getattr__(name: str) -> Any:
    """Import a late name."""
    if name == "__version__":
        from latolato.core.versions import version_of

        return version_of()
    if name not in _LATE:
        raise AttributeError(f"module 'latolato' has no attribute '{name}'")
    import importlib

    module = importlib.import_module(_LATE[name])
    value = module if _LATE[name] == f"latolato.{name}" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return [*__all__, "__version__"]
