"""`nao-hil drive`: walk a robot by hand."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from rich.live import Live
from rich.table import Table

from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.client import WalkClient
from bridge.types import Vec3
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console
from nao_hil.cli.signals import stop_event
from nao_hil.drive.driver import HELP
from nao_hil.drive.inputs import Inputs

if TYPE_CHECKING:
    from nao_hil.drive.session import Session

_POLL_INTERVAL: Final = 0.25
"""s between two queries of the robot while no key is pressed."""


def drive(
    gamepad: Annotated[
        Path | None,
        typer.Option(
            "--gamepad",
            help="Joystick device, as /dev/input/js0: left stick walks, buttons stop and switch.",
            metavar="DEVICE",
        ),
    ] = None,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Walk a robot by the keys of this terminal; its walker runs with --serve.

    The robot stops three seconds after the driver's last word, should this terminal or the line break.

    Example: nao-hil up --serve        (in another terminal: nao-hil drive)

    Example: nao-hil drive --gamepad /dev/input/js0 --connect tcp/192.168.1.7:7447
    """
    # imported late: the walk needs SciPy, which help and completion need not wait for
    from nao_hil.drive.session import Session

    stop = stop_event()
    with Inputs(gamepad) as inputs, WalkClient(name, connect) as client:
        session = Session(client)
        with Live(console=open_console(), auto_refresh=False) as live:
            try:
                while not stop.is_set() and not session.target.leave:
                    live.update(picture(session), refresh=True)
                    taken = inputs.wait(_POLL_INTERVAL)
                    session.take(taken.keys if taken.open else ["Q"], taken.stick)
            finally:
                session.end()
            live.update(picture(session), refresh=True)
    return Answer(outcome(session, name, connect, gamepad))


def outcome(session: Session, name: str, connect: str, gamepad: Path | None) -> dict[str, Any]:
    """JSON of the command: outcome, input device, and gait and controllers of the walker."""
    status = session.status
    return {
        "position": status.position,
        "commands": session.commands,
        "refused": session.refused,
        "config": {
            "name": name,
            "connect": connect,
            "gamepad": gamepad and str(gamepad),
            "gait": status.gait,
            "torso": status.torso,
            "admittance": status.admittance,
        },
    }


def picture(session: Session) -> Table:
    """Picture for the terminal: state of the robot and the keys."""
    s = session.status
    table = Table(show_header=False, title="nao-hil drive")
    x, y, yaw = s.position
    where = f"x {x:.3f} m, y {y:.3f} m, heading {math.degrees(yaw):.0f} deg by odometry"
    table.add_row("robot", f"{s.state}, step {s.steps}; {where}")
    table.add_row("wanted", _in_words(session.driver.velocity(session.target)))
    table.add_row("walks", _in_words(s.velocity))
    control = f"{s.gait} gait, torso control {s.torso}, admittance {'on' if s.admittance else 'off'}"
    table.add_row("controllers", control)
    table.add_row("keys", "; ".join(f"{keys}: {what}" for keys, what in HELP.items()))
    table.add_row("walker", session.reply)
    return table


def _in_words(velocity: Vec3) -> str:
    x, y, turn = velocity
    rest = f", {y:+.3f} m/s sideways, {turn:+.2f} rad/s" if y or turn else ""
    return f"{x:.3f} m/s{rest}" if any(velocity) else "stand"
