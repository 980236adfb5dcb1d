"""Buttons and sliders: each sends one command, and says what came of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, cast

import msgspec

from bridge.errors import NaoHilError
from bridge.faults import ELEMENTS, Fault
from bridge.joints import JOINTS
from bridge.walk import GaitName, TorsoName, WalkCommand
from bridge.world import (
    EndFault,
    Pause,
    PlaceBox,
    PlateUnderFoot,
    Push,
    Reset,
    Resume,
    SetFriction,
    StandUp,
    StartFault,
    TiltFloor,
    WorldCommand,
    least_tilt_time,
)
from lab.view.live import Commands

AS_IS: Final = "as it is"
FAULTS: Final[dict[str, tuple[str, str]]] = {
    "joint-weak": ("joint", "share"),
    "joint-stuck": ("joint", ""),
    "joint-hot": ("joint", ""),
    "sensor-dead": ("sensor", ""),
    "sensor-stuck": ("sensor", ""),
    "sensor-noisy": ("sensor", "deviation"),
    "command-lost": ("", "probability"),
    "inertial-rezero": ("", ""),
    "power-loss": ("", ""),
}
"""Kinds that the page offers: what each strikes, and the number that says how hard."""
SENSORS: Final = tuple(ELEMENTS) + tuple(f"fsr.{cell}" for cell in ELEMENTS["fsr"])

Say = Callable[[str], None]


class Controls:
    """The tabs of commands.

    Args:
        gui: `viser.ViserServer.gui`.
        commands: Where they go.
        say: Shown to the person: what was done, or why not.
    """

    def __init__(self, gui: Any, commands: Commands, say: Say) -> None:
        self._gui, self._commands, self._say = gui, commands, say

    def build(self, tabs: Any, *, world: bool) -> None:
        """Add the tabs to a tab group; `world`: there is one that can be changed."""
        with tabs.add_tab("Walk"):
            self._walk()
        if world:
            with tabs.add_tab("World"):
                self._world()
            with tabs.add_tab("Faults"):
                self._faults()

    def _button(self, label: str, act: Callable[[], str], hint: str = "", color: str | None = None) -> None:
        """A button; `act` does it and returns a sentence."""
        handle = self._gui.add_button(label, hint=hint or None, color=color)

        def pressed(_: object) -> None:
            try:
                self._say(act())
            except NaoHilError as error:
                self._say(str(error))

        handle.on_click(pressed)

    def _do(self, command: WorldCommand) -> str:
        return self._commands.world(command).text

    def _walk(self) -> None:
        gui = self._gui
        self._button("Emergency stop", lambda: self._commands.stop().text, "crouch, then let go", color="red")
        speed = gui.add_slider("speed, m/s", min=-0.05, max=0.2, step=0.005, initial_value=0.05)
        steps = gui.add_number("steps (0: on)", initial_value=0, min=0, step=1)
        gait = gui.add_dropdown("gait", (AS_IS, "static", "dynamic", "huang"))
        torso = gui.add_dropdown("torso control", (AS_IS, "none", "thesis", "robust"))
        admittance = gui.add_dropdown("admittance", (AS_IS, "on", "off"))

        def command(op: Any) -> WalkCommand:
            return WalkCommand(
                op=op,
                velocity=(float(speed.value), 0.0, 0.0) if op == "walk" else None,
                steps=int(steps.value) if op == "walk" else None,
                gait=cast("GaitName | None", _chosen(gait.value)),
                torso=cast("TorsoName | None", _chosen(torso.value)),
                admittance={"on": True, "off": False}.get(admittance.value),
            )

        self._button("Walk", lambda: self._commands.walk(command("walk")).text)
        self._button("Stop", lambda: self._commands.walk(WalkCommand(op="stop")).text, "close the feet, stand")
        self._button(
            "Set gait and control", lambda: self._commands.walk(command("set")).text, "without beginning"
        )
        self._button("Stiffness off", lambda: self._commands.limp().text, "at once: a standing robot falls")
        self._button("Arm", lambda: self._commands.arm().text, "take commands again after a stop")

    def _world(self) -> None:
        gui = self._gui
        impulse = gui.add_slider("push, N s", min=0.1, max=5.0, step=0.1, initial_value=1.0)
        direction = gui.add_slider(
            "direction, deg", min=-180, max=180, step=15, initial_value=90, hint="0 forward, 90 to the left"
        )

        def push() -> str:
            size, angle = float(impulse.value), math.radians(float(direction.value))
            return self._do(Push(impulse=(size * math.cos(angle), size * math.sin(angle), 0.0)))

        self._button("Push", push)
        roll = gui.add_slider("floor roll, deg", min=-15, max=15, step=0.5, initial_value=0)
        pitch = gui.add_slider("floor pitch, deg", min=-15, max=15, step=0.5, initial_value=0)
        self._button("Tilt the floor", lambda: self._tilt(float(roll.value), float(pitch.value)))
        plate = gui.add_slider("plate, mm", min=1, max=40, step=1, initial_value=10)

        def height() -> float:
            return 1e-3 * float(plate.value)

        self._button(
            "Plate under the swing foot", lambda: self._do(PlateUnderFoot(size=(0.16, 0.08, height())))
        )
        self._button(
            "Plate ahead",
            lambda: self._do(PlaceBox(name="ahead", size=(0.2, 0.4, height()), at=(0.25, 0.0), frame="robot")),
        )
        friction = gui.add_slider("friction", min=0.02, max=1.2, step=0.02, initial_value=0.8)
        self._button("Set friction", lambda: self._do(SetFriction(friction=float(friction.value))))
        self._button("Stand up", lambda: self._do(StandUp()), "put the robot back on its feet")
        self._button("Pause", lambda: self._do(Pause()))
        self._button("Resume", lambda: self._do(Resume()))
        self._button("Reset", lambda: self._do(Reset()), "begin anew")

    def _tilt(self, roll: float, pitch: float) -> str:
        x, y = math.radians(roll), math.radians(pitch)
        # From wherever it is now: at most the way from one end of the sliders to the other.
        duration = max(1.0, 1.05 * least_tilt_time(max(abs(x), abs(y)) + math.radians(15.0)))
        return self._do(TiltFloor(roll=x, pitch=y, duration=duration))

    def _faults(self) -> None:
        gui = self._gui
        kind = gui.add_dropdown("fault", tuple(FAULTS))
        joint = gui.add_dropdown("joint", JOINTS, initial_value="LKneePitch")
        sensor = gui.add_dropdown("sensor", SENSORS, initial_value="gyroscope")
        amount = gui.add_slider("amount", min=0.0, max=1.0, step=0.05, initial_value=0.5)
        targets = {"joint": joint, "sensor": sensor}

        def start() -> str:
            target, number = FAULTS[kind.value]
            fields: dict[str, Any] = {"kind": kind.value}
            if target:
                fields[target] = targets[target].value
            if number:
                fields[number] = float(amount.value)
            fault = msgspec.convert(fields, Fault)
            return self._do(StartFault(fault=fault))

        self._button("Begin the fault", start, "amount: share of the torque, probability, or deviation")
        self._button("End all faults", lambda: self._do(EndFault()))


def _chosen(value: str) -> str | None:
    return None if value == AS_IS else value
