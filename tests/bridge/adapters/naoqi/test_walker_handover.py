"""The hand-over between the joints' side and the walker, with a walker that only says what it would do."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

from bridge.adapters.naoqi.core.walker_handover import WalkerHandover
from bridge.adapters.naoqi.core.walking import WalkingMethods
from bridge.adapters.naoqi.declared import declared
from bridge.errors import LeaseRefused, NaoqiRefused, WalkRefused
from bridge.messages.walk import WalkStatus
from tests.frames import walk_status
from tests.loops import TIMEOUT, until


class Stage:
    """Robot, walker's process and walker's client in one: notes what is done, in order."""

    def __init__(self) -> None:
        self.did: list[str] = []
        self.state = "stand"
        self.running = True
        self.bound = 0.2
        self.seq = 0
        self.place = 0.0
        self.velocity: Any = None
        self.target: Any = None

    def give_away(self) -> None:
        self.did.append("give away")

    def take_back(self) -> None:
        self.did.append("take back")

    def start(self) -> Stage:
        self.did.append("start")
        self.running = True
        return self

    def end(self) -> str:
        self.did.append("end")
        self.running = False
        return ""

    def take(self) -> WalkStatus:
        self.did.append("take")
        return self.status()

    def release(self) -> WalkStatus:
        self.did.append("release")
        return self.status()

    def status(self) -> WalkStatus:
        self.seq += 1
        return walk_status(
            seq=self.seq,
            state=self.state,
            gait="dynamic",
            admittance=False,
            velocity=(0.15 if self.state == "walk" else 0.0, 0.0, 0.0),
            position=(self.place, 0.0, 0.0),
        )

    def walk(
        self, *, velocity: Any, gait: str, distance: float | None = None, target: Any = None
    ) -> WalkStatus:
        if abs(velocity[0]) > self.bound:
            raise WalkRefused("0.5 m/s is beyond 0.2 m/s.")
        self.did.append(f"walk {velocity[0]:g} {distance}")
        self.velocity, self.target = velocity, target
        self.state = "walk"
        return self.status()

    def stop(self) -> WalkStatus:
        self.did.append("stop")
        self.state = "stand"
        return self.status()

    def close(self) -> None:
        self.did.append("close")


@pytest.fixture
def stage() -> Stage:
    return Stage()


@pytest.fixture
def walking(stage: Stage) -> Iterator[WalkingMethods]:
    handover = WalkerHandover(stage, stage.start, lambda: stage, "dynamic")  # type: ignore[arg-type,return-value]
    yield WalkingMethods(handover, (0.15, 0.0, 0.0))
    handover.close()


@pytest.fixture
def all_ways(walking: WalkingMethods) -> WalkingMethods:
    """With a gait that walks in any direction."""
    return WalkingMethods(walking.handover, (0.2, 0.1, 1.0))


def planar(x: float, y: float, yaw: float) -> Any:
    """A pose on the floor as a matrix, (3, 3)."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])


def begin(walking: WalkingMethods, method: str, *arguments: Any) -> Any:
    return declared(walking)["ALMotion"][method](arguments)


@pytest.mark.parametrize(
    ("method", "arguments"),
    [
        ("move", (0.0, 0.0, 0.0)),
        ("moveToward", (0.0, 0.0, 0.0)),
        ("setWalkTargetVelocity", (0, 0, 0, 0.5)),
        ("stopMove", ()),
    ],
)
def test_a_zero_velocity_before_the_first_walk_changes_nothing(
    walking: WalkingMethods, stage: Stage, method: str, arguments: tuple[float, ...]
) -> None:
    """The walker waits without the robot, and would refuse to stop it."""
    walking.handover.prestart().result(TIMEOUT)
    assert begin(walking, method, *arguments).result(TIMEOUT) is None
    assert stage.did == ["start"]


def call(walking: WalkingMethods, method: str, *arguments: Any) -> Any:
    result = begin(walking, method, *arguments)
    return result.result(TIMEOUT) if hasattr(result, "result") else result


def test_a_move_is_active_from_its_order_on(stage: Stage, walking: WalkingMethods) -> None:
    """As the vendor's sample asks at once after `post.moveTo`; before, false until the walker had started."""
    begun = threading.Event()
    stage.give_away = lambda: begun.wait(TIMEOUT)  # type: ignore[assignment,method-assign,return-value]
    done = begin(walking, "moveTo", 0.15, 0.0, 0.0)
    assert call(walking, "moveIsActive") is True
    begun.set()
    until(lambda: stage.state == "walk")
    assert call(walking, "moveIsActive") is True
    stage.state = "stand"
    done.result(TIMEOUT)
    assert call(walking, "moveIsActive") is False


