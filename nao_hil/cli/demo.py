"""`nao-hil demo`: what the project can do, in under a minute."""

from __future__ import annotations

from typing import Annotated

import typer

from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.session import check_free
from nao_hil.cli import options
from nao_hil.cli.console import chosen_engine, open_console, own_command
from nao_hil.cli.up import both_sides, new_folder
from nao_hil.runs.config import run_config
from nao_hil.runs.demo import GAIT, ROBOT, Demo
from nao_hil.view.child import DEFAULT_PORT


def demo(
    view: Annotated[
        bool, typer.Option("--view/--no-view", help="Serve the live page meanwhile, as `nao-hil view` does.")
    ] = True,
    port: options.Port = DEFAULT_PORT,
    engine: options.Engine = None,
    mode: options.Mode = None,
    seed: options.Seed = None,
    listen: options.Listen = DEFAULT_ENDPOINT,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    as_json: options.Json = False,
) -> int:
    """Show a walk in all directions, a push and a stop in under a minute, with what to look at.

    Example: nao-hil demo --seed 3
    """
    settings = run_config(None, robot=ROBOT, gait=GAIT, engine=engine, mode=mode, seed=seed, steps=0)
    settings = chosen_engine(settings, open_console())
    check_free(listen)  # the demo would command the robot that is there
    directory = new_folder(settings, out, overwrite=overwrite)
    with Demo(DEFAULT_ROBOT, listen) as play:
        code = both_sides(
            settings,
            directory,
            DEFAULT_ROBOT,
            listen,
            serve=True,
            port=port if view else None,
            as_json=as_json,
            demo=play,
        )
    open_console().print(
        f"walk it, push it: {own_command()} up --serve --view --robot {ROBOT} --gait {GAIT}\n"
        f"the thesis' experiments: {own_command()} experiment all --out DIR",
        highlight=False,
    )
    return code
