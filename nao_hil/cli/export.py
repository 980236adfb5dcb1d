"""`nao-hil export`: the calibrated robot for other simulators."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.files import write_text

File = Annotated[Path, typer.Option("--out", help="File to write.", metavar="FILE")]
NOTICE = """
{body} with {wear} drives, exported by nao-hil {version}.
Copyright the authors of nao-hil. Licensed under the Apache License, Version 2.0:
https://www.apache.org/licenses/LICENSE-2.0
SI units and radians. Which numbers are published and which are assumed is in the project's data sheet of the
body and in its wear profile.
"""


def mjcf(
    out: File, robot: options.Body = None, wear: options.Wear = None, as_json: options.Json = False
) -> int:
    """Write the robot as a MuJoCo model: drives with backlash, delay, rotor inertia and friction, soft soles.

    It loads in MuJoCo 3.7 or later without this project (docs/how-to/export.md).

    Example: nao-hil export mjcf --robot nao-v6 --wear worn --out nao.xml
    """
    return _export("mjcf", out, robot, wear, as_json)


def urdf(
    out: File, robot: options.Body = None, wear: options.Wear = None, as_json: options.Json = False
) -> int:
    """Write the robot as URDF: links, masses, joints and shapes, which is all that URDF can say.

    Example: nao-hil export urdf --robot nao-v3 --out nao.urdf
    """
    return _export("urdf", out, robot, wear, as_json)


def _export(form: str, out: Path, robot: str | None, wear: str | None, as_json: bool) -> int:
    # imported late: MuJoCo and the walker's posture solver take time
    from bridge.body import load_body
    from bridge.body.postures import POSTURES
    from emulator.engine.catalogue import require_engine
    from emulator.wear import load_wear
    from nao_hil import __version__
    from nao_hil.experiments.one_leg import one_leg_stance

    body = load_body(robot or "nao-v3")
    profile = load_wear(wear or "nominal", body)
    notice = NOTICE.format(body=body.name, wear=profile.name, version=__version__)
    if form == "mjcf":
        require_engine("mujoco")
        from emulator.export.mjcf import to_mjcf

        poses = {"stand": POSTURES["StandInit"], "one-leg": one_leg_stance(body)}
        text = to_mjcf(body, profile, poses, notice)
    else:
        from emulator.export.urdf import to_urdf

        text = to_urdf(body, profile, notice)
    write_text(out, text)
    open_console().print(f"{body.name} with {profile.name} drives is in {out}.", highlight=False)
    if as_json:
        print(json.dumps({"format": form, "robot": body.name, "wear": profile.name, "file": str(out)}))
    return 0
