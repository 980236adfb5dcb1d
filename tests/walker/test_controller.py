"""The controller as a whole: pure, in closed loop upright, bounded and continuous in what it adds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice, pairwise

import msgspec
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, LEG_JOINTS, N_JOINTS
from bridge.body.quantities import coupled_limits
from bridge.guard import Guard
from bridge.messages import ActuatorFrame, SensorFrame, WalkTelemetry
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from tests.frames import standing_frame
from tests.loops import repeat_while
from walker.controller import Controller, WalkOrder
from walker.gaits import gait_parameters, make_gait
from walker.parameters import controller_parameters
from walker.switches import NAMED, Switches

BODY = load_body("nao-v3")
UPRIGHT = (0.0, 0.0, 9.81)
ON = {"switches": {f: "thesis" if f == "torso" else True for f in Switches.__struct_fields__}}
STIFF = {"switches": {"leg_admittance": False, "ankle_admittance": False, "late_touch_down": False}}
OFF = {"switches": msgspec.to_builtins(NAMED["none"])}


def make_controller(gait: str, order: WalkOrder, changes: dict[str, object] | None = None) -> Controller:
    phases = make_gait(gait, gait_parameters(gait), BODY)
    return Controller(BODY, phases, order, BODY.cycle, controller_parameters(gait, changes))


def frame(
    seq: int, *, fsr: tuple[float, ...] = (6.0,) * 8, angle: tuple[float, float] = (0.0, 0.0)
) -> SensorFrame:
    """A robot that stands, level, on both feet, unless told otherwise."""
    return standing_frame(seq, time=seq * BODY.cycle, fsr=fsr, accelerometer=UPRIGHT, angle=angle)


class Run:
    """A walk in process, with what came of it cycle by cycle."""

    def __init__(self, controller: Controller, *, wear: str, most: int) -> None:
        self.frames: list[SensorFrame] = []
        self.commands: list[ActuatorFrame] = []
        self.telemetry: list[WalkTelemetry] = []
        self.tilt: list[float] = []
        guard = Guard(BODY)
        with EmulatedRobot(BODY, seed=1, engine="mujoco", wear=load_wear(wear)) as robot:
            for _ in range(most):
                self.frames.append(robot.frame)
                command = controller.tick(robot.frame)
                self.commands.append(command)
                self.telemetry.append(controller.telemetry)
                robot.advance(guard.check(command, robot.frame.seq))
                x, y, _, _ = robot.truth().torso_orientation
                self.tilt.append(math.acos(1.0 - 2.0 * (x * x + y * y)))
                if controller.done:
                    break
            self.fell = robot.truth().fell


@pytest.fixture(scope="module")
def static_walk() -> Iterator[Run]:
    yield Run(make_controller("static", WalkOrder(steps=4), ON), wear="ideal", most=2500)


@pytest.fixture(scope="module")
def nominal_walk() -> Iterator[Run]:
    yield Run(make_controller("static", WalkOrder(steps=3), ON), wear="nominal", most=2500)


def test_four_static_steps_with_everything_on_end_upright_in_a_stand(static_walk: Run) -> None:
    assert static_walk.telemetry[-1].state == "stand"
    assert static_walk.telemetry[-1].step == 4
    assert not static_walk.fell
    walking = [t.state in ("walk", "stopping") for t in static_walk.telemetry]
    assert max(t for t, w in zip(static_walk.tilt, walking, strict=True) if w) < math.radians(4.0)


def test_the_controllers_really_took_part(static_walk: Run) -> None:
    assert max(abs(o) for t in static_walk.telemetry for o in t.torso_control) > math.radians(0.1)
    assert max(abs(o) for t in static_walk.telemetry for o in t.foot_lift) > 1e-3


@pytest.mark.parametrize("walk", ["static_walk", "nominal_walk"])
def test_torso_offsets_are_continuous_across_stance_changes(walk: str, request: pytest.FixtureRequest) -> None:
    run: Run = request.getfixturevalue(walk)
    rate = controller_parameters("static").torso_limits.rate
    supports = {t.phase for t in run.telemetry}
    assert {"SSL", "SSR"} <= supports
    for before, after in zip(run.telemetry, run.telemetry[1:], strict=False):
        for a, b in zip(before.torso_control, after.torso_control, strict=True):
            assert abs(b - a) <= rate * BODY.cycle + 1e-12


def test_torso_control_acts_while_the_swing_foot_touches_nothing(static_walk: Run) -> None:
    """Thesis 4.2. The telemetry's contacts are those of the frame that the offsets answer."""
    swings = {"SSL": (True, False), "SSR": (False, True)}
    moved = {True: 0, False: 0}
    for before, after in pairwise(static_walk.telemetry):
        if after.phase in swings and after.contact in ((True, True), swings[after.phase]):
            alone = after.contact == swings[after.phase]
            moved[alone] += after.torso_control != before.torso_control
            assert alone or after.torso_control == before.torso_control
    assert moved[True] > 100


