"""`latolato analyse`: one command for each analysis."""

from __future__ import annotations

import time
from collections.abc import Mapping
from inspect import signature
from typing import Any

from latolato.cli.options import JsonOption, PlotOption, ScenarioArgument, TablesOption
from latolato.cli.output import Targets, elapsed_since, print_summary
from latolato.cli.registered import RegistryGroup, command_of
from latolato.core.errors import InputError
from latolato.io.progress import bar, working
from latolato.scenario.analysis_call import AnalysisCall, axes_of, unfit_options


class AnalysisGroup(RegistryGroup):
    """The commands of the registered analyses."""

    kind = "analysis"

    def entries(self) -> Mapping[str, Any]:
        """Return the analyses."""
        from latolato.analysis import analyses

        return dict(sorted(analyses.items()))

    def make_command(self, name: str) -> Any:
        """Return the command of an analysis."""
        from latolato.scenario.analysis_options import options_of

        function = self.entries()[name]
        call = AnalysisCall(name, function, options_of(function))

        def analyse(
            scenario: ScenarioArgument = None,
            output: TablesOption = None,
            plot: PlotOption = None,
            as_json: JsonOption = False,
            **values: Any,
        ) -> None:
            run(call, scenario, values, Targets(output, plot), as_json=as_json)

        return command_of(
            name,
            function,
            analyse,
            call.own,
            panel="Analysis",
            without=unfit_options(function, call.own),
        )


def run(
    call: AnalysisCall,
    source: str | None,
    values: Mapping[str, Any],
    targets: Targets,
    *,
    as_json: bool,
) -> None:
    """Run an analysis, write its files and print its answer."""
    from latolato.analysis.summary import as_lines, summarise

    begun = time.perf_counter()
    targets.check("the result of an analysis", (".nc", ".csv"))
    if targets.plot is not None:
        from latolato.figures.plot import module_of

        module_of("analysis", call.name)
    try:
        arguments = call.arguments(source, values)
        words = call.name.replace("_", " ")
        if "progress" in signature(call.function).parameters:
            with bar(words) as progress:
                dataset = call.function(**arguments, progress=progress)
        else:
            with working(words):
                dataset = call.function(**arguments)
    except InputError as error:
        varied = ", ".join(n for n in axes_of(source) if values.get(n) is None)
        if varied:
            error.add_way_out(f"'{source}' varies {varied}: give values")
        raise
    files = targets.write(dataset)
    summary = summarise(dataset) | {
        "wall_time": elapsed_since(begun),
        "files": [str(path) for path in files],
    }
    lines = as_lines(dataset) | {"wall time": f"{summary['wall_time']:.2f} s"}
    print_summary(summary, lines, as_json=as_json)
