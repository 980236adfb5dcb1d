"""The guard's states, cycle by cycle: watchdog, crouch, stop and arm, fall, heat and charge. No wall clock."""

from __future__ import annotations

import contextlib
import math
from typing import Literal

import msgspec
import pytest

from bridge.body.joints import INDEX, JOINTS, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.config import parse_toml
from bridge.errors import ConfigurationError, FrameError
from bridge.guard import Guard, GuardSettings
from bridge.guard.guard import STAND_UP_HOLD
from bridge.messages import ActuatorFrame
from tests.guarded import BODY, LEGS, SETTINGS, STAND, Robot, command, sensors, until_rest
from tests.loops import repeat_while


def test_a_silent_controllers_robot_is_held_then_crouches_then_lets_go() -> None:
    robot = Robot(Guard(BODY))
    for _ in range(5):
        robot.command()
    dog = SETTINGS.watchdog
    states = robot.silence(dog.silence_cycles + dog.hold_cycles)
    assert states[: dog.silence_cycles - 1] == ["active"] * (dog.silence_cycles - 1)
    assert states[dog.silence_cycles - 1 : -1] == ["hold"] * dog.hold_cycles
    assert states[-1] == "crouch"
    assert robot.guard.take_revocation() and not robot.guard.take_revocation()
    # a rest-to-rest motion without jumps takes at least way / speed, and less than three times that
    way = max(abs(a - b) for a, b in zip(STAND, POSTURES["Crouch"], strict=True))
    cycles = until_rest(robot)
    crouch = SETTINGS.crouch
    shortest = way / crouch.speed + crouch.settle_time + crouch.release_time
    assert shortest < cycles * BODY.cycle < 3.0 * shortest
    inside = [i for i in LEGS if JOINTS[i] not in ("LAnkleRoll", "RAnkleRoll")]  # those are coupled there
    assert [robot.position[i] for i in inside] == pytest.approx([POSTURES["Crouch"][i] for i in inside])
    assert robot.stiffness == crouch.rest_stiffness
    given = robot.guard.stiffness
    assert given is not None and {given[i] for i in range(N_JOINTS) if i not in LEGS} == {0.0}


def test_no_joint_is_faster_than_the_settings_say_on_the_way_down() -> None:
    robot = Robot(Guard(BODY))
    robot.command()
    robot.silence(SETTINGS.watchdog.silence_cycles + SETTINGS.watchdog.hold_cycles - 1)
    last = robot.position
    for _ in repeat_while(lambda: robot.guard.state != "rest"):
        robot.cycle(None)
        fastest = max(abs(a - b) for a, b in zip(robot.position, last, strict=True)) / BODY.cycle
        assert fastest <= SETTINGS.crouch.speed * (1.0 + 1e-6)
        last = robot.position


def test_a_word_in_time_keeps_the_robot_up() -> None:
    robot = Robot(Guard(BODY))
    robot.command()
    for _ in range(5):
        assert set(robot.silence(SETTINGS.watchdog.silence_cycles + SETTINGS.watchdog.hold_cycles - 1)) == {
            "active",
            "hold",
        }
        robot.command()
        assert robot.guard.state == "active"


def test_nobody_is_owed_a_command_by_a_robot_that_was_given_back_or_never_held() -> None:
    robot = Robot(Guard(BODY))
    assert set(robot.silence(500)) == {"idle"}
    robot.command()
    assert set(robot.silence(500, supervised=False)) == {"active"}
    robot.guard.released(robot.seq)
    assert robot.guard.state == "hold"
    assert set(robot.silence(500, supervised=False)) == {"hold"}
    # a new holder that takes its time before its first command
    assert set(robot.silence(500)) == {"hold"}


def test_a_timed_command_does_not_end_the_watch_over_its_sender() -> None:
    """It is a sign of life, and so are the timed commands that still wait; then the silence counts."""
    robot = Robot(Guard(BODY))
    robot.command()
    dog = SETTINGS.watchdog
    robot.silence(dog.silence_cycles - 1)
    robot.guard.accept_timed(robot.seq)
    for _ in range(200):
        robot.guard.timed_waiting()
        robot.cycle(None)
    assert robot.guard.state == "active"
    states = robot.silence(dog.silence_cycles + dog.hold_cycles)
    assert states[-1] != "active" and robot.guard.take_revocation()