@pytest.mark.parametrize("walk", ["static_walk", "nominal_walk"])
def test_every_command_keeps_the_data_sheets_ranges(walk: str, request: pytest.FixtureRequest) -> None:
    run: Run = request.getfixturevalue(walk)
    for command in run.commands:
        for side in ("L", "R"):
            pitch = command.position[INDEX[f"{side}AnklePitch"]]
            for joint in LEG_JOINTS[side][1:]:
                lower, upper = coupled_limits(BODY, joint, pitch)
                assert lower - 1e-9 <= command.position[INDEX[joint]] <= upper + 1e-9


@pytest.mark.parametrize("walk", ["static_walk", "nominal_walk"])
def test_lifts_stay_inside_the_springs_pole_and_the_orientation_control(
    walk: str, request: pytest.FixtureRequest
) -> None:
    run: Run = request.getfixturevalue(walk)
    p = controller_parameters("static", ON)
    width = 2.0 * BODY.lengths.HipOffsetY + 0.060  # feet's distance across, and along by a step
    bound = (
        p.leg.pole + p.leg.target_depth + p.touch_down.search_depth + p.swing_foot_orientation.max_angle * width
    )
    assert max(abs(lift) for t in run.telemetry for lift in t.foot_lift) < bound


def test_measured_zmp_lies_over_the_support_foot_in_single_support(static_walk: Run) -> None:
    p = gait_parameters("static")
    xs = [x for x, _ in BODY.foot.sole]
    for t in static_walk.telemetry:
        if t.phase == "SSL" and t.contact == (True, False):
            assert t.zmp_measured is not None
            assert t.left[0] + min(xs) <= t.zmp_measured[0] <= t.left[0] + max(xs)
            assert abs(t.zmp_measured[1] - 0.5 * p.l_FA) < 0.054  # type: ignore[attr-defined]


def test_same_frames_same_commands_whether_telemetry_is_asked_for_or_not(static_walk: Run) -> None:
    other = make_controller("static", WalkOrder(steps=4), ON)
    for k, sensors in enumerate(static_walk.frames):
        assert other.tick(sensors) == static_walk.commands[k]
        if k % 100 == 99:
            assert other.telemetry == static_walk.telemetry[k]


def test_lost_frames_are_made_up_for_in_the_plans_time() -> None:
    """With every third frame only, the plan is where it is with all of them: no block changes the plan."""
    every, some = (make_controller("static", WalkOrder(steps=4), STIFF) for _ in range(2))
    began = 0
    for _ in repeat_while(lambda: every.state != "walk"):
        every.tick(frame(began))
        some.tick(frame(began))
        began += 1
    for k in range(301):
        every.tick(frame(began + k))
        if k % 3 == 2 or k == 300:
            some.tick(frame(began + k))
    assert some.plan.phase == every.plan.phase == "SSL"
    assert some.plan.left.x == pytest.approx(every.plan.left.x, abs=1e-9)
    assert some.plan.right.x == pytest.approx(every.plan.right.x, abs=1e-9)
    assert some.plan.progress == pytest.approx(every.plan.progress, abs=1e-9)


def test_a_long_silence_does_not_make_the_joints_jump() -> None:
    controller = make_controller("static", WalkOrder(steps=4))
    for seq in range(450):
        before = controller.tick(frame(seq))
    after = controller.tick(frame(450 + 2000))
    assert controller.state == "walk"
    # 20 s would be five phases on; the plan moves on by `max_gap`, 0.1 s of a step of 60 mm in 1.5 s.
    assert max(abs(b - a) for a, b in zip(before.position, after.position, strict=True)) < 0.15


@pytest.mark.parametrize(
    ("silent", "heard", "stands"),
    [
        (10, True, False),  # 0.1 s, as long as a static walk bears
        (12, True, True),
        (12, False, True),  # the walker's frames were lost with its answers
        (60, False, True),
    ],
)
def test_a_walk_whose_answers_are_lost_for_too_long_goes_on_from_a_stand_where_it_was(
    silent: int, heard: bool, stands: bool
) -> None:
    controller, seq = make_controller("static", WalkOrder(steps=4)), 0
    for _ in repeat_while(lambda: controller.telemetry.step < 2):
        controller.tick(msgspec.structs.replace(frame(seq), command=seq - 1))
        seq += 1
    last, place = seq - 1, controller.planned_pose
    for seq in range(last + 1, last + silent + 1):
        if heard:
            controller.tick(msgspec.structs.replace(frame(seq), command=last))
    seq = last + silent + 1
    command = controller.tick(msgspec.structs.replace(frame(seq), command=last))
    assert (controller.state == "approach") == stands == bool(controller.interruptions)
    if stands:
        assert controller.planned_pose == pytest.approx(place, abs=0.06)
        assert controller.delay == 0.0
        # from where the joints are, by a command that is ahead of them by what they yield: 4 degrees at most
        assert command.position == pytest.approx(frame(seq).position, abs=0.07)
        for _ in repeat_while(lambda: controller.state == "approach"):
            seq += 1
            controller.tick(msgspec.structs.replace(frame(seq), command=seq - 1))
        assert controller.telemetry.step == 2
    for _ in repeat_while(lambda: not controller.done):
        seq += 1
        controller.tick(msgspec.structs.replace(frame(seq), command=seq - 1))
    assert controller.telemetry.step == 4
    assert controller.interruptions == stands


