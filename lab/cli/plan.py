"""`nao-hil plan`: search a gait's plan, and show it, without a robot."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import typer
from rich.console import Console
from rich.table import Table

from bridge.datasheet import Body, load_body
from bridge.errors import ConfigurationError
from lab.cli import options
from lab.cli.console import open_console
from lab.config import RunConfig, run_config
from lab.rundir import RunDirectory

if TYPE_CHECKING:
    from walker.gait.huang import HuangParameters
    from walker.gait.huang.found import Found

ON_BOUND = 0.97
"""Share of bound (11) that is the grid's last point or nearly."""
_NO_NUMBERS = ("nan", "inf", "infinity")
Set = Annotated[
    list[str] | None,
    typer.Option("--set", help="A parameter of the gait; may be repeated.", metavar="NAME=VALUE"),
]
Plot = Annotated[bool, typer.Option("--plot", help="Draw the plan into the folder of --out.")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Search anew, whatever an earlier search found.")]
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
    values: Set = None,
    trials: Trials = 0,
    study: Study = None,
    fresh: Fresh = False,
    plot: Plot = False,
    config: options.Config = None,
    out: options.Out = None,
    as_json: options.Json = False,
) -> int:
    """Search the hip motion with the largest stability margin. Exit code 1: the ZMP leaves the soles.

    Example: nao-hil plan --gait huang --set D_s=0.06 --plot --out plan
    """
    if gait != "huang":
        raise ConfigurationError(f"There is nothing to search in the gait {gait}; `plan` is for --gait huang.")
    # imported late: the walk stands on SciPy, which help and completion need not wait for
    from lab.ground import ground_parameters
    from walker.gait import gait_parameters
    from walker.gait.huang import HuangParameters
    from walker.gait.huang.found import find

    settings = run_config(config, robot=robot, scenario=scenario, gait=gait)
    changes = settings.parameters | _assignments(values or [])
    settings = msgspec.structs.replace(settings, parameters=changes)
    body = load_body(settings.robot)
    console = open_console()
    p = gait_parameters("huang", ground_parameters(settings, body))
    assert isinstance(p, HuangParameters)
    if trials or study is not None:
        from lab.plan.study import improve

        with console.status("trials") as status:
            p = improve(p, body, trials, study, lambda text: status.update(text))
    began = time.perf_counter()
    with console.status("search") as status:
        found = find(p, body, fresh=fresh, progress=lambda text: status.update(f"search: {text}"))
    result = _result(p, body, found, time.perf_counter() - began)
    directory = None
    if plot or out is not None:
        directory = RunDirectory(out)
        directory.write_config(_as_planned(settings, p, changes))
        directory.write_summary(result)
    if plot:
        assert directory is not None
        from lab.plan.figures import draw

        with console.status("figures"):
            result["figures"] = [file.name for file in draw(p, body, found.choice, directory.path)]
    _show(console, p, result, directory)
    if as_json:
        print(json.dumps(result), flush=True)
    return 0 if found.margin > 0.0 else 1


def _assignments(values: list[str]) -> dict[str, Any]:
    """NAME=VALUE as a table; numbers where they are numbers."""
    table: dict[str, Any] = {}
    for value in values:
        name, equals, text = value.partition("=")
        if not equals or not name:
            raise ConfigurationError(f"--set {value}: is not NAME=VALUE, such as --set D_s=0.05.")
        try:
            table[name] = json.loads(text)
        except ValueError:
            table[name] = text
        if (
            table[name] != table[name]
            or table[name] in (math.inf, -math.inf)
            or text.lower().strip("+-") in _NO_NUMBERS
        ):
            raise ConfigurationError(f"--set {value}: must be a finite number, such as --set D_s=0.05.")
    return table


def _result(p: HuangParameters, body: Body, found: Found, seconds: float) -> dict[str, Any]:
    """The JSON of the command.

    Raises:
        ConfigurationError: a pose that the legs cannot reach or the joints' ranges forbid.
    """
    from walker.gait.huang import HuangGait
    from walker.walkable import check_walkable

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
        "share_of_bound": [found.choice.x_sd / bound, found.choice.x_ed / bound],
        "kept": found.kept,
        "seconds": seconds,
    }


def _as_planned(settings: RunConfig, p: HuangParameters, named: dict[str, Any]) -> RunConfig:
    """The configuration that walks this plan; what was named stands in it, shipped value or not."""
    from walker.gait import gait_parameters

    shipped = msgspec.to_builtins(gait_parameters("huang"))
    own = {
        k: v for k, v in msgspec.to_builtins(p).items() if v is not None and (k in named or v != shipped.get(k))
    }
    return msgspec.structs.replace(settings, parameters=own)


def _show(console: Console, p: HuangParameters, result: dict[str, Any], directory: RunDirectory | None) -> None:
    table = Table(title="Kept from an earlier search" if result["kept"] else "Searched", show_header=False)
    table.add_row("stability margin", f"{1e3 * result['margin_m']:.1f} mm")
    for name, what in (
        ("x_sd", "hip behind the stance ankle"),
        ("x_ed", "hip ahead of it"),
        ("y_d", "hip aside, ends of single support"),
        ("y_m", "hip aside, its middle"),
    ):
        table.add_row(f"{name}, {what}", f"{1e3 * result[name]:.1f} mm")
    if max(result["share_of_bound"]) > ON_BOUND:
        table.add_row("note", "x_sd or x_ed lies on bound (11); another x_0 may have more margin")
    table.add_row("step", f"{p.D_s} m in {p.T_c} s")
    if directory is not None:
        table.add_row("folder", str(directory.path))
    console.print(table)
