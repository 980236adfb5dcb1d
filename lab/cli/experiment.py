"""`nao-hil experiment`: what the robot is and does, measured."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import msgspec
import typer
from rich.console import Console

from bridge.config import unknown_name
from bridge.datasheet import load_body
from bridge.errors import ConfigurationError
from lab.cli import options
from lab.rundir import RunDirectory

Seeds = Annotated[int, typer.Option("--seeds", help="Runs, each with its own seed.", min=1, metavar="N")]
Run = Callable[[str, str, int, Path], msgspec.Struct]
"""Body, wear, number of seeds and folder to a result with a name and a verdict `passed`."""


def _torso_step(body: str, wear: str, seeds: int, out: Path) -> msgspec.Struct:
    from lab.experiments import torso_step

    return torso_step.run(range(seeds), body, wear, out)


def _torso_design(_body: str, _wear: str, _seeds: int, out: Path) -> msgspec.Struct:
    from lab.experiments import torso_design

    return torso_design.run(out)


def _servo_table(body: str, wear: str, _seeds: int, out: Path) -> msgspec.Struct:
    from lab.experiments import servo_table

    return servo_table.run(body, wear, out)


def _abuse(body: str, wear: str, seeds: int, _out: Path) -> msgspec.Struct:
    from emulator.wear import load_wear
    from lab.experiments import abuse

    return abuse.run(60.0 * seeds, seed=0, body=load_body(body), wear=load_wear(wear))


EXPERIMENTS: dict[str, tuple[Run, str]] = {
    "torso-step": (
        _torso_step,
        "the torso's answer to steps of the stance ankle, and its plant (figure 4.10)",
    ),
    "torso-design": (
        _torso_design,
        "the thesis' torso controllers and a robust one (figures 4.11 to 4.14)",
    ),
    "servo-table": (_servo_table, "speed, delay, play, torque and heat of every leg drive"),
    "abuse": (_abuse, "one minute per seed of random commands, pushes and falls"),
}
"""Name -> (how to run it, what it measures)."""


def experiment(
    name: Annotated[str, typer.Argument(help="Name of `nao-hil experiments`.")],
    seeds: Seeds = 5,
    robot: options.Body = "nao-v3",
    wear: options.Wear = "nominal",
    out: options.Out = None,
    as_json: options.Json = False,
) -> int:
    """Run an experiment; its figures and its JSON go to the run's folder. Exit code 1: its verdict failed.

    Example: nao-hil experiment torso-step --seeds 5 --json
    """
    if name not in EXPERIMENTS:
        raise ConfigurationError(unknown_name("experiment", name, EXPERIMENTS))
    console = Console(stderr=True)
    directory = RunDirectory(out)
    with console.status(f"{name}: {EXPERIMENTS[name][1]}"):
        result = EXPERIMENTS[name][0](robot or "nao-v3", wear or "nominal", seeds, directory.path)
    data = msgspec.to_builtins(result)
    data |= {"robot": robot, "wear": wear, "seeds": seeds}
    directory.write_summary(data)
    for key, value in data.items():
        console.print(f"{key}: {value}", highlight=False)
    console.print(f"written to {directory.path}")
    if as_json:
        print(msgspec.json.encode(data).decode(), flush=True)
    return 0 if data["passed"] else 1


def experiments(as_json: options.Json = False) -> int:
    """List the experiments there are."""
    if as_json:
        print(msgspec.json.encode({name: what for name, (_, what) in EXPERIMENTS.items()}).decode())
        return 0
    for name, (_, what) in EXPERIMENTS.items():
        print(f"{name:14} {what}")
    return 0