def test_a_walk_that_is_only_watched_is_not_interrupted() -> None:
    """In a rehearsal (`--dry-run`) none of the walker's answers is ever in force."""
    controller = make_controller("static", WalkOrder(steps=2), STIFF)
    for seq in repeat_while(lambda: not controller.done):
        controller.tick(frame(seq))
    assert controller.telemetry.step == 2
    assert controller.interruptions == 0


def test_a_dynamic_walk_that_a_gap_would_fell_goes_on_upright() -> None:
    """Joints hold for 0.45 s in single support. Of 11 seeds 10 stand, and 2 that go on in stride instead."""
    assert len(list(islice(filter(stands_after_a_gap, range(5)), 3))) == 3


def stands_after_a_gap(seed: int) -> bool:
    """Walk 8 dynamic steps whose answers are lost for 0.45 s after the fourth."""
    controller, guard = make_controller("dynamic", WalkOrder(steps=8)), Guard(BODY)
    with EmulatedRobot(BODY, seed=seed, engine="mujoco", wear=load_wear("nominal")) as robot:

        def cycle(*, answered: bool) -> None:
            answer = guard.check(controller.tick(robot.frame), robot.frame.seq) if answered else None
            robot.advance(guard.cycle(robot.frame, answer, supervised=True))

        for _ in repeat_while(lambda: controller.telemetry.step < 4 or controller.telemetry.phase != "SSR"):
            cycle(answered=True)
        for _ in range(45):
            cycle(answered=False)
        for _ in repeat_while(lambda: not (controller.done or robot.truth().fell)):
            cycle(answered=True)
        assert controller.telemetry.step == 8 or robot.truth().fell
        return not robot.truth().fell


def test_a_frame_that_comes_twice_moves_no_time() -> None:
    controller = make_controller("static", WalkOrder(steps=4), OFF)
    for seq in range(300):
        last = controller.tick(frame(seq))
    assert controller.tick(frame(299)).position == last.position


@pytest.mark.parametrize("angle", [(0.6, 0.0), (-0.6, 0.0), (0.0, 0.6), (0.0, -0.6)])
def test_a_fallen_robot_goes_limp_in_the_pose_it_has(angle: tuple[float, float]) -> None:
    controller = make_controller("static", WalkOrder(steps=4))
    for seq in range(200):
        command = controller.tick(frame(seq))
    assert command.stiffness == (1.0,) * N_JOINTS
    fall = frame(200, angle=angle)
    command = controller.tick(fall)
    assert controller.state == "fallen"
    assert ("rolled" if angle[0] else "pitched") in controller.fall_cause
    assert command.position == fall.position
    assert max(command.stiffness) <= 0.2
    for seq in range(201, 400):  # upright again, as someone lifts it: it stays limp
        assert controller.tick(frame(seq)).stiffness == command.stiffness
    assert controller.done


def test_a_robot_lifted_off_the_ground_in_its_walk_goes_limp() -> None:
    controller = make_controller("static", WalkOrder(steps=4), STIFF)
    seq = 0
    for _ in repeat_while(lambda: controller.state != "walk"):
        controller.tick(frame(seq))
        seq += 1
    for k in range(100):
        controller.tick(frame(seq + k, fsr=(0.0,) * 8))
    assert controller.state == "fallen" and "no foot" in controller.fall_cause


def test_a_robot_that_hangs_while_it_is_made_ready_is_not_falling() -> None:
    controller = make_controller("static", WalkOrder(steps=4))
    for seq in range(100):
        controller.tick(frame(seq, fsr=(0.0,) * 8))
    assert controller.state == "approach"


def test_switches_off_leave_the_plan_alone() -> None:
    """Without admittance and torso control no force and no angle changes a command once the robot is held."""
    calm, wild = (make_controller("static", WalkOrder(steps=4), OFF) for _ in range(2))
    assert calm.tick(frame(0)) == wild.tick(frame(0))
    for seq in range(1, 700):
        load = (1.0 + seq % 9,) * 8
        a = calm.tick(frame(seq))
        b = wild.tick(
            msgspec.structs.replace(frame(seq, fsr=load), angle=(0.1, -0.2), gyroscope=(1.0, -1.0, 0.5))
        )
        assert a.position == b.position
