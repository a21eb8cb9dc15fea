"""Trial tables from the text of a CSV, in the one form that the *Map* page reads too."""

import xarray as xr

from latolato.experiment.trial_table import trials_of_cells
from latolato.io.column_files import parse_columns
from latolato.io.shown_units import name_and_unit


def parse_trials(text: str) -> xr.Dataset:
    """Read what `write_trials` writes; cells and names of columns may carry units."""
    parts, header = parse_columns(text)
    cells = {name_and_unit(heading): list(values) for heading, (values, _) in parts.items()}
    return trials_of_cells(cells, header, lambda trial: f"trial {trial}")
