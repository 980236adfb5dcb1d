"""Walk commands in process: what they lead to, what is refused, and that the joints never jump."""

from __future__ import annotations

import itertools
import math
import re
import threading
import time
from collections.abc import Iterator, Sequence
from typing import Any, Final

import pytest

from bridge.body import load_body
from bridge.body.joints import LEG_SLOTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import joint_no_load_speed
from bridge.errors import NaoHilError, WalkRefused
from bridge.messages import ActuatorFrame, SensorFrame, WalkTelemetry, decode, encode
from bridge.messages.walk import WalkCommand, WalkStatus
from emulator.robot import EmulatedRobot
from emulator.scenarios.events import PushEvent
from emulator.scenarios.model import Scenario
from emulator.wear import load_wear
from tests.loops import TIMEOUT
from tests.walker.test_controller import frame
from walker.service import WalkService

BODY = load_body("nao-v3")
DT = BODY.cycle


class Served:
    """A walker that serves a robot whose frames say that it stands on both feet, or the emulated one."""

    def __init__(self, robot: EmulatedRobot | None = None, gait: str = "static") -> None:
        self.service = WalkService(gait)
        self.controller = self.service.make(BODY, DT)
        self.robot = robot
        self.seq = -1
        self.commands: list[ActuatorFrame] = []
        self.telemetry: list[WalkTelemetry] = []
        self.run(1)

    def _frame(self) -> SensorFrame:
        return self.robot.frame if self.robot is not None else frame(self.seq)

    def run(self, cycles: int) -> None:
        for _ in range(cycles):
            if self.robot is not None and self.commands:
                self.robot.advance(self.commands[-1])
            self.seq += 1
            sensors = self._frame()
            self.service.before(self.controller, sensors.seq)
            self.commands.append(self.controller.tick(sensors))
            self.telemetry.append(self.controller.telemetry)
            self.service.after(self.controller, sensors.seq)

    def until(self, state: str, most: int = 3000) -> None:
        for _ in range(most):
            if self.controller.state == state:
                return
            self.run(1)
        raise AssertionError(f"not in state {state} after {most} cycles, but {self.controller.state}")

    def ask(self, **fields: object) -> WalkStatus:
        # `at` in the future: nobody ticks meanwhile, so there is nothing to wait for
        fields = {"at": self.seq + 2} | fields
        command = WalkCommand(**fields)  # type: ignore[arg-type]
        return decode(self.service.answer(encode(command)), WalkStatus)


def largest_step(commands: list[ActuatorFrame]) -> float:
    return max(
        max(abs(b - a) for a, b in zip(before.position, after.position, strict=True))
        for before, after in itertools.pairwise(commands)
    )


@pytest.fixture
def served() -> Iterator[Served]:
    served = Served()
    served.until("stand")
    yield served


def test_a_robot_that_hangs_does_not_walk_on_an_order_until_it_stands() -> None:
    with EmulatedRobot(BODY, seed=1, engine="mujoco", start="hang") as robot:
        served = Served(robot)
        served.until("stand")
        with pytest.raises(WalkRefused, match="hangs"):
            served.ask(op="walk", velocity=(0.014, 0.0, 0.0))
        robot.stand_up()
        served.run(50)
        assert served.ask(op="walk", velocity=(0.014, 0.0, 0.0)).text


def test_the_velocity_is_that_of_the_planned_steps(served: Served) -> None:
    """Steps of v (T_DSP + T_SSP): with the thesis' 2 s and 1.5 s, 0.014 m/s make 49 mm."""
    served.ask(op="walk", velocity=(0.014, 0.0, 0.0))
    served.run(2300)
    left = {round(t.left[0], 6) for t in served.telemetry if t.contact[0] and t.phase == "DSL"}
    steps = sorted(left)
    assert len(steps) > 3
    assert [b - a for a, b in itertools.pairwise(steps[1:])] == pytest.approx(
        [2 * 0.014 * 3.5] * (len(steps) - 2)
    )
    assert served.ask(op="status").velocity == pytest.approx((0.014, 0.0, 0.0))


@pytest.mark.parametrize(("gait", "distance"), [("static", 0.1), ("static", 0.06), ("dynamic", 0.25)])
def test_a_distance_is_met_exactly_by_the_plan(served: Served, gait: str, distance: float) -> None:
    served.ask(op="walk", gait=gait, distance=distance)
    served.until("walk")
    served.until("stand", 5000)
    status = served.ask(op="status")
    assert status.distance == pytest.approx(distance, abs=1e-9)
    assert served.controller.planned_pose == pytest.approx((distance, 0.0, 0.0), abs=1e-9)
    assert status.gait == gait


