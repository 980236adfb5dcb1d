"""From keys, terminals' bytes and a joystick's events to walk commands."""

from __future__ import annotations

import struct

import pytest

from bridge.messages.walk import WalkCommand, WalkStatus
from nao_hil.drive.driver import HOLD, SPEED_STEPS, Driver, DriveTarget, keys_of, speed_steps
from nao_hil.drive.inputs import events_of
from nao_hil.drive.session import Session
from tests.frames import walk_status

DRIVER = Driver({"static": 0.015, "dynamic": 0.2})
REST = DriveTarget("static", "robust", admittance=True)


def typed(keys: list[str], target: DriveTarget = REST) -> DriveTarget:
    for key in keys:
        target = DRIVER.press(target, key)
    return target


@pytest.mark.parametrize(
    ("data", "keys"),
    [
        (b"wws", ["w", "w", "s"]),
        (b"\x1b[A\x1bOB\x1b[C\x1b[D", ["w", "s", "d", "a"]),
        (b"\x1b", ["Esc"]),
        (b"w\x1b[5~x", ["w", "x"]),
        (b"\x1b[15~\x1b[Aq", ["w", "q"]),
        (b"\xc3\xa4", ["\xc3", "\xa4"]),
        (b"", []),
    ],
)
def test_bytes_of_a_terminal_become_keys(data: bytes, keys: list[str]) -> None:
    assert keys_of(data) == keys


def test_keys_become_commands() -> None:
    assert DRIVER.command(REST, typed(["w"])) == WalkCommand(op="walk", velocity=(0.003, 0.0, 0.0), hold=HOLD)
    walking = typed(["w", "w"])
    assert DRIVER.command(walking, typed([" "], walking)) == WalkCommand(op="stop")
    assert DRIVER.command(walking, typed(["s", "s"], walking)) == WalkCommand(op="stop")
    assert DRIVER.command(REST, typed(["t"])) == WalkCommand(op="set", torso="none")
    assert DRIVER.command(REST, typed(["m"])) == WalkCommand(op="set", admittance=False)
    assert DRIVER.command(walking, typed(["a"], walking)) == WalkCommand(
        op="walk", velocity=(0.006, 0.0, 0.1), hold=HOLD
    )
    assert DRIVER.command(walking, typed(["Esc"], walking)) == WalkCommand(op="stop")
    assert DRIVER.command(walking, typed(["?", "F", "\xc3"], walking)) is None


class Walks:
    """A walker that somebody else made walk."""

    def __init__(self) -> None:
        self.sent: list[WalkCommand] = []

    def status(self) -> WalkStatus:
        return walk_status(state="walk", velocity=(0.0076, 0.0, 0.0))

    def send(self, command: WalkCommand) -> WalkStatus:
        self.sent.append(command)
        return self.status()

    def stop(self) -> WalkStatus:
        return self.send(WalkCommand(op="stop"))


def test_a_stop_is_told_also_to_a_robot_that_seems_to_stand() -> None:
    for key in (" ", "x"):
        assert DRIVER.command(REST, typed([key]), key) == WalkCommand(op="stop")


@pytest.mark.parametrize("key", [" ", "x", "g", "w"])
def test_whoever_takes_over_a_walking_robot_is_obeyed(key: str) -> None:
    walker = Walks()
    session = Session(walker)
    session.take([])
    assert walker.sent == []  # not before a key
    session.take([key])
    (command,) = walker.sent
    own = session.driver.speeds["static"] / SPEED_STEPS
    steps = round(0.0076 / own)
    if key == "w":
        assert command.velocity == pytest.approx(((steps + 1) * own, 0.0, 0.0))
    elif key == "g":
        assert command.op == "walk" and command.gait not in (None, "static")
    else:
        assert command == WalkCommand(op="stop")


def test_another_gait_begins_slowly() -> None:
    """Five steps of speed of the static gait are 0.015 m/s, of the dynamic one 0.2 m/s: nobody meant that."""
    fast = typed(["w"] * 5, DriveTarget("static", "robust", admittance=True))
    command = DRIVER.command(fast, typed(["g"], fast))
    assert command == WalkCommand(op="walk", velocity=(0.04, 0.0, 0.0), gait="dynamic", hold=HOLD)


@pytest.mark.parametrize(
    ("deflection", "steps"), [(0.0, 0), (0.1, 0), (-0.14, 0), (0.3, 1), (1.0, 5), (1.2, 5), (-1.0, -5)]
)
def test_the_stick_has_a_dead_zone_and_five_notches(deflection: float, steps: int) -> None:
    assert speed_steps(deflection) == steps
    assert DRIVER.stick(REST, deflection).forward == steps


def test_events_of_the_kernel_s_joystick_interface() -> None:
    """struct js_event: u32 time, s16 value, u8 type (1 button, 2 axis, 0x80 initial), u8 number; up is < 0."""
    events = [
        struct.pack("<IhBB", 0, 0, 0x81, 0),  # the state when the device was opened
        struct.pack("<IhBB", 1, -32767, 2, 1),
        struct.pack("<IhBB", 2, 1, 1, 0),
        struct.pack("<IhBB", 3, 0, 1, 0),
        struct.pack("<IhBB", 4, 1, 1, 1),
        struct.pack("<IhBB", 5, 20000, 2, 0),  # the other axis of the stick
    ]
    assert events_of(b"".join(events)) == ([" ", "g"], pytest.approx(1.0))
    assert events_of(events[0]) == ([], None)
    assert events_of(struct.pack("<IhBB", 0, 0, 0x82, 1) + b"\x00\x01") == ([], pytest.approx(0.0))