def test_a_new_controller_takes_over_from_the_crouch_slowly() -> None:
    robot = Robot(Guard(BODY))
    robot.command()
    robot.silence(SETTINGS.watchdog.silence_cycles + SETTINGS.watchdog.hold_cycles)
    until_rest(robot)
    start = robot.position
    given = robot.command(lease=2)
    assert given is not None and robot.guard.state == "approach"
    way = max(abs(a - b) for a, b in zip(given.position, start, strict=True))
    assert way <= SETTINGS.approach.speed * BODY.cycle + 1e-9
    assert given.stiffness == (1.0,) * N_JOINTS
    cycles = 1
    for _ in repeat_while(lambda: robot.guard.state == "approach"):
        robot.command(lease=2)
        cycles += 1
    farthest = max(abs(a - b) for a, b in zip(start, STAND, strict=True))
    assert cycles * BODY.cycle == pytest.approx(farthest / SETTINGS.approach.speed, abs=0.05)
    given = robot.command(lease=2)
    assert given is not None and given.position == robot.guard.check(command(0), 0).position


def test_a_robot_rises_with_all_joints_arriving_together() -> None:
    """On a straight line in joint space: a hip that is there before its knee topples the robot."""
    robot = Robot(Guard(BODY))
    robot.command()
    robot.silence(SETTINGS.watchdog.silence_cycles + SETTINGS.watchdog.hold_cycles)
    until_rest(robot)
    start, ends = robot.position, robot.guard.check(command(0), 0).position
    shares = []
    robot.command(lease=2)
    step, knee = SETTINGS.approach.speed * BODY.cycle, INDEX["LKneePitch"]
    for _ in repeat_while(lambda: robot.guard.state == "approach"):
        share = (robot.position[knee] - start[knee]) / (ends[knee] - start[knee])
        for now, begin, end in zip(robot.position, start, ends, strict=True):
            assert abs(now - (begin + share * (end - begin))) <= step  # rad off the straight line
        shares.append(share)
        robot.command(lease=2)
    assert shares == sorted(shares) and len(shares) > 50


def test_a_crouched_robot_of_little_stiffness_is_not_let_go_any_further() -> None:
    """As behind another guard that has brought it down and then says no more."""
    crouch = POSTURES[SETTINGS.crouch.posture]
    robot = Robot(Guard(BODY), crouch, SETTINGS.crouch.rest_stiffness)
    robot.cycle(command(0, crouch, SETTINGS.crouch.rest_stiffness))
    robot.silence(SETTINGS.watchdog.silence_cycles + SETTINGS.watchdog.hold_cycles)
    until_rest(robot)
    assert robot.stiffness == SETTINGS.crouch.rest_stiffness


@pytest.mark.parametrize("how", ["crouch", "limp"])
def test_an_emergency_stop_needs_arming_afterwards(how: str) -> None:
    robot = Robot(Guard(BODY))
    robot.command()
    done = robot.guard.stop("limp" if how == "limp" else "crouch", "a test")
    assert not done.is_set()
    robot.cycle(None)
    assert done.is_set() and robot.guard.take_revocation()
    assert robot.guard.state == ("rest" if how == "limp" else "crouch")
    if how == "limp":
        assert robot.stiffness == 0.0
    with pytest.raises(FrameError, match="nao-hil arm"):
        robot.command(lease=2)
    until_rest(robot)
    assert robot.stiffness == (0.0 if how == "limp" else SETTINGS.crouch.rest_stiffness)
    assert robot.guard.status.reason == "stop" and not robot.guard.status.armed
    robot.guard.arm()
    robot.cycle(None)
    robot.command(lease=2)
    assert robot.guard.state in ("approach", "active")


def test_a_disarmed_robot_is_left_alone_and_takes_nothing() -> None:
    robot = Robot(Guard(BODY, armed=False))
    assert robot.cycle(None) is None
    with pytest.raises(FrameError, match="not armed"):
        robot.command()
    assert robot.cycle(None) is None
    robot.guard.arm()
    robot.cycle(None)
    assert robot.command() is not None


