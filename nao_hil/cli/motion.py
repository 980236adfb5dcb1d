"""`nao-hil motion`: play a key-frame motion on an emulated robot."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated, Any, Final

import msgspec
import typer

from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ROBOT
from bridge.link.client import WalkClient
from nao_hil.cli import options
from nao_hil.cli.console import Answer, chosen_engine, open_console
from nao_hil.runs.config import run_config

if TYPE_CHECKING:
    from bridge.motion import GetUp, Motion, MotionPlayer
    from emulator.robot import EmulatedRobot

_LONGEST: Final = 120.0
"""s of the clock, longest wait for a motion on the link."""
_POLL_INTERVAL: Final = 0.05
"""s between two queries of the state."""
_BEGINS: Final = 300
"""Cycles after which a motion that was not seen is over: the robot stood already."""


def motion(
    name: Annotated[
        str, typer.Argument(help="A motion's name, get-up, or a file (.toml, .csv).", metavar="NAME|FILE")
    ],
    robot: options.Body = None,
    wear: options.Wear = None,
    engine: options.Engine = None,
    start: options.Start = None,
    seed: options.Seed = None,
    tries: Annotated[
        int | None, typer.Option("--tries", min=1, max=20, help="At most so many tries of get-up; default: 5.")
    ] = None,
    connect: Annotated[
        str | None,
        typer.Option(
            "--connect",
            help="Let the walker of the robot there play it; started with --serve.",
            metavar="ENDPOINT",
        ),
    ] = None,
    name_on_link: options.Name = DEFAULT_ROBOT,
) -> Answer:
    """Play a key-frame motion on an emulated robot in this process; exit code 1: it does not stand then.

    Without --start the robot stands, unless the file has `begins`; another way than one of these is refused.
    `get-up` plays the motion for
    how the robot lies, again until it stands. With --connect the walker that serves a robot plays it, after
    closing the feet; the robot then stands, or rests where the motion ended.

    Example: nao-hil motion get-up --robot nao-v6 --start lie-side --seed 1

    Example: nao-hil motion sit-down --connect tcp/127.0.0.1:7447
    """
    own = {"robot": robot, "wear": wear, "engine": engine, "start": start, "seed": seed}
    if connect is None:
        return _emulated(name, tries, own)
    for option, value in (own | {"tries": tries}).items():
        if value is not None:
            raise ConfigurationError(
                f"--{option} is for a robot in this process; the one at {connect} has its own."
            )
    return _on_link(name, name_on_link, connect)


def _emulated(name: str, tries: int | None, own: dict[str, Any]) -> Answer:
    """Play a motion on a robot in this process.

    Args:
        name: Of the motion, or of its file.
        tries: Of getting up.
        own: The robot's options, as for `run_config`.
    """
    # imported late: help and completion need neither physics nor SciPy
    from bridge.motion import GET_UP, load_motion
    from nao_hil.runs.build import build_robot
    from nao_hil.runs.motion import START_POSES, play

    if tries is not None and name != GET_UP:
        raise ConfigurationError(f"--tries is for {GET_UP}; the motion {name} is played once.")
    chosen = None if name == GET_UP else load_motion(name, (GET_UP,))
    lies = own["start"] or ("lie-back" if chosen is None else START_POSES[chosen.begins[0]])
    console = open_console()
    settings = chosen_engine(run_config(None, **own | {"start": lies}))
    with build_robot(settings) as emulated:
        player = _get_up(emulated, tries) if chosen is None else _player(emulated, name, chosen, lies)
        if chosen is not None and chosen.bodies and emulated.body.base not in chosen.bodies:
            console.print(f"{name} works on {', '.join(chosen.bodies)}; it failed on {emulated.body.name}")
        result = play(emulated, name, player)
    word = "stands" if result.stands else f"does not stand (torso: {result.ended})"
    text = f"{name}: {result.time:.1f} s, begun with the torso: {result.began}; the robot {word}"
    data = msgspec.to_builtins(result) | {"config": msgspec.to_builtins(settings)}
    return Answer(data, lambda: console.print(text), code=0 if result.stands else 1)


def _get_up(robot: EmulatedRobot, tries: int | None) -> GetUp:
    from bridge.motion import GetUp, get_up_motions
    from bridge.motion.get_up import MAX_TRIES

    motions = get_up_motions(robot.body)
    if "back" not in motions:  # where the other ones lead to, or begin
        raise ConfigurationError(f"{robot.body.name} has no motion to get up from its back.")
    return GetUp(motions, robot.body, tries or MAX_TRIES)


def _player(robot: EmulatedRobot, name: str, motion: Motion, start: str) -> MotionPlayer:
    from bridge.motion import MotionPlayer, lying

    side = lying(robot.frame.angle)
    if side not in motion.begins:
        begins = " or ".join(motion.begins)
        raise ConfigurationError(
            f"the motion {name} begins with the torso: {begins}; with --start {start} it is: {side}."
        )
    return MotionPlayer(motion, robot.body, robot.dcm.ahead().position)


def _on_link(motion: str, robot: str, connect: str) -> Answer:
    """Order a motion, and wait for its end."""
    with WalkClient(robot, connect) as walker:
        first = walker.motion(motion)
        open_console().print(first.text)
        state, seen, end = first.state, False, time.monotonic() + _LONGEST
        while time.monotonic() < end:
            status = walker.status()
            state, seen = status.state, seen or status.state == "motion"
            if state in ("stand", "rest", "fallen") and (seen or status.seq > first.seq + _BEGINS):
                break
            time.sleep(_POLL_INTERVAL)
    text = f"{motion}: the robot is in state `{state}`"
    code = 0 if state in ("stand", "rest") else 1
    data = {"motion": motion, "state": state, "stands": state == "stand"}
    return Answer(data, lambda: open_console().print(text), code)
