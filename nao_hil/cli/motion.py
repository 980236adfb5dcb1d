"""`nao-hil motion`: play a key-frame motion on an emulated robot."""

from __future__ import annotations

import json
from typing import Annotated

import msgspec
import typer

from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.runs.config import run_config


def motion(
    name: Annotated[str, typer.Argument(help="A motion's name, or a file (.toml, .csv).", metavar="NAME|FILE")],
    robot: options.Body = None,
    wear: options.Wear = None,
    start: options.Start = None,
    seed: options.Seed = None,
    tries: Annotated[int, typer.Option("--tries", min=1, max=20, help="At most so many tries.")] = 1,
    as_json: options.Json = False,
) -> int:
    """Play a key-frame motion on an emulated robot in this process, and tell whether it stands.

    Without --start the robot lies as the motion begins.

    Example: nao-hil motion get-up-front --robot nao-v6 --seed 1
    """
    # imported late: help and completion need neither physics nor SciPy
    from nao_hil.runs.build import build_robot
    from nao_hil.runs.motion import play
    from walker.planning.motion import load_motion

    wanted = load_motion(name)
    lies = {
        "back": "lie-back",
        "front": "lie-front",
        "left": "lie-side",
        "right": "lie-side",
        "upright": "stand",
    }
    settings = run_config(None, robot=robot, wear=wear, start=start or lies[wanted.begins[0]], seed=seed)
    console = open_console()
    with build_robot(settings) as body:
        if wanted.bodies and body.body.name not in wanted.bodies:
            console.print(f"{name} works on {', '.join(wanted.bodies)}; it failed on {body.body.name}")
        result = play(body, name, lambda _: wanted, tries=tries)
    if not as_json:
        word = "stands" if result.stands else f"does not stand (torso: {result.ended})"
        console.print(f"{name}: {result.time:.1f} s, begun with the torso: {result.began}; the robot {word}")
    else:
        print(json.dumps(msgspec.to_builtins(result)))
    return 0 if result.stands else 1