def test_a_falling_robot_goes_limp_and_takes_commands_again_when_it_lies() -> None:
    robot, fall = Robot(Guard(BODY)), SETTINGS.fall
    for _ in range(fall.stood_cycles):
        robot.command()
    robot.angle = (0.0, 0.9)
    for _ in range(fall.cycles - 1):
        robot.command()
        assert robot.guard.state == "active"
    given = robot.command()
    assert robot.guard.state == "fallen"
    assert given is not None and given.stiffness == (fall.stiffness,) * N_JOINTS
    cycles = 0
    for _ in repeat_while(lambda: robot.guard.state == "fallen"):
        robot.command()
        cycles += 1
    assert cycles * BODY.cycle == pytest.approx(fall.rest_time, abs=2 * BODY.cycle)
    # getting up: still far from upright, and not taken for another fall
    for _ in range(200):
        robot.command()
    assert robot.guard.state == "active"
    for robot.angle in ((0.0, -0.9), (0.1, 0.0), (0.0, -0.9)):  # leans on its hands, sits, leans
        for _ in range(100):
            robot.command(POSTURES["SitRelax"])
    assert robot.guard.state == "active"
    # a V3 draws a foot in under its hip, upright for 0.22 s, and leans by 44 degrees on its hand after that
    for robot.angle, time in (((0.1, 0.0), 0.22), ((0.7, -0.3), 0.5)):
        for _ in range(round(time / BODY.cycle)):
            robot.command()
    assert robot.guard.state == "active"
    robot.angle = (0.1, 0.0)
    for _ in range(200):
        robot.command()
    robot.angle = (-0.9, 0.0)
    for _ in range(fall.cycles):
        robot.command()
    assert robot.guard.state == "fallen"


@pytest.mark.parametrize("roll", [-15.0, 0.0, 15.0])
@pytest.mark.parametrize("pitch", [-20.0, 0.0, 20.0])
def test_a_robot_on_a_slope_or_swaying_has_not_fallen(roll: float, pitch: float) -> None:
    robot = Robot(Guard(BODY))
    robot.angle = (math.radians(roll), math.radians(pitch))
    for _ in range(300):
        robot.command()
    assert robot.guard.state == "active"


def test_one_wrong_angle_is_no_fall() -> None:
    robot = Robot(Guard(BODY))
    for n in range(100):
        robot.angle = (0.0, 1.5) if n % SETTINGS.fall.cycles == 0 else (0.0, 0.0)
        robot.command()
    assert robot.guard.state == "active"


@pytest.mark.parametrize("posture", ["Sit", "SitRelax", "LyingBelly", "LyingBack"])
def test_a_robot_that_does_not_stand_is_not_made_to_crouch(posture: str) -> None:
    robot = Robot(Guard(BODY), POSTURES[posture])
    robot.command(POSTURES[posture])
    robot.silence(SETTINGS.watchdog.silence_cycles + SETTINGS.watchdog.hold_cycles)
    assert robot.guard.state == "rest"
    before = robot.position
    until_rest(robot)
    assert robot.position == before and robot.stiffness == 0.0


def test_a_limp_robot_is_not_made_to_crouch() -> None:
    robot = Robot(Guard(BODY), stiffness=0.0)
    robot.cycle(command(0, stiffness=0.0))
    robot.silence(SETTINGS.watchdog.silence_cycles + SETTINGS.watchdog.hold_cycles)
    assert robot.guard.state == "rest"
    assert robot.stiffness == 0.0


@pytest.mark.parametrize(("field", "bad", "between"), [("heat", 99.0, 90.0), ("charge", 0.01, 0.08)])
def test_too_hot_or_too_empty_the_robot_goes_down_and_takes_nothing_until_it_is_well_again(
    field: str, bad: float, between: float
) -> None:
    robot = Robot(Guard(BODY))
    good = getattr(robot, field)
    robot.command()
    setattr(robot, field, bad)
    robot.command()
    assert robot.guard.state == "crouch"
    assert robot.guard.status.reason == {"heat": "temperature", "charge": "battery"}[field]
    setattr(robot, field, between)
    for _ in range(1000):
        robot.command()
    assert robot.guard.state == "rest" and robot.stiffness == SETTINGS.crouch.rest_stiffness
    setattr(robot, field, good)
    robot.command()
    assert robot.guard.state == "approach"