def test_one_walk_follows_another_where_the_first_ended(served: Served) -> None:
    served.ask(op="walk", steps=2)
    served.until("walk")
    served.until("stand")
    first = served.controller.planned_pose[0]
    served.ask(op="walk", steps=3)
    served.until("walk")
    served.until("stand")
    status = served.ask(op="status")
    assert status.steps == 3
    assert first == pytest.approx(0.06, abs=1e-9)
    assert served.controller.planned_pose[0] == pytest.approx(0.06 + 2 * 0.06, abs=1e-9)
    assert served.telemetry[-1].left[0] == pytest.approx(0.18, abs=1e-9)


def test_a_static_walk_changes_its_velocity_in_stride(served: Served) -> None:
    served.ask(op="walk", velocity=(0.010, 0.0, 0.0))
    served.run(600)
    served.ask(op="walk", velocity=(0.015, 0.0, 0.0))
    served.run(600)
    assert served.ask(op="status").velocity == pytest.approx((0.015, 0.0, 0.0))
    walk = [t for t in served.telemetry if t.state != "approach"]
    began = next(i for i, t in enumerate(walk) if t.state == "walk")
    assert all(t.state == "walk" for t in walk[began:])


def test_a_dynamic_walk_stands_before_another_velocity(served: Served) -> None:
    served.ask(op="walk", gait="dynamic")
    served.until("walk")
    served.run(300)
    served.ask(op="walk", velocity=(0.1, 0.0, 0.0))
    served.run(2)
    assert served.controller.state == "stopping"
    served.until("walk")
    assert served.ask(op="status").velocity == pytest.approx((0.1, 0.0, 0.0))


def test_stop_closes_the_feet(served: Served) -> None:
    served.ask(op="walk")
    served.run(900)
    served.ask(op="stop")
    served.until("stand")
    last = served.telemetry[-1]
    assert last.left[0] == pytest.approx(last.right[0])


def test_zero_velocity_is_a_stop(served: Served) -> None:
    served.ask(op="walk")
    served.run(500)
    served.ask(op="walk", velocity=(0.0, 0.0, 0.0))
    served.run(2)
    assert served.controller.state == "stopping"


def test_a_walk_that_nobody_holds_stops_by_itself(served: Served) -> None:
    served.ask(op="walk", hold=1.0)
    served.run(90)
    assert served.controller.state == "walk"
    served.ask(op="walk", hold=1.0)
    served.run(90)
    assert served.controller.state == "walk"
    served.run(30)
    assert served.controller.state == "stopping"


def test_a_keepalive_keeps_a_walk_with_its_bounds_and_begins_none(served: Served) -> None:
    served.ask(op="set", hold=1.0)
    served.run(30)
    assert served.controller.state == "stand"
    served.ask(op="walk", steps=4, hold=1.0)
    for _ in range(40):
        served.run(50)
        served.ask(op="set", hold=1.0)
    assert served.controller.state == "stand" and served.telemetry[-1].step == 4


def test_orders_are_noted_once_and_keepalives_are_not(served: Served) -> None:
    served.ask(op="stop")
    served.ask(op="walk", velocity=(0.01, 0.0, 0.0), hold=3.0)
    served.run(100)
    served.ask(op="walk", velocity=(0.012, 0.0, 0.0), hold=3.0)
    served.ask(op="set", hold=3.0)
    served.ask(op="status")
    served.ask(op="stop")
    walks, stops = served.service.take_notes()
    assert "0.010 m/s" in walks and "feet" in stops
    assert served.service.take_notes() == []


SWITCHES: Final[tuple[dict[str, Any], ...]] = (
    {"op": "set", "torso": "none"},
    {"op": "set", "admittance": False},
    {"op": "set", "torso": "robust", "admittance": True},
    {"op": "walk", "velocity": (0.01, 0.0, 0.0)},
)


def largest_step_of_a_walk(wishes: Sequence[dict[str, Any]]) -> float:
    """Over a walk from stand to stand with the wishes given on the way."""
    with EmulatedRobot(BODY, seed=3, engine="mujoco") as robot:
        served = Served(robot)
        served.until("stand")
        began = len(served.commands)
        for request in ({"op": "walk"}, *wishes, {"op": "stop"}):
            served.ask(**request)
            served.run(333)  # in all phases, single supports too
        served.until("stand")
        assert not robot.truth().fell
        return largest_step(served.commands[began:])


