"""`nao-hil motion`: play a key-frame motion on an emulated robot."""

from __future__ import annotations

import json
from typing import Annotated, Final

import msgspec
import typer

from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.cli.engine import chosen_engine
from nao_hil.runs.config import run_config

GET_UP: Final = "get-up"
"""In place of a motion's name: the one for how the robot lies, again until it stands."""


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
    as_json: options.Json = False,
) -> int:
    """Play a key-frame motion on an emulated robot in this process, and tell whether it stands.

    Without --start the robot lies as the motion begins. `get-up` plays the motion for how the robot lies, again
    until it stands.

    Example: nao-hil motion get-up --robot nao-v6 --start lie-side --seed 1
    """
    # imported late: help and completion need neither physics nor SciPy
    from bridge.motion import GetUp, MotionPlayer, get_up_motions, load_motion
    from bridge.motion.get_up import TRIES
    from nao_hil.runs.build import build_robot
    from nao_hil.runs.motion import BEGINS, play

    chooses = name == GET_UP
    if tries is not None and not chooses:
        raise ConfigurationError(f"--tries is for {GET_UP}; the motion {name} is played once.")
    wanted = None if chooses else load_motion(name, (GET_UP,))
    lies = start or ("lie-back" if wanted is None else BEGINS[wanted.begins[0]])
    console = open_console()
    settings = chosen_engine(
        run_config(None, robot=robot, wear=wear, engine=engine, start=lies, seed=seed), console
    )
    with build_robot(settings) as body:
        if wanted is None:
            player: GetUp | MotionPlayer = GetUp(get_up_motions(body.body), body.body, tries or TRIES)
        else:
            player = MotionPlayer(wanted, body.body)
            if wanted.bodies and body.body.name not in wanted.bodies:
                console.print(f"{name} works on {', '.join(wanted.bodies)}; it failed on {body.body.name}")
        result = play(body, name, player)
    if not as_json:
        word = "stands" if result.stands else f"does not stand (torso: {result.ended})"
        console.print(f"{name}: {result.time:.1f} s, begun with the torso: {result.began}; the robot {word}")
    else:
        print(json.dumps(msgspec.to_builtins(result)))
    return 0 if result.stands else 1