def test_a_move_gives_the_joints_away_before_the_walker_starts(walking: WalkingMethods, stage: Stage) -> None:
    call(walking, "moveToward", 1.0, 0.0, 0.0)
    assert stage.did == ["start", "give away", "take", "walk 0.15 None"]
    assert call(walking, "moveIsActive")
    assert call(walking, "getRobotVelocity") == [0.15, 0.0, 0.0]


def test_joints_come_back_from_a_walker_that_stands_by_for_the_next_walk(
    walking: WalkingMethods, stage: Stage
) -> None:
    walking.handover.prestart()
    until(lambda: stage.did == ["start"])
    call(walking, "moveInit")
    assert walking.handover.with_joints(lambda: "done", stop=False).result(TIMEOUT) == "done"
    assert stage.did == ["start", "give away", "take", "release", "take back"]
    assert not walking.handover.has_robot
    call(walking, "moveToward", 1.0, 0.0, 0.0)
    assert stage.did[-3:] == ["give away", "take", "walk 0.15 None"]


def test_joints_come_back_from_a_walker_that_was_killed_when_its_lease_ends(
    walking: WalkingMethods, stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = [LeaseRefused("held by `walker`")] * 2

    def take_back() -> None:
        if held:
            raise held.pop()
        stage.did.append("take back")

    monkeypatch.setattr(stage, "take_back", take_back)
    call(walking, "moveInit")
    assert walking.handover.with_joints(lambda: "done", stop=False).result(TIMEOUT) == "done"
    assert stage.did[-1] == "take back"


def test_while_it_walks_joints_are_refused_and_postures_stop_it(walking: WalkingMethods, stage: Stage) -> None:
    call(walking, "moveToward", 0.5, 0.0, 0.0)
    with pytest.raises(NaoqiRefused, match="stopMove"):
        walking.handover.with_joints(lambda: None, stop=False).result(TIMEOUT)
    walking.handover.with_joints(lambda: stage.did.append("crouch"), stop=True).result(TIMEOUT)
    assert stage.did[-4:] == ["stop", "release", "take back", "crouch"]


def test_joints_wait_for_the_end_of_a_walk_that_was_stopped(
    walking: WalkingMethods, stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Programs stop the walk and turn the head at once."""
    call(walking, "moveToward", 0.5, 0.0, 0.0)
    monkeypatch.setattr(stage, "stop", stage.status)  # it still closes its feet
    stopped = begin(walking, "stopMove")
    done = walking.handover.with_joints(lambda: "done", stop=False)
    time.sleep(0.3)
    assert not done.done() and not stopped.done()
    stage.state = "stand"
    assert done.result(TIMEOUT) == "done"
    assert stopped.result(TIMEOUT) is None


def test_move_to_waits_for_the_end_of_the_walk(walking: WalkingMethods, stage: Stage) -> None:
    ended = begin(walking, "moveTo", 0.3, 0.0, 0.0)
    until(lambda: stage.state == "walk")
    time.sleep(0.3)
    assert not ended.done()
    stage.place, stage.state = 0.3, "stand"
    assert ended.result(TIMEOUT) is True
    assert call(walking, "getRobotPosition", True) == [0.3, 0.0, 0.0]
    assert stage.did[-1] == "walk 0.15 0.3"


def test_a_fall_fails_the_call_that_waits(walking: WalkingMethods, stage: Stage) -> None:
    ended = begin(walking, "moveTo", 0.3, 0.0, 0.0)
    until(lambda: stage.state == "walk")
    stage.state = "fallen"
    with pytest.raises(NaoqiRefused, match="The robot fell"):
        ended.result(TIMEOUT)


@pytest.mark.parametrize(
    ("fractions", "config", "velocity"),
    [
        # steps of 40 mm and 0.349 rad in 0.42 s; sideways 0.14 m out and 0.088 m near in turn
        ((1.0, 0.0, 0.0), [], (0.04 / 0.42, 0.0, 0.0)),
        ((-0.5, -1.0, 0.2), [], (-0.02 / 0.42, -0.026 / 0.42, 0.2 * 0.349066 / 0.42)),
        ((1.0, 0.0, 0.0), [["MaxStepX", 0.08]], (0.08 / 0.42, 0.0, 0.0)),
        ((1.0, 0.0, 0.0), [["Frequency", 0.0], ["Wrong", 1]], (0.04 / 0.6, 0.0, 0.0)),
        # steps of both feet over the time of both
        ((1.0, 0.0, 0.0), [["LeftMaxStepX", 0.02], ["MaxStepFrequency", 0.5]], (0.06 / 1.02, 0.0, 0.0)),
        (
            (1.0, 0.0, 0.0),
            [["RightMaxStepFrequency", 0.0], ["RightTorsoWx", -math.radians(7)]],
            (0.08 / 1.02, 0, 0),
        ),
    ],
)
def test_moves_are_fractions_of_the_vendor_s_full_speed(
    all_ways: WalkingMethods, stage: Stage, fractions: Any, config: Any, velocity: Any
) -> None:
    """By the vendor's page on locomotion control; 0.095 m/s, 0.062 m/s and 0.83 rad/s at most by default."""
    call(all_ways, "moveToward", *fractions, config)
    assert stage.velocity == pytest.approx(velocity)


def test_a_walk_over_several_places_goes_to_one_after_the_other(all_ways: WalkingMethods, stage: Stage) -> None:
    """Each is relative to the one before (vendor's sample of a Dubins curve)."""
    ended = begin(all_ways, "moveTo", [[0.1, 0.0, math.pi / 2], [0.2, 0.0, 0.0]], 5.0)
    until(lambda: stage.state == "walk")
    assert stage.target == pytest.approx((0.1, 0.0, math.pi / 2))
    stage.target, stage.state = None, "stand"
    until(lambda: stage.target is not None and stage.state == "walk")
    assert stage.target == pytest.approx((0.2, 0.0, 0.0))
    assert not ended.done()
    stage.state = "stand"
    assert ended.result(TIMEOUT) is True


@pytest.mark.parametrize("arguments", [(0.1, 0.2, 0.3), ([0.1, 0.2, 0.3],)])
def test_move_to_is_a_walk_to_a_place(all_ways: WalkingMethods, stage: Stage, arguments: tuple[Any]) -> None:
    ended = begin(all_ways, "walkTo", *arguments)
    until(lambda: stage.state == "walk")
    assert stage.target == (0.1, 0.2, 0.3)
    stage.state = "stand"
    assert ended.result(TIMEOUT) is True


def test_footsteps_lead_to_where_they_end(all_ways: WalkingMethods, stage: Stage) -> None:
    """A step of 8 cm, closed by the other foot; then a turn of 1 rad on the left foot."""
    steps = partial(begin, all_ways, "setFootSteps")
    assert steps(["LLeg", "RLeg"], [[0.08, 0.1, 0.0], [0.0, -0.1, 0.0]], [1, 2], True).result(TIMEOUT) is None
    assert stage.state == "walk"
    assert stage.target == pytest.approx((0.08, 0.0, 0.0))
    stage.state = "stand"
    until(lambda: not call(all_ways, "moveIsActive"))
    steps = partial(begin, all_ways, "setFootStepsWithSpeed")
    steps(["LLeg", "RLeg"], [[0.0, 0.1, 1.0], [0.0, -0.1, 0.0]], [1, 2], True)
    until(lambda: stage.state == "walk")
    # the left foot stays at (0, 0.05) and turns; the right one comes beside it
    half = 0.05
    assert stage.target == pytest.approx((half * math.sin(1.0), half * (1.0 - math.cos(1.0)), 1.0))


def test_footsteps_of_a_walk_lead_to_its_end(all_ways: WalkingMethods, stage: Stage) -> None:
    """Each in the frame of the other foot; 0.2 m by steps of 40 mm at most take five; two are not changed."""
    assert all_ways.steps_ahead() == [[], []]
    ended = begin(all_ways, "moveTo", 0.2, 0.0, 0.3)
    until(lambda: stage.state == "walk")
    fixed, changeable = all_ways.steps_ahead()
    assert (len(fixed), len(changeable)) == (2, 3)
    feet = {"LLeg": planar(0.0, 0.05, 0.0), "RLeg": planar(0.0, -0.05, 0.0)}
    for i, (leg, moment, place) in enumerate([*fixed, *changeable]):
        assert (leg, moment) == (("LLeg", "RLeg")[i % 2], pytest.approx(0.42 * (i + 1)))
        feet[leg] = feet["RLeg" if leg == "LLeg" else "LLeg"] @ planar(*place)
    end = feet["LLeg"] @ planar(0.0, -0.05, 0.0)  # the last step is the left foot's
    assert end == pytest.approx(planar(0.2, 0.0, 0.3), abs=1e-9)
    assert call(all_ways, "getNextRobotPosition") == pytest.approx([0.08, 0.0, 0.12])
    stage.place, stage.state = 0.2, "stand"
    ended.result(TIMEOUT)
    until(lambda: all_ways.steps_ahead() == [[], []])
    assert call(all_ways, "getNextRobotPosition") == call(all_ways, "getRobotPosition", False)


@pytest.mark.parametrize("height", [0.04, "0.04"])
def test_a_step_may_be_4_cm_high_and_numbers_may_be_text(
    all_ways: WalkingMethods, stage: Stage, height: Any
) -> None:
    """Both are in the vendor's samples (of `moveTo`, and of `ALNavigation.moveTo`)."""
    begin(all_ways, "moveTo", 0.2, 0.0, 0.0, [["StepHeight", height]])
    until(lambda: stage.state == "walk")
    assert stage.target == (0.2, 0.0, 0.0)
    with pytest.raises(NaoqiRefused, match=r"StepHeight.*'high'"):
        call(all_ways, "moveTo", 0.2, 0.0, 0.0, [["StepHeight", "high"]])


@pytest.mark.parametrize(
    ("method", "arguments", "wrong", "sentence"),
    [
        ("moveInit", [], None, ""),
        ("move", [0.05, 0.0, 0.1], [0.05, 0.0, "left"], "theta.*'left'"),
        ("moveToward", [0.5, 0.0, -0.5], [math.nan, 0.0, 0.0], "x is nan"),
        ("setWalkTargetVelocity", [0.5, 0.0, 0.0, 1.0], [0.5, 0.0, 0.0, "fast"], "Frequency is 'fast'"),
        ("stopMove", [], None, ""),
        ("waitUntilMoveIsFinished", [], None, ""),
    ],
)
def test_walking_methods_give_nothing_and_name_the_wrong_argument(
    all_ways: WalkingMethods, method: str, arguments: list[Any], wrong: list[Any] | None, sentence: str
) -> None:
    assert call(all_ways, method, *arguments) is None
    if wrong is not None:
        with pytest.raises(NaoqiRefused, match=sentence):
            call(all_ways, method, *wrong)


@pytest.mark.parametrize(
    ("given", "clipped"),
    [
        ((1.2, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((0.5, 0.0, 0.0, [["StepHeight", 0.06]]), (0.5, 0.0, 0.0, [["StepHeight", 0.04]])),
        ((0.5, 0.0, 0.0, [["MaxStepX", 0.35], ["Frequency", 1.2]]), (0.5, 0.0, 0.0, [["MaxStepX", 0.08]])),
    ],
)
def test_values_beyond_the_limits_are_clipped_with_a_warning(
    all_ways: WalkingMethods,
    stage: Stage,
    given: tuple[Any, ...],
    clipped: tuple[Any, ...],
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Limits: vendor's page on locomotion control (StepHeight 0.04 m, MaxStepX 0.08 m)."""
    call(all_ways, "moveToward", *clipped)
    velocity = stage.velocity
    assert not caplog.records
    call(all_ways, "stopMove")
    call(all_ways, "moveToward", *given)
    assert stage.velocity == velocity
    assert "is clipped to" in caplog.text


def test_a_program_that_steers_is_not_held_up_and_its_newest_velocity_counts(
    walking: WalkingMethods, stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The vendor's move and moveToward do not wait; the walker takes a tenth of a second for each order."""
    call(walking, "moveToward", 0.2, 0.0, 0.0)
    free, walk = threading.Event(), stage.walk
    monkeypatch.setattr(stage, "walk", lambda **order: (free.wait(TIMEOUT), walk(**order))[1])
    for speed in (0.4, 0.6, 0.8, 1.0):
        call(walking, "moveToward", speed, 0.0, 0.0)
    stopped = begin(walking, "stopMove")
    assert stage.did[-1] == "walk 0.03 None"
    free.set()
    stopped.result(TIMEOUT)
    walks = [did for did in stage.did if did.startswith("walk")]
    assert len(walks) <= 3 and walks[-1] == "walk 0.15 None"
    assert stage.did[-1] == "stop"