def test_no_command_makes_a_joint_jump() -> None:
    """Switches of controllers, gaits and velocities: between two cycles no joint is asked for more than
    the knee's motor can turn without a load; a leg that gives up its admittance does so at 0.3 m/s."""
    assert largest_step_of_a_walk(SWITCHES) < joint_no_load_speed(BODY, "LKneePitch") * BODY.cycle


@pytest.mark.parametrize(
    ("fields", "bound"),
    [
        ({"velocity": (0.03, 0.0, 0.0)}, r"^0\.03 m/s are too fast.*0\.01\d m/s would do.*out of reach"),
        ({"velocity": (0.5, 0.0, 0.0)}, r"the sole's margin of 71 mm \(3\.5\)"),
        ({"velocity": (0.01, 0.01, 0.0)}, "walks straight ahead.*vy and omega 0"),
        ({"velocity": (0.01, 0.0, 0.3)}, "walks straight ahead.*0.3 rad/s"),
        ({"velocity": (-0.01, 0.0, 0.0)}, "vx must be positive"),
        ({"steps": 1}, "at least 2 steps"),
        ({"gait": "statik"}, "did you mean 'static'"),
        ({"gait": "dynamic", "velocity": (0.3, 0.0, 0.0)}, "too fast.*RAnkleRoll would stand .* below"),
    ],
)
def test_what_cannot_be_walked_is_refused_with_the_bound(
    served: Served, fields: dict[str, object], bound: str
) -> None:
    with pytest.raises(WalkRefused, match=bound) as refused:
        served.ask(op="walk", **fields)
    assert "\n" not in str(refused.value)
    served.run(5)
    assert served.controller.state == "stand"
    served.ask(op="walk")  # what was refused has left no trace
    served.run(5)
    assert served.controller.walk.gait.name == "static"


def test_a_robot_that_fell_walks_again_once_it_is_upright(served: Served) -> None:
    served.ask(op="walk")
    served.run(100)

    def lying() -> SensorFrame:
        return frame(served.seq, angle=(0.0, math.radians(80.0)))

    upright, served._frame = served._frame, lying  # type: ignore[method-assign]
    served.run(200)
    assert served.controller.state == "fallen"
    with pytest.raises(NaoHilError, match="stand-up"):
        served.ask(op="walk")
    served._frame = upright  # type: ignore[method-assign]
    served.run(200)
    assert served.controller.state == "fallen"
    served.ask(op="walk")
    served.until("walk")


def test_a_motion_is_played_after_closing_the_feet_and_a_walk_gets_up_from_its_end(served: Served) -> None:
    served.ask(op="walk")
    served.run(100)
    served.ask(op="motion", motion="sit-down")
    served.run(3)
    assert "in place of sit-down" in served.ask(op="motion", motion="crouch").text
    served.until("motion")
    assert "stopping" in {t.state for t in served.telemetry}
    with pytest.raises(WalkRefused, match="A motion is under way; order sit-down when it has ended"):
        served.ask(op="motion", motion="sit-down")
    served.until("rest")
    # the vendor's published posture, nearly limp
    slots = [slot for leg in LEG_SLOTS.values() for slot in leg]
    crouch = [POSTURES["Crouch"][slot] for slot in slots]
    assert [served.commands[-1].position[slot] for slot in slots] == pytest.approx(crouch, abs=0.02)
    assert set(served.commands[-1].stiffness) == {0.1}
    assert "rests" in served.ask(op="motion", motion="crouch").text
    served.run(200)
    assert served.controller.state == "rest"
    served.ask(op="walk", steps=2)
    served.until("walk")
    assert served.controller.recoveries == 0


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ("sit-dwn", "did you mean 'sit-down'"),
        ("get-up-back", "begins with the torso as it is: upright"),
        (None, "name of a motion"),
    ],
)
def test_a_motion_that_cannot_be_played_is_refused(served: Served, motion: str | None, words: str) -> None:
    with pytest.raises(WalkRefused, match=words):
        served.ask(op="motion", motion=motion)


