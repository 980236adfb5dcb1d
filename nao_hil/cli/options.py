"""Options that several commands share, with one wording."""

from __future__ import annotations

import json
import math
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from bridge.errors import ConfigurationError
from nao_hil.runs.folder import recording_of

Assignments = Annotated[
    list[str] | None,
    typer.Option("--set", help="Change one parameter; may be repeated.", metavar="NAME=VALUE"),
]
_NO_NUMBERS: Final = ("nan", "inf", "infinity")


def assignments(values: list[str]) -> dict[str, Any]:
    """Names and values of `--set`; a value is JSON, or text where it is not.

    Raises:
        ConfigurationError: not NAME=VALUE, or a number that is not finite.
    """
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


def _choice(flag: str, help_: str, *names: str, metavar: str = "", of: str = "") -> Any:
    """Option that takes one of some names, and completes it.

    Args:
        flag: Of the option.
        help_: Of the option.
        names: To choose from.
        metavar: Of the option; empty: the names.
        of: `module:NAMES` that has the names, imported at the first press of the tab key.
    """

    def complete(incomplete: str) -> list[str]:
        module, _, attribute = of.partition(":")
        known = getattr(import_module(module), attribute) if of else names
        return [name for name in known if name.startswith(incomplete)]

    return typer.Option(flag, help=help_, metavar=metavar or "|".join(names), autocompletion=complete)


Body = Annotated[
    str | None,
    _choice(
        "--robot",
        "Body: a name of `nao-hil robots`, or a data sheet's path.",
        metavar="BODY",
        of="bridge.body:BODIES",
    ),
]
Wear = Annotated[
    str | None,
    _choice(
        "--wear",
        "Drives and sensors: ideal, nominal, worn, ensemble:K, or a profile's path.",
        metavar="WEAR",
        of="emulator.wear:WEAR",
    ),
]
Engine = Annotated[
    str | None,
    _choice(
        "--engine",
        "Physics; default: PyBullet where it is installed, else MuJoCo.",
        metavar="pybullet|mujoco",
        of="emulator.engine.catalogue:ENGINES",
    ),
]
Scenario = Annotated[
    str | None,
    _choice(
        "--scenario",
        "World: a name of `nao-hil scenarios`, or a path.",
        metavar="NAME|FILE",
        of="emulator.scenarios:SCENARIOS",
    ),
]
Start = Annotated[
    str | None,
    _choice(
        "--start",
        "Pose to begin in: stand, sit, crouch, lie-back, lie-front, lie-side, hang.",
        metavar="POSE",
        of="emulator.scenarios:START_NAMES",
    ),
]
Recover = Annotated[
    bool | None,
    typer.Option("--recover/--no-recover", help="Get up after a fall and go on, on bodies that can."),
]
Gait = Annotated[
    str | None,
    _choice(
        "--gait", "Gait: a name of `nao-hil gaits`, or onnx:SHEET.", metavar="GAIT", of="walker.gaits:GAITS"
    ),
]
Stabilizer = Annotated[
    str | None,
    _choice(
        "--stabilizer",
        "Mechanisms that are on: the gait's own, the thesis' alone (admittances, torso control), or none.",
        "own",
        "thesis",
        "none",
    ),
]
Torso = Annotated[
    str | None, _choice("--torso", "Torso control; default: the gait's own choice.", "none", "thesis", "robust")
]
Admittance = Annotated[
    bool | None,
    typer.Option(
        "--admittance/--no-admittance", help="Leg and ankle admittance; default: the gait's own choice."
    ),
]
Steps = Annotated[
    int | None,
    typer.Option(
        "--steps",
        help="Steps to walk, the closing one included; 0: no bound. Default: 10; 0 with a duration or a place.",
        metavar="N",
    ),
]
Duration = Annotated[
    float | None, typer.Option("--duration", help="Seconds to walk; 0: the steps are the bound.", metavar="S")
]
Velocity = Annotated[
    tuple[float, float, float] | None,
    typer.Option(
        "--velocity",
        help="Forward and to the left, m/s, and turn, rad/s; default: the gait's own. Clipped to its limits.",
        metavar="VX VY WZ",
    ),
]
Target = Annotated[
    tuple[float, float, float] | None,
    typer.Option(
        "--to",
        help="Walk to a place, by the odometry: forward and to the left, m, and turn, rad (-3.14 to 3.14). "
        "Gaits that follow a velocity. With --velocity as fast as that; --steps ends it sooner.",
        metavar="X Y TURN",
    ),
]
Mode = Annotated[
    str | None,
    _choice(
        "--mode",
        "`real-time`: the wall clock sets the pace; `lockstep`: the robot waits for each answer; "
        "`in-process` (`up` alone): one process, no link.",
        "real-time",
        "lockstep",
        "in-process",
    ),
]
Seed = Annotated[int | None, typer.Option("--seed", help="Seed of everything random.", metavar="N")]
Config = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="TOML file with any of these options and the tables `parameters` (gait), `controller`.",
        metavar="FILE",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", help="Folder for recording and summary; default runs/<time>/.", metavar="DIR"),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace the run that is in the folder of --out.")]
