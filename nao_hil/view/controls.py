"""Buttons and sliders: each sends one command, and says what came of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any, Final, cast, get_args

from bridge.body.joints import JOINTS
from bridge.errors import NaoHilError
from bridge.messages.elements import ELEMENTS
from bridge.messages.faults import Fault
from bridge.messages.guard import GuardStatus
from bridge.messages.walk import TorsoName, WalkCommand
from bridge.messages.world import (
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
    Step,
    TiltFloor,
    WorldCommand,
    min_tilt_duration,
)
from bridge.validation import convert
from nao_hil.view.driving import Driving
from nao_hil.view.live import Commands
from nao_hil.view.pad import Pad
from nao_hil.view.page import TOP
from nao_hil.view.scene.lines import show
from nao_hil.view.slow_motion import SPEEDS, SlowMotion
from walker.planning.catalogue import GAITS, gait_parameters

AS_IS: Final = "as it is"
FAULTS: Final[dict[str, tuple[str, str]]] = {
    "joint-weak": ("joint", "fraction"),
    "joint-stuck": ("joint", ""),
    "joint-limp": ("joint", ""),
    "joint-hot": ("joint", ""),
    "sensor-dead": ("sensor", ""),
    "sensor-stuck": ("sensor", ""),
    "sensor-noisy": ("sensor", "deviation"),
    "command-lost": ("", "probability"),
    "inertial-rezero": ("", ""),
    "hal-error": ("", ""),
    "power-loss": ("", ""),
}
"""Kinds that the page offers: what each strikes, and the number that says how hard."""
SENSORS: Final = tuple(ELEMENTS) + tuple(f"fsr.{cell}" for cell in ELEMENTS["fsr"])

BY_KEYS: Final = (
    "w faster, s slower, a and d turn, q and e sideways, space stop, g gait, t torso control, m admittance; "
    "a gamepad's left stick walks"
)

PAD_VELOCITY: Final = (0.35, 0.2, 1.5)
"""At the edges of the pad, m/s, m/s, rad/s: the limits of `omni`."""
PAD_PUSH: Final = 3.0
"""Likewise, N s."""

Say = Callable[[str], None]
Act = Callable[[], str]
Aim = Callable[[tuple[float, float]], None]


class Controls:
    """The buttons that never move, at the top of the panel, and the tabs of commands.

    Args:
        gui: `viser.ViserServer.gui`.
        commands: Where they go.
        driving: The wheel.
        say: Shown to the person: what was done, or why not.
        aim: Shown as an arrow: the impulse of the next push, N s, ahead and to the left of the robot.
        cycle: The robot's cycle, s.
    """

    def __init__(
        self,
        gui: Any,
        commands: Commands,
        driving: Driving,
        say: Say,
        aim: Aim,
        cycle: float,
    ) -> None:
        self._gui, self._commands, self._driving, self._say, self._aim = gui, commands, driving, say, aim
        self._slow = SlowMotion(commands.world, cycle)

    def build(self, tabs: Any, *, world: bool) -> None:
        """Add the tabs to a tab group; `world`: there is one that can be changed."""
        self._button(
            "Emergency stop",
            self._other(lambda: self._of_guard(self._commands.stop())),
            "The robot crouches, lets go, and takes no command until it is armed again.",
            color="red",
            order=TOP,
        )
        with tabs.add_tab("Walk"):
            self._steer()
            walk = self._walk()
            self._drive()
            self._motors()
        if world:
            with tabs.add_tab("World"):
                self._again()
                self._push()
                self._floor()
                self._plates()
            with tabs.add_tab("Faults"):
                self._faults()
        sit = self._other(lambda: self._commands.walk(WalkCommand(op="motion", motion="sit-down")).text)
        acts: dict[str, Act] = {"Walk": walk, "Stop": self._stop, "Sit": sit}
        self._go = self._buttons("walk", acts, order=TOP + 0.1)  # a hint would cover the emergency stop
        arm = self._other(lambda: self._of_guard(self._commands.arm()))
        self._arm = self._button(
            "Arm", arm, "Take commands again after a stop.", color="green", order=TOP + 0.1, visible=False
        )

    def drag(self, impulse: tuple[float, float], done: bool) -> None:
        """A person drags the robot: aim a push of this impulse, N s, ahead and to the left, or give it."""
        x, y = (max(-PAD_PUSH, min(PAD_PUSH, part)) for part in impulse)
        self._aim((x, y))
        if done:
            self._tell(lambda: self._do(Push(impulse=(x, y, 0.0))))

    def show_armed(self, armed: bool) -> None:
        """Show Walk and Stop where the robot takes commands, and Arm in their place where it takes none."""
        if self._arm.visible == armed:
            self._go.visible, self._arm.visible = armed, not armed

    def end(self) -> None:
        """Leave a world that goes on. Raises LinkError when nobody answers."""
        self._slow.end()

    def show_gait(self, gait: str) -> None:
        """Offer the directions that a gait can go."""
        everywhere = _everywhere(gait)
        self._velocity.show(everywhere)
        for row in self._rows:
            show(row, everywhere)
        show(self._speed, not everywhere)

    def _of_guard(self, status: GuardStatus) -> str:
        self.show_armed(status.armed)
        return status.text

    def _button(self, label: str, act: Act, hint: str = "", **looks: Any) -> Any:
        """A button; `act` does it and returns a sentence."""
        handle = self._gui.add_button(label, hint=hint or None, **looks)
        handle.on_click(lambda _: self._tell(act))
        return handle

    def _buttons(self, label: str, acts: Mapping[str, Act], hint: str = "", **looks: Any) -> Any:
        """Small buttons side by side."""
        handle = self._gui.add_button_group(label, tuple(acts), hint=hint or None, **looks)
        handle.on_click(lambda event: self._tell(acts[event.target.value]))
        return handle

    def _tell(self, act: Act) -> None:
        try:
            self._say(act())
        except NaoHilError as error:
            self._say(str(error))

    def _other(self, act: Act) -> Act:
        """An act after which nobody is at the wheel any more."""

        def let_go_and_act() -> str:
            self._driving.let_go()
            return act()

        return let_go_and_act

    def _at(self, command: WorldCommand) -> str:
        """A command to the world's time ends slow motion."""
        self._slow.stop()
        return self._do(command)

    def _do(self, command: WorldCommand) -> str:
        return self._commands.world(command).text

    def _stop(self) -> str:
        self._velocity.reset()
        return self._driving.press("Stop")

    def _walk(self) -> Act:
        """The settings of the next walk; what begins it."""
        gui = self._gui

        def command(op: Any) -> WalkCommand:
            """As the fields of the tab say."""
            walks, speed = op == "walk", float(self._speed.value) if self._speed.visible else 0.0
            return WalkCommand(
                op=op,
                velocity=(speed, 0.0, 0.0) if walks and speed else None,
                steps=int(steps.value) if walks else None,
                gait=_chosen(gait.value),
                torso=cast("TorsoName | None", _chosen(torso.value)),
                admittance={"on": True, "off": False}.get(admittance.value),
            )

        self._speed = gui.add_slider(
            "speed, m/s",
            min=0.0,
            max=0.25,
            step=0.005,
            initial_value=0.0,
            hint="0: as it is, at first the gait's own; the walker refuses what the robot cannot reach",
        )
        steps = gui.add_number("steps", initial_value=0, min=0, step=1, hint="0: until it is told to stop")
        gait = gui.add_dropdown("gait", (AS_IS, *GAITS), hint="another one begins at a stand")
        torso = gui.add_dropdown(
            "torso control", (AS_IS, *get_args(TorsoName)), hint="what keeps the torso upright"
        )
        admittance = gui.add_dropdown(
            "admittance", (AS_IS, "on", "off"), hint="legs and ankles that give way to the ground"
        )
        self._button(
            "Set without walking",
            self._other(lambda: self._commands.walk(command("set")).text),
            "a walk that is under way goes on, changed as far as that can be had in stride",
        )
        return self._other(lambda: self._commands.walk(command("walk")).text)

    def _steer(self) -> None:
        """A pad for the velocity."""

        def steer(velocity: tuple[float, ...]) -> None:
            x, y, turn = velocity
            self._tell(lambda: self._driving.steer((x, y, turn)))

        hint = "forward and to the left, m/s, and turn, rad/s"
        self._velocity = Pad(self._gui, "velocity", PAD_VELOCITY, (0.0, 0.0, 0.0), hint, steer)

    def _drive(self) -> None:
        """Buttons of the wheel, which keys and a gamepad press too."""
        gui = self._gui

        def acts(*names: str) -> dict[str, Act]:
            return {name: partial(self._driving.press, name) for name in names}

        with gui.add_folder("Drive"):
            self._rows = [
                self._buttons("sideways", acts("Left", "Right"), "0.02 m/s each"),
                self._buttons("turn", acts("Turn left", "Turn right"), "0.1 rad/s each"),
            ]
            self._buttons("ahead", acts("Slower", "Faster"), "five presses to the gait's own speed")
            self._buttons("next", acts("Gait", "Torso control", "Admittance"))
            keys = gui.add_checkbox("keys, gamepad", initial_value=False, hint=BY_KEYS)
            words = gui.add_markdown(f'<span class="keys-drive">{BY_KEYS}</span>', visible=False)

        def explain(_: object) -> None:
            words.visible = keys.value

        keys.on_update(explain)

    def _motors(self) -> None:
        with self._gui.add_folder("Motors"):
            limp = self._other(lambda: self._of_guard(self._commands.limp()))
            self._button("Let go", limp, "Stiffness off at once: a standing robot falls.")

    def _again(self) -> None:
        acts = {"Stand up": lambda: self._do(StandUp()), "Reset": self._other(lambda: self._do(Reset()))}
        self._buttons("robot", acts, "Stand up: put it back on its feet. Reset: all begins anew.")
        acts = {"Pause": lambda: self._at(Pause()), "Resume": lambda: self._at(Resume())}
        self._buttons("time", acts | {"Step": lambda: self._at(Step())}, "Step: one cycle, then it is paused.")
        speed = self._gui.add_dropdown("slow motion", SPEEDS, hint="robot time per time of the clock")
        speed.on_update(lambda _: self._tell(lambda: self._slow.set_speed(float(speed.value))))

    def _push(self) -> None:
        with self._gui.add_folder("Push"):
            hint = "an arrow shows it; forward and to the left, N s"

            def aim(impulse: tuple[float, ...]) -> None:
                self._aim((impulse[0], impulse[1]))

            pad = Pad(self._gui, "impulse, N s", (PAD_PUSH, PAD_PUSH), (0.0, 1.0), hint, aim)

            def push() -> str:
                x, y = pad.numbers
                self._aim((x, y))
                return self._do(Push(impulse=(x, y, 0.0)))

            self._button("Push", push, "or hold Shift and drag the robot")

    def _floor(self) -> None:
        gui = self._gui
        with gui.add_folder("Floor"):
            roll = gui.add_slider(
                "roll, deg", min=-15, max=15, step=0.5, initial_value=0, hint="positive: the left side higher"
            )
            pitch = gui.add_slider(
                "pitch, deg", min=-15, max=15, step=0.5, initial_value=0, hint="positive: downhill"
            )
            self._button("Tilt the floor", lambda: self._tilt(float(roll.value), float(pitch.value)))
            friction = gui.add_slider(
                "friction", min=0.02, max=1.2, step=0.02, initial_value=0.8, hint="of the soles, 0.8 at first"
            )
            self._button("Set friction", lambda: self._do(SetFriction(friction=float(friction.value))))

    def _plates(self) -> None:
        gui = self._gui
        with gui.add_folder("Plates"):
            plate = gui.add_slider("height, mm", min=1, max=40, step=1, initial_value=10)

            def height() -> float:
                return 1e-3 * float(plate.value)

            self._button(
                "Plate under the swing foot", lambda: self._do(PlateUnderFoot(size=(0.16, 0.08, height())))
            )

            def place() -> str:
                size = (0.2, 0.4, height())
                return self._do(PlaceBox(name="ahead", size=size, at=(0.25, 0.0), frame="robot"))

            self._button("Plate ahead", place)

    def _tilt(self, roll: float, pitch: float) -> str:
        x, y = math.radians(roll), math.radians(pitch)
        # From wherever it is now: at most the way from one end of the sliders to the other.
        duration = max(1.0, 1.05 * min_tilt_duration(max(abs(x), abs(y)) + math.radians(15.0)))
        return self._do(TiltFloor(roll=x, pitch=y, duration=duration))

    def _faults(self) -> None:
        gui = self._gui
        kind = gui.add_dropdown("fault", tuple(FAULTS))
        joint = gui.add_dropdown("joint", JOINTS, initial_value="LKneePitch")
        sensor = gui.add_dropdown("sensor", SENSORS, initial_value="gyroscope")
        amount = gui.add_slider(
            "amount",
            min=0.0,
            max=1.0,
            step=0.05,
            initial_value=0.5,
            hint="fraction of the torque, probability, deviation",
        )
        targets = {"joint": joint, "sensor": sensor}

        def start() -> str:
            """Start the fault that is chosen."""
            target, number = FAULTS[kind.value]
            fields: dict[str, Any] = {"kind": kind.value}
            if target:
                fields[target] = targets[target].value
            if number:
                fields[number] = float(amount.value)
            fault = convert(fields, Fault)
            return self._do(StartFault(fault=fault))

        self._button("Begin the fault", start)
        self._button("End all faults", lambda: self._do(EndFault()))


def _chosen(value: str) -> str | None:
    """A dropdown's value; None where it stands at `AS_IS`."""
    return None if value == AS_IS else value


@cache
def _everywhere(gait: str) -> bool:
    """Whether a gait goes in any direction."""
    return gait in GAITS and gait_parameters(gait).limits is not None