def test_an_unreadable_sensor_is_reported_once_and_brings_the_robot_down_after_its_time() -> None:
    """Of any kind: a controller could not see that the value is old."""
    for field, slot in (("sonar", 0), ("position", LEGS[3]), ("angle", 1)):
        guard = Guard(BODY)
        limit = SETTINGS.sensors.unreadable_cycles

        def cycle(seq: int, read: bool, guard: Guard = guard, field: str = field, slot: int = slot) -> str:
            frame = sensors(seq)
            if not read:
                values = list(getattr(frame, field))
                values[slot] = math.nan
                frame = msgspec.structs.replace(frame, **{field: tuple(values)})
            finite = guard.sense(frame)
            assert getattr(finite, field) == getattr(sensors(seq), field)  # the last value
            with contextlib.suppress(FrameError):
                guard.cycle(finite, guard.check(command(seq), seq), supervised=True)
            return guard.state

        for seq in range(10):
            assert cycle(seq, True) == "active"
        states = [cycle(seq, False) for seq in range(10, 10 + 2 * limit)]
        assert states[: limit - 1] == ["active"] * (limit - 1)
        assert states[limit:] == ["crouch"] * limit
        assert guard.status.reason == "sensors" and guard.take_revocation()
        codes = [notice.code for notice in guard.take_notices()]
        assert codes.count("sensor-unreadable") == 1
        # readable in every second frame: neither reported again nor trusted
        for seq in range(1000, 1000 + 4 * limit):
            assert cycle(seq, seq % 2 == 0) in ("crouch", "rest")
        states = [cycle(seq, True) for seq in range(2000, 2000 + limit + 1)]
        assert "approach" not in states[: limit - 1] and states[-1] in ("approach", "active")
        codes = [notice.code for notice in guard.take_notices()]
        assert codes.count("sensor-unreadable") == 0 and codes.count("sensor-readable") == 1


@pytest.mark.parametrize("how", ["crouch", "limp"])
def test_a_stop_releases_a_robot_whose_joints_were_never_read(how: Literal["crouch", "limp"]) -> None:
    """Its pose is unknown, so no motion is safe."""
    guard = Guard(BODY, armed=False)
    blind = msgspec.structs.replace(sensors(0), position=(math.nan,) * N_JOINTS)
    assert guard.cycle(blind, None) is None
    guard.arm()
    guard.cycle(blind, None)
    guard.cycle(blind, guard.check(command(0), 0))
    assert guard.state == "idle" and guard.armed  # it takes no command
    guard.stop(how)
    given = guard.cycle(msgspec.structs.replace(blind, seq=1), None)
    assert given is not None and guard.state == "rest"
    assert max(given.stiffness) <= SETTINGS.crouch.rest_stiffness
    assert all(map(math.isfinite, given.position))


def test_a_robot_that_was_laid_down_is_left_alone_until_a_command_after_a_moment() -> None:
    """Of a controller that had it; before, the first cycle ended the robot's process."""
    robot = Robot(Guard(BODY))
    robot.command()
    robot.guard.laid_down(robot.seq)
    hold = round(STAND_UP_HOLD / BODY.cycle)
    given = [robot.command() if seq % 2 else robot.cycle(None) for seq in range(hold - 1)]
    assert given == [None] * (hold - 1)
    assert robot.guard.state == "idle"
    assert robot.command() is not None


def test_after_long_silence_in_the_crouch_the_robot_sits_down_and_lets_go() -> None:
    robot = Robot(Guard(BODY))
    robot.command()
    robot.silence(SETTINGS.watchdog.silence_cycles + SETTINGS.watchdog.hold_cycles)
    until_rest(robot)
    states = robot.silence(round(SETTINGS.sit.after / BODY.cycle) + 1)
    assert set(states[:-2]) == {"rest"} and states[-1] == "sit"
    stopped = [robot.guard.state for _ in range(100) if robot.command() is not None]
    assert set(stopped) == {"sit"}  # a command in between would move half a seat
    until_rest(robot)
    sit = POSTURES["SitRelax"]  # where the motion ends; the vendor's knees are a little under its own bound
    assert [robot.position[i] for i in LEGS] == pytest.approx([sit[i] for i in LEGS], abs=0.02)
    assert robot.stiffness == SETTINGS.crouch.rest_stiffness
    robot.silence(round(2.0 * SETTINGS.sit.after / BODY.cycle))
    assert robot.guard.state == "rest"
    robot.command()
    assert robot.guard.state == "approach"


def test_a_stopped_robot_stays_in_its_crouch() -> None:
    robot = Robot(Guard(BODY))
    robot.command()
    robot.guard.stop("crouch")
    assert "sit" not in robot.silence(round(2.0 * SETTINGS.sit.after / BODY.cycle))


def test_a_joint_that_was_limp_starts_from_where_it_is() -> None:
    robot = Robot(Guard(BODY))
    elbow = INDEX["LElbowYaw"]
    limp = command(0)
    free = list(limp.stiffness)
    free[elbow] = 0.0
    robot.cycle(msgspec.structs.replace(limp, stiffness=tuple(free)))
    turned = list(STAND)
    turned[elbow] = 1.0  # by hand
    robot.position = tuple(turned)
    given = robot.command()
    assert given is not None and robot.guard.state == "approach"
    assert given.position[elbow] == pytest.approx(1.0 - SETTINGS.approach.speed * BODY.cycle)


