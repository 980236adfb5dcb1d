"""`nao-hil plan`: search a gait's plan, and show it, without a robot."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import typer
from rich.console import Console
from rich.table import Table

from bridge.body import Body, load_body
from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console
from nao_hil.cli.options import Assignments, assignments
from nao_hil.runs.config import RunConfig, run_config
from nao_hil.runs.folder import RunDirectory

if TYPE_CHECKING:
    from nao_hil.design.huang.search import CyclePlan
    from walker.gaits.huang import HuangParameters

ON_BOUND = 0.97
"""Fraction of bound (11) from which the choice counts as lying on it."""
Plot = Annotated[bool, typer.Option("--plot", help="Draw the plan into the folder of --out.")]
Grid = Annotated[
    int, typer.Option("--grid", help="Points of the search along each dimension.", min=3, max=400, metavar="N")
]
Trials = Annotated[
    int,
    typer.Option(
        "--trials",
        help="Also try this many sets of T_d, T_m, H_min, H_max, H_ao for more margin.",
        min=0,
        metavar="N",
    ),
]
Study = Annotated[
    Path | None,
    typer.Option("--study", help="File that keeps the trials; given again, the study goes on.", metavar="FILE"),
]


def plan(
    gait: options.Gait = "huang",
    robot: options.Body = None,
    scenario: options.Scenario = None,
    values: Assignments = None,
    trials: Trials = 0,
    study: Study = None,
    grid: Grid = 40,
    plot: Plot = False,
    config: options.Config = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
) -> Answer:
    """Search the hip motion with the largest stability margin. Exit code 1: the ZMP leaves the soles.

    --out writes config.toml, which --config of the other commands takes.

    Example: nao-hil plan --gait huang --set D_s=0.07 --plot --out plan

    Then: nao-hil up --config plan/config.toml
    """
    if gait != "huang":
        raise ConfigurationError(f"There is nothing to search in the gait {gait}; `plan` is for --gait huang.")
    # Imported late: they load SciPy, which help and completion do not need.
    from nao_hil.design.huang.cycle import Cycle
    from nao_hil.design.huang.search import search
    from nao_hil.runs.ground import ground_parameters
    from walker.gaits import gait_parameters
    from walker.gaits.huang import HuangParameters
    from walker.gaits.pose import ARMS

    settings = run_config(config, robot=robot, scenario=scenario, gait=gait)
    changes = settings.parameters | assignments(values or [])
    settings = msgspec.structs.replace(settings, parameters=changes)
    body = load_body(settings.robot)
    console = open_console()
    p = gait_parameters("huang", ground_parameters(settings, body))
    assert isinstance(p, HuangParameters)
    if trials or study is not None:
        from nao_hil.design.huang.study import improve

        with console.status("trials") as status:
            p = improve(p, body, trials, study, lambda text: status.update(text))
    began = time.perf_counter()
    with console.status("search") as status:
        searched = search(Cycle(p, body, ARMS), grid, lambda text: status.update(f"search: {text}"))
    result = _result(p, body, searched, time.perf_counter() - began)
    directory = None
    if plot or out is not None:
        directory = RunDirectory(out)
        directory.clear(overwrite=overwrite)
        directory.write_config(_as_planned(settings, p, searched, changes))
        directory.write_summary(result)
    if plot:
        assert directory is not None
        from nao_hil.design.huang.figures import draw

        with console.status("figures"):
            result["figures"] = [file.name for file in draw(p, body, searched.choice, directory.path)]
    _show(console, p, result, directory)
    return Answer(result, code=0 if searched.margin > 0.0 else 1)


def _result(p: HuangParameters, body: Body, found: CyclePlan, seconds: float) -> dict[str, Any]:
    """The JSON of the command.

    Raises:
        ConfigurationError: a pose that the legs cannot reach or the joints' ranges forbid.
    """
    from walker.gaits.catalogue import check_walkable
    from walker.gaits.huang import HuangGait

    check_walkable(body, HuangGait(msgspec.structs.replace(p, **found.choice._asdict()), body))
    bound = 0.5 * p.D_s
    return {
        "gait": "huang",
        "robot": body.name,
        "margin_m": found.margin,
        **found.choice._asdict(),
        "step_length": p.D_s,
        "speed": p.D_s / p.T_c,
        "T_c": p.T_c,
        "T_d": p.T_d,
        "H_min": p.H_min,
        "H_max": p.H_max,
        "H_ao": p.H_ao,
        "fraction_of_bound": [found.choice.x_sd / bound, found.choice.x_ed / bound],
        "seconds": seconds,
    }


def _as_planned(
    settings: RunConfig, p: HuangParameters, found: CyclePlan, named: dict[str, Any]
) -> dict[str, Any]:
    """Configuration that walks this plan: changes of the defaults, and all parameters of the gait.

    The ground is among them only if it is named; a run takes that of its scenario.
    """
    defaults = msgspec.to_builtins(RunConfig())
    config = {key: value for key, value in msgspec.to_builtins(settings).items() if value != defaults[key]}
    parameters = msgspec.to_builtins(msgspec.structs.replace(p, **found.choice._asdict()))
    if "ground" not in named:
        del parameters["ground"]
    written = {key: value for key, value in parameters.items() if value is not None}
    return {"robot": settings.robot, **config, "parameters": written}


def _show(console: Console, p: HuangParameters, result: dict[str, Any], directory: RunDirectory | None) -> None:
    table = Table(title="Plan of the gait huang", show_header=False)
    table.add_row("stability margin", f"{1e3 * result['margin_m']:.1f} mm")
    for name, what in (
        ("x_sd", "hip behind the stance ankle"),
        ("x_ed", "hip ahead of it"),
        ("y_d", "hip aside, ends of single support"),
        ("y_m", "hip aside, its middle"),
    ):
        table.add_row(f"{name}, {what}", f"{1e3 * result[name]:.1f} mm")
    if max(result["fraction_of_bound"]) > ON_BOUND:
        table.add_row("note", "x_sd or x_ed lies on bound (11); another x_0 may have more margin")
    table.add_row("step", f"{p.D_s} m in {p.T_c} s")
    if directory is not None:
        table.add_row("folder", str(directory.path))
    console.print(table)
