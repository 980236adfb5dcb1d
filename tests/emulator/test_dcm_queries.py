"""The handlers of the `dcm/` queries: what they answer, and that nothing but a sentence meets a wrong query."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import msgspec
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.dcm import Dcm
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.errors import DcmRefused, FrameError, LeaseRefused
from bridge.messages import ActuatorFrame, SensorFrame, decode
from bridge.messages import dcm as wire
from emulator.queries import DcmQueries
from emulator.robot import EmulatedRobot
from emulator.timing import BoundaryQueue
from tests.frames import standing_frame

LED = "ChestBoard/Led/Red/Actuator/Value"
LEASE = 4711
REFUSED = (wire.PREFERENCES, wire.SPECIAL, wire.CALIBRATION)
COMMANDS = (wire.CREATE_ALIAS, wire.SET, wire.SET_ALIAS)
KEYS = (*COMMANDS, wire.GET_TIME, wire.GET_PREFIX, wire.READ, *REFUSED)
FRAME = standing_frame(position=POSTURES["Stand"])  # fmt: skip


@dataclass
class Robot:
    """What the queries see of a robot."""

    dcm: Dcm
    frame: SensorFrame = FRAME


class Bench:
    """Handlers whose boundary comes at once, in the thread that asks."""

    def __init__(self) -> None:
        self.robot = Robot(Dcm(load_body("nao-v3"), POSTURES["Stand"]))
        self.holder = LEASE
        boundary = BoundaryQueue(wake=lambda: boundary.run())
        self.handlers = DcmQueries(self.robot, boundary, self.require_lease).handlers()

    def require_lease(self, lease: int, what: str) -> None:
        if lease != self.holder:
            raise LeaseRefused(f"{what} was refused: `walker` holds the robot.")

    def ask(self, key: str, **fields: Any) -> Any:
        payload = msgspec.msgpack.encode({"version": 3, **fields})
        return decode(self.handlers[key](payload), wire.DcmReply).result

    def command(self, key: str, command: Any, lease: int = LEASE) -> Any:
        return self.ask(key, lease=lease, command=command)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def sentence(error: BaseException) -> bool:
    """One line, not long, with an end."""
    text = str(error)
    return text.endswith(".") and text.isprintable() and len(text) < 500


def test_a_program_from_start_to_end(bench: Bench) -> None:
    assert bench.ask(wire.GET_PREFIX) == ["Device/SubDeviceList/"]
    assert bench.command(wire.CREATE_ALIAS, ["eyes", [LED, "none"]]) == ["eyes", [LED, ""]]
    now = bench.ask(wire.GET_TIME, offset=0)
    assert bench.ask(wire.GET_TIME, offset=25) == now + 25
    separate = ["eyes", "ClearAll", "time-separate", 0, [now, now + 20], [[0.0, 0.5], [0.0, 0.0]]]
    assert bench.command(wire.SET_ALIAS, separate) is None
    for expected in (0.0, 0.25, 0.5):
        bench.robot.dcm.run_cycle()
        assert bench.ask(wire.READ, names=[LED]) == [expected]
    assert bench.command(wire.SET, [LED, "ClearAll", [[1.0, now]]]) is None
    bench.robot.dcm.run_cycle()
    assert bench.ask(wire.READ, names=[wire.PREFIX + LED, "DCM/Time"]) == [1.0, now + 40]


@pytest.mark.parametrize("key", COMMANDS)
def test_commands_need_the_lease(bench: Bench, key: str) -> None:
    bench.command(wire.CREATE_ALIAS, ["eyes", [LED]])
    commands = {
        wire.CREATE_ALIAS: ["eyes", []],
        wire.SET: [LED, "ClearAll", [[1.0, 0]]],
        wire.SET_ALIAS: ["eyes", 0, [1.0]],
    }
    with pytest.raises(LeaseRefused, match=f"`{key}` command was refused: `walker` holds"):
        bench.command(key, commands[key], lease=LEASE + 1)
    assert bench.robot.dcm.waiting(LED) == ()
    bench.command(wire.SET, ["eyes", "ClearAll", [[0.5, 0]]])
    bench.robot.dcm.run_cycle()
    assert bench.ask(wire.READ, names=[LED]) == [0.5]


def test_reading_needs_no_lease(bench: Bench) -> None:
    bench.holder = 0
    assert isinstance(bench.ask(wire.GET_TIME), int)
    assert bench.ask(wire.READ, names=[]) == []


def test_what_is_waiting_outlives_the_lease(bench: Bench) -> None:
    bench.command(wire.SET, [LED, "ClearAll", [[1.0, bench.ask(wire.GET_TIME, offset=30)]]])
    bench.holder = 0
    for _ in range(4):
        bench.robot.dcm.run_cycle()
    assert bench.ask(wire.READ, names=[LED]) == [1.0]


@pytest.mark.parametrize("key", REFUSED)
def test_what_is_not_emulated_is_refused(bench: Bench, key: str) -> None:
    with pytest.raises(DcmRefused, match=f"^{key[4:]} is not emulated: .*\\.$"):
        bench.ask(key, lease=LEASE)


WRONG: tuple[tuple[str, Any, str], ...] = (
    (wire.CREATE_ALIAS, ["a"], "a list of 1 items; \\[alias, \\[actuator"),
    (wire.CREATE_ALIAS, ["", [LED]], "the alias has no name"),
    (wire.CREATE_ALIAS, [1, [LED]], "item 0 is 1; a name"),
    (wire.CREATE_ALIAS, ["a", LED], "item 1 is 'Chest.*; a list"),
    (wire.CREATE_ALIAS, ["a", [LED, None]], "item 1, entry 1 is None; a name"),
    (wire.CREATE_ALIAS, ["a", [LED] * 257], "257 actuators; an alias takes at most 256"),
    (wire.SET, [LED, "clearall", []], "item 1 is 'clearall'; one of Merge, ClearAll, ClearAfter, ClearBefore"),
    (wire.SET, [LED, "Merge"], "a list of 2 items"),
    (wire.SET, [LED, "Merge", [0.5, 0]], "item 2, command 0 is 0.5; \\[value, time\\]"),
    (wire.SET, [LED, "Merge", [[0.5]]], "item 2, command 0 is \\[0.5\\]"),
    (wire.SET, [LED, "Merge", [["1", 0]]], "command 0, value is '1'; a finite number"),
    (wire.SET, [LED, "Merge", [[float("nan"), 0]]], "command 0, value is nan; a finite number"),
    (wire.SET, [LED, "Merge", [[0.0, 0], [float("inf"), 0]]], "command 1, value is inf; a finite number"),
    (wire.SET, [LED, "Merge", [[True, 0]]], "command 0, value is True; a finite number"),
    (wire.SET, [LED, "Merge", [[0.0, 2**31]]], "command 0, time is 2147483648; .* signed 4-byte integer"),
    (wire.SET, [LED, "Merge", [[0.0, 1.5]]], "command 0, time is 1.5; .* signed 4-byte integer"),
    (wire.SET, ["nothing", "Merge", []], "'nothing' is neither an actuator of this body nor an alias"),
    (wire.SET_ALIAS, ["nothing", "Merge", "time-mixed", []], "'nothing' is no alias; make it with createAlias"),
    (wire.SET_ALIAS, ["a", "Merge", "time-separate", []], "item 2 is 'time-separate'; a command of 4 items"),
    (wire.SET_ALIAS, ["a", "Merge", "time-mixed", 0, [], []], "item 2 is 'time-mixed'; a command of 6 items"),
    (
        wire.SET_ALIAS,
        ["a", "Merge", "time-separate", 0, [0], [[0.0, 1.0]]],
        "entry 0 has 2 values; item 4 has 1",
    ),
    (wire.SET_ALIAS, ["a", 0, "x"], "item 2 is 'x'; a list"),
    (wire.SET_ALIAS, [], "a list of 0 items"),
)


@pytest.mark.parametrize(("key", "command", "what"), WRONG)
def test_wrong_commands_are_refused_with_the_item(bench: Bench, key: str, command: Any, what: str) -> None:
    with pytest.raises(DcmRefused, match=what) as caught:
        bench.command(key, command)
    assert sentence(caught.value)


@pytest.mark.parametrize("payload", [b"\xc1", b"\x90", b"\x80" * 9, msgspec.msgpack.encode({"version": 1})])
def test_payloads_that_are_no_request_are_refused(bench: Bench, payload: bytes) -> None:
    for key in KEYS:
        with pytest.raises(FrameError) as caught:
            bench.handlers[key](payload)
        assert sentence(caught.value)


START = POSTURES["Stand"]
ELBOW = "LElbowYaw"
SLOT = INDEX[ELBOW]
COMMAND = f"{ELBOW}/Position/Actuator/Value"


def held_robot(body: str = "nao-v3") -> EmulatedRobot:
    return EmulatedRobot(
        load_body(body), seed=0, engine="mujoco", posture="Stand", held=True, lift=0.3, settle=0.1
    )


def frame(robot: EmulatedRobot, angle: float) -> ActuatorFrame:
    position = tuple(angle if i == SLOT else value for i, value in enumerate(START))
    return ActuatorFrame(reply_to=robot.frame.seq, position=position, stiffness=(1.0,) * 25)


def test_an_alias_command_and_a_frame_of_the_same_values_give_the_same_robot() -> None:
    """Bit for bit, standing on its feet: the frame is ClearAll at the time of now."""
    with (
        EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco") as by_frames,
        EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco") as by_alias,
    ):
        joints = [actuator.name for actuator in by_alias.dcm.table if "/Position/" in actuator.name]
        stiff = [name.replace("Position", "Hardness") for name in joints]
        by_alias.dcm.create_alias(alias_request(["all", joints + stiff]))
        for k in range(50):
            angle = START[SLOT] + 0.2 * math.sin(0.2 * k)
            command = frame(by_frames, angle)
            by_frames.advance(command)
            values = [command.position[INDEX[name.split("/")[0]]] for name in joints] + [1.0] * len(stiff)
            by_alias.dcm.set_alias(set_alias_request(["all", by_alias.dcm.clock.shown(), values]))
            by_alias.advance(None)
            assert by_alias.truth() == by_frames.truth()
            assert by_alias.frame.position == by_frames.frame.position


@pytest.mark.parametrize("body", ["nao-v3", "nao-v6"])
def test_the_clock_counts_the_cycles_of_the_body(body: str) -> None:
    with held_robot(body) as robot:
        for _ in range(25):
            robot.advance(None)
        assert robot.dcm.clock.shown() == round(1000.0 * robot.frame.time)


def test_a_reset_begins_with_empty_buffers_and_no_aliases() -> None:
    with held_robot() as robot:
        robot.dcm.create_alias(alias_request(["mine", [COMMAND]]))
        robot.dcm.set(set_request(["mine", "ClearAll", [[-1.0, 500]]]))
        robot.advance(None)
        robot.reset()
        assert robot.dcm.waiting(COMMAND) == ()
        assert robot.dcm.clock.shown() == 0
        first = robot.frame.position
        for _ in range(60):
            robot.advance(None)
        assert robot.frame.position[SLOT] == pytest.approx(first[SLOT], abs=2e-3)