def leg_swing(seq: int, speed: float = 1.0) -> tuple[float, ...]:
    """StandInit, hips and knees swinging to and fro at `speed`, rad/s, by 0.3 rad, the legs out of phase."""
    moved = list(STAND)
    for side, ahead in (("L", 0.0), ("R", 0.3)):
        phase = (seq * BODY.cycle * speed + ahead) % 1.2
        swing = phase - 0.3 if phase < 0.6 else 0.9 - phase
        moved[INDEX[f"{side}HipPitch"]] -= swing
        moved[INDEX[f"{side}KneePitch"]] += swing
    return tuple(moved)


def with_arms(seq: int, arms: float, position: tuple[float, ...]) -> ActuatorFrame:
    """A command with another stiffness of the arms."""
    stiffness = tuple(arms if j[1:].startswith(("Shoulder", "Elbow")) else 1.0 for j in JOINTS)
    return msgspec.structs.replace(command(seq, position), stiffness=stiffness)


def test_limp_arms_do_not_slow_the_legs() -> None:
    """A knee is 0.3 rad from the first command, a limp arm 1 rad: the way takes as long as the knee needs."""
    robot = Robot(Guard(BODY))
    away = list(STAND)
    away[INDEX["LShoulderPitch"]] -= 1.0
    away[INDEX["LKneePitch"]] += 0.3
    robot.position = tuple(away)
    knee = INDEX["LKneePitch"]
    for _ in repeat_while(lambda: robot.position[knee] != STAND[knee]):
        robot.cycle(with_arms(robot.seq, 0.0, STAND))
    assert robot.seq * BODY.cycle == pytest.approx(0.3 / SETTINGS.approach.speed, abs=0.02)
    assert robot.guard.state == "active"


def test_a_joint_that_stiffens_in_a_walk_leaves_the_others_alone() -> None:
    """Two walks, one of which stiffens its arms on the way, a long way from where they hang."""
    frames: list[list[tuple[float, ...]]] = []
    for late in (False, True):
        robot, legs = Robot(Guard(BODY)), []
        hanging = list(STAND)
        hanging[INDEX["LShoulderPitch"]] -= 1.0
        robot.position = tuple(hanging)
        for seq in range(300):
            given = robot.cycle(with_arms(seq, float(late and seq >= 150), leg_swing(seq)))
            assert given is not None
            legs.append(tuple(given.position[slot] for slot in LEGS))
            if late and seq == 150:
                assert robot.guard.state == "approach"
        assert robot.guard.state == ("approach" if late else "active")
        frames.append(legs)
    assert frames[0] == frames[1]


def test_a_command_that_moves_on_ends_its_approach_in_time() -> None:
    """At 1 rad/s, faster than the approach: after 1.5 times the way's duration the guard lets go."""
    robot = Robot(Guard(BODY))
    robot.command()
    begun = robot.guard.check(command(0, leg_swing(0)), robot.seq).position
    way = max(abs(a - b) for a, b in zip(robot.position, begun, strict=True))
    robot.command(leg_swing(0), lease=2)
    assert robot.guard.state == "approach"
    for cycles in repeat_while(lambda: robot.guard.state == "approach"):
        robot.command(leg_swing(cycles + 1), lease=2)
    assert cycles * BODY.cycle <= max(1.5 * way / SETTINGS.approach.speed, 0.5) + BODY.cycle


def test_a_served_protocol_is_followed_as_its_robot_follows_it() -> None:
    """No approach, no limit of the speed, no reaction to a fall; ranges hold."""
    guard, far = Guard(BODY), POSTURES["Crouch"]
    frame = sensors(0)
    wanted = guard.check(command(0, far), 0)
    assert guard.cycle(frame, wanted, supervised=True, direct=True) == wanted
    assert guard.state == "active"
    lying = sensors(1, far, angle=(0.0, 1.5))
    for seq in range(1, 20):
        wanted = guard.check(command(seq, STAND if seq % 2 else far), seq)
        given = guard.cycle(msgspec.structs.replace(lying, seq=seq), wanted, supervised=True, direct=True)
        assert given == wanted and guard.state == "active"


def test_the_settings_refuse_what_cannot_be() -> None:
    text = '[fall]\nangle = 0.3\nupright = 0.4\n[crouch]\nposture = "Crouch"'
    with pytest.raises(ConfigurationError, match="upright must be smaller"):
        parse_toml(text, "guard.toml", GuardSettings)
    with pytest.raises(ConfigurationError, match="did you mean 'Crouch'"):
        parse_toml('[crouch]\nposture = "Crouhc"', "guard.toml", GuardSettings)