Cluster = Annotated[
    str,
    typer.Option(
        "--cluster",
        envvar="NAO_HIL_CLUSTER",
        help="Where walks are walked: `local` (a process per core), `local:N`, `inline` (this process), or the "
        "address of a dask scheduler.",
        metavar="local[:N]|inline|tcp://HOST:PORT",
    ),
]
Name = Annotated[str, typer.Option("--name", help="Robot id: all keys are under nao/<id>/.", metavar="ID")]
Listen = Annotated[
    str, typer.Option("--listen", help="Zenoh endpoint the robot listens on.", metavar="ENDPOINT")
]
Connect = Annotated[str, typer.Option("--connect", help="Zenoh endpoint of the robot.", metavar="ENDPOINT")]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Everything but the commands: the robot is only watched.")
]
RealtimePriority = Annotated[
    bool,
    typer.Option("--realtime-priority/--no-realtime-priority", help="Ask for SCHED_FIFO in real time."),
]
Serve = Annotated[
    bool,
    typer.Option("--serve", help="Stand and wait: walk on command (`nao-hil drive`), without end."),
]


def recordings_of(runs: list[Path]) -> list[Path]:
    """Recordings of some runs, each a folder or a file."""
    return [recording_of(run) for run in runs]


Recordings = Annotated[
    list[Path],
    typer.Argument(
        help="Recordings (.mcap), or folders of runs.",
        metavar="FILE...",
        show_default=False,
        callback=recordings_of,
    ),
]
Recording = Annotated[
    Path,
    typer.Argument(
        help="Recording (.mcap), or the folder of a run.",
        metavar="FILE",
        show_default=False,
        callback=recording_of,
    ),
]
Columns = Annotated[
    Path | None,
    typer.Option(
        "--columns",
        help="TOML file that maps the columns of a CSV with other names, or `humanoid-robot-soccer`.",
        metavar="FILE",
    ),
]
Begin = Annotated[float, typer.Option("--from", help="Robot time to begin at, s.", min=0.0, metavar="S")]
End = Annotated[
    float | None, typer.Option("--to", help="Robot time to end at, s; default: the end.", min=0.0, metavar="S")
]
View = Annotated[
    bool,
    typer.Option("--view/--no-view", help="Serve the live page meanwhile, as `nao-hil view` does."),
]
Port = Annotated[int, typer.Option("--port", help="TCP port of the page.", min=1, max=65535, metavar="PORT")]


def stretch(begin: float, end: float | None) -> str:
    """The words for --from and --to."""
    return f"from {begin:g} s to {'its end' if end is None else f'{end:g} s'}"


def check_stretch(begin: float, end: float | None) -> None:
    """Raises ConfigurationError unless --from is before --to."""
    if end is not None and end <= begin:
        raise ConfigurationError(f"--to {end:g} is not after --from {begin:g}; both are robot times in s.")