def test_a_velocity_in_any_direction_is_taken_in_stride_and_clipped_with_a_word() -> None:
    served = Served(gait="omni")
    served.until("stand")
    reply = served.ask(op="walk", velocity=(0.1, 0.02, 0.1))
    assert "0.020 m/s to the left" in reply.text
    assert "clipped" not in reply.text
    served.until("walk")
    served.run(300)
    step = served.telemetry[-1].step
    reply = served.ask(op="walk", velocity=(-1.0, 0.0, 0.0))
    assert re.search(r"at -0\.250 m/s.*-1 m/s, 0 m/s and 0 rad/s are beyond", reply.text)
    served.run(300)
    assert {t.state for t in served.telemetry[-600:]} == {"walk"}
    assert served.telemetry[-1].step > step
    assert served.ask(op="status").velocity == pytest.approx((-0.25, 0.0, 0.0))
    ahead = [0.5 * (t.left[0] + t.right[0]) for t in served.telemetry]
    assert max(ahead) > 0.05
    assert ahead[-1] < max(ahead) - 0.05


def test_a_walker_of_one_gait_that_walks_by_another_stands_pushes_as_that_one() -> None:
    """2.4 N s straight ahead, more than a foot bears: the answer is a capture step, which `static` has not."""
    scenario = Scenario(pushes=(PushEvent(time=10.5, impulse=2.4, direction=0.0),))
    stood = 0
    for seed in (1, 2, 3):
        with EmulatedRobot(
            BODY, seed=seed, engine="mujoco", wear=load_wear("nominal"), scenario=scenario
        ) as robot:
            served = Served(robot, gait="static")
            served.until("stand")
            served.ask(op="walk", gait="omni", distance=0.1)
            served.run(300)
            served.until("stand")
            served.run(max(0, int((10.5 - robot.frame.time) / DT)) + 350)
            steps = {t.state for t in served.telemetry[-350:]} - {"stand"}
            stood += bool(steps) and not robot.truth().fell
        if stood == 2:
            return
    raise AssertionError(f"{stood} of three seeds stand")


def test_a_target_is_walked_to_and_a_distance_goes_along_the_velocity() -> None:
    served = Served(gait="omni")
    served.until("stand")
    reply = served.ask(op="walk", target=(0.2, 0.1, 0.5))
    assert re.search(r"at \d+% of its limits, to 0.2 m ahead, 0.1 m to the left, 0.5 rad", reply.text)
    served.until("walk")
    with pytest.raises(WalkRefused, match="walk with a target is under way"):
        served.ask(op="set", velocity=(0.1, 0.0, 0.0))
    served.ask(op="stop")
    served.until("stand")
    assert (
        "to 0 m ahead, 0.3 m to the left" in served.ask(op="walk", velocity=(0.0, 0.1, 0.0), distance=0.3).text
    )


@pytest.mark.parametrize(
    ("gait", "order", "words"),
    [
        ("omni", {"target": (1.0, 0.0, 0.0), "distance": 1.0}, "not both"),
        ("omni", {"target": (1.0, 0.0, 90.0)}, "90 rad; it takes -3.14 to 3.14"),
        ("omni", {"velocity": (0.1, 0.0, 0.3), "distance": 1.0}, "without a turn"),
        ("static", {"target": (1.0, 0.0, 0.0)}, "`omni`"),
    ],
)
def test_what_no_target_or_distance_can_be_is_refused(gait: str, order: dict[str, Any], words: str) -> None:
    served = Served(gait=gait)
    served.until("stand")
    with pytest.raises(WalkRefused, match=words):
        served.ask(op="walk", **order)


def test_a_walker_that_stands_by_takes_the_robot_and_gives_it_back() -> None:
    """As a process does it: frames are answered from `take` on, and `release` waits until they are not."""
    service = WalkService("omni", standby=True)
    controller = service.make(BODY, DT)
    assert not service.wait_wanted(0.01)
    with pytest.raises(WalkRefused, match="does not hold a robot yet"):
        service.answer(encode(WalkCommand(op="status")))

    def process() -> None:
        """The walker's process for one hold of the robot."""
        assert service.wait_wanted(TIMEOUT)
        for seq in range(1000):
            if not service.wanted:
                break
            service.before(controller, seq)
            controller.tick(frame(seq))
            service.after(controller, seq)
            time.sleep(0.002)
        service.note_released()

    thread = threading.Thread(target=process)
    thread.start()
    taken = decode(service.answer(encode(WalkCommand(op="take"))), WalkStatus)
    assert taken.state == "approach"
    assert decode(service.answer(encode(WalkCommand(op="release"))), WalkStatus).text == "The robot is free."
    thread.join(TIMEOUT)
    assert not service.wanted and not thread.is_alive()
