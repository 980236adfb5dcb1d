"""`nao-hil drive`: walk a robot by hand."""

from __future__ import annotations

import json
import threading
import time
from pathlib import Path
from typing import Annotated, Final

import typer
from rich.console import Console
from rich.live import Live
from rich.table import Table

from bridge.errors import LinkError, WalkRefused
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.walk_client import WalkClient
from bridge.messages import Vec3
from bridge.walk import WalkCommand, WalkStatus
from lab.cli import options
from lab.cli.signals import on_signals
from lab.drive.driver import HELP, Driver, Wheel
from lab.drive.inputs import Inputs
from walker.gait import gait_parameters
from walker.gait.speed import STEPS, step_of

_LOOK: Final = 0.25
"""s between two looks at the robot while no key is pressed."""
_SIGN: Final = 1.0
"""s between two signs of life of the driver."""


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
    as_json: options.Json = False,
) -> int:
    """Walk a robot by the keys of this terminal; its walker was started with --serve.

    The robot stops three seconds after the driver's last word, should this terminal or the line break.

    Example: nao-hil up --serve        (in another terminal: nao-hil drive)

    Example: nao-hil drive --gamepad /dev/input/js0 --connect tcp/192.168.1.7:7447
    """
    stop = threading.Event()
    on_signals(stop.set)
    with Inputs(gamepad) as inputs, WalkClient(name, connect) as client:
        session = Session(client)
        with Live(console=Console(stderr=True), auto_refresh=False) as live:
            try:
                while not stop.is_set() and not session.wheel.leave:
                    live.update(session.picture(), refresh=True)
                    taken = inputs.wait(_LOOK)
                    session.take(taken.keys if taken.open else ["Q"], taken.stick)
            finally:
                session.end()
            live.update(session.picture(), refresh=True)
    if as_json:
        position = session.status.position
        result = {"position": position, "commands": session.commands, "refused": session.refused}
        print(json.dumps(result), flush=True)
    return 0


class Session:
    """One driver at the wheel of one walker.

    Raises:
        LinkError: no walker there takes commands.
        WalkRefused: the walker has no robot.
    """

    def __init__(self, client: WalkClient) -> None:
        self._client = client
        self._driver = Driver({gait: step_of(gait, gait_parameters(gait)).velocity for gait in STEPS})
        self.status: WalkStatus = client.status()
        self.wheel = self._driver.at_rest(self.status)
        self.commands = self.refused = 0
        self._said = ""
        self._spoke = time.monotonic()

    def take(self, keys: list[str], stick: float | None) -> None:
        """Carry out what came in, and look how the robot is."""
        for key in keys:
            self._turn(self._driver.press(self.wheel, key))
        if stick is not None:
            self._turn(self._driver.stick(self.wheel, stick))
        again = self._driver.again(self.wheel)
        if again is not None and time.monotonic() - self._spoke > _SIGN:
            if not self._send(again):  # it fell, say: whoever wants to go on says so anew
                self.wheel = self._driver.press(self.wheel, "x")
        else:
            self.status = self._client.status()

    def _turn(self, wheel: Wheel) -> None:
        command = self._driver.command(self.wheel, wheel)
        if command is None or self._send(command):
            self.wheel = wheel  # a wheel that the walker refused turns back

    def _send(self, command: WalkCommand) -> bool:
        self.commands += 1
        self._spoke = time.monotonic()
        try:
            self.status = self._client.send(command)
        except WalkRefused as refusal:
            self.refused += 1
            self._said = str(refusal)
            return False
        self._said = self.status.text
        return True

    def end(self) -> None:
        """Leave the robot standing."""
        try:
            self.status = self._client.stop()
        except (LinkError, WalkRefused):
            self._said = "The walker does not answer any more."

    def picture(self) -> Table:
        """What the driver sees."""
        s = self.status
        table = Table(show_header=False, title="nao-hil drive")
        table.add_row("robot", f"{s.state}, step {s.steps}, x {s.position[0]:.3f} m by the plan")
        table.add_row("wanted", _in_words(self._driver.velocity(self.wheel)))
        table.add_row("walks", _in_words(s.velocity))
        control = f"{s.gait} gait, torso control {s.torso}, admittance {'on' if s.admittance else 'off'}"
        table.add_row("controllers", control)
        table.add_row("keys", "; ".join(f"{keys}: {what}" for keys, what in HELP.items()))
        table.add_row("walker", self._said)
        return table


def _in_words(velocity: Vec3) -> str:
    x, y, turn = velocity
    rest = f", {y:+.3f} m/s sideways, {turn:+.2f} rad/s" if y or turn else ""
    return f"{x:.3f} m/s{rest}" if any(velocity) else "stand"
