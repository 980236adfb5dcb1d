"""What every engine must do, against closed forms: fall, swing, rest, slide, land, turn, block."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from bridge.body import TORSO, Body, joint_tree, load_body
from emulator.drives import Drives
from emulator.engine.base import Engine
from emulator.engine.catalogue import open_engine
from emulator.engine.mujoco.engine import MujocoEngine
from emulator.engine.mujoco.native import structure
from emulator.engine.settings import PhysicsSettings
from emulator.engine.values import Box, Surface
from emulator.poses import ORIGIN, Pose, quaternion
from emulator.world.world import WOOD
from tests.engines import energy, passive

BODY = load_body("nao-v6")
JOINTS = tuple(joint_tree(BODY))
MASS = sum(link.mass for link in BODY.links.values())
ROTOR = np.full(len(JOINTS), 0.004)
NOTHING = np.zeros(len(JOINTS))
G, DT = 9.81, 0.001


@pytest.fixture
def engine(physics: str) -> Iterator[Engine]:
    found = open_engine(physics, PhysicsSettings(step=DT, gravity=G))
    yield found
    found.close()


def run(engine: Engine, steps: int) -> None:
    for _ in range(steps):
        engine.run(1)


def at(height: float) -> Pose:
    return Pose((0.0, 0.0, height), ORIGIN.orientation)


def zero_pose_frame(body: Body, joint: str) -> np.ndarray:
    """Origin of a link in the Torso frame when all joints are at zero."""
    tree, place = joint_tree(body), np.zeros(3)
    for _ in range(len(tree)):
        if joint == TORSO:
            break
        place, joint = place + tree[joint].offset, tree[joint].parent
    return place


def test_links_are_where_the_data_sheet_has_them(engine: Engine) -> None:
    robot = engine.add_robot(BODY, Drives(ROTOR))
    robot.place(Pose((0.3, -0.2, 1.0), quaternion(0.2, -0.1, 0.7)))
    turn = np.reshape(robot.state().rotation, (3, 3))
    total = np.zeros(3)
    for name in (TORSO, *JOINTS):
        place = (0.3, -0.2, 1.0) + turn @ zero_pose_frame(BODY, name)
        np.testing.assert_allclose(robot.state(name).position, place, atol=1e-6)
        com = place + turn @ BODY.links[name].com
        np.testing.assert_allclose(robot.link_com(name), com, atol=1e-6)
        total += BODY.links[name].mass * com
    np.testing.assert_allclose(robot.com(), total / MASS, atol=1e-6)


def test_free_fall_is_galileos_and_keeps_the_energy(engine: Engine) -> None:
    robot = engine.add_robot(BODY, Drives(ROTOR))
    robot.place(at(3.0))
    start, before = np.array(robot.com()), energy(engine, robot)
    run(engine, 500)
    # symplectic Euler falls half a step further than g t^2 / 2
    drop = 0.5 * G * 0.5 * (0.5 + DT)
    np.testing.assert_allclose(robot.com() - start, (0.0, 0.0, -drop), atol=1e-4)
    # and so has lost the energy of that half step, m g (g t dt / 2)
    assert energy(engine, robot) == pytest.approx(before - MASS * G * G * 0.5 * DT / 2.0, rel=1e-3)


def test_a_link_of_a_held_robot_swings_as_a_physical_pendulum(engine: Engine) -> None:
    """Small swings of the head about its pitch axis, upside down: T = 2 pi sqrt(I / m g d)."""
    robot = engine.add_robot(BODY, Drives(NOTHING), held=True)
    head = BODY.links["HeadPitch"]
    arm = np.array(head.com)
    reach = math.hypot(arm[0], arm[2])
    inertia = head.inertia[1] + head.mass * reach**2
    i = JOINTS.index("HeadPitch")
    rest = -math.atan2(arm[0], arm[2])
    angles = np.zeros(len(JOINTS))
    angles[i] = rest + 0.05
    robot.place(Pose((0.0, 0.0, 2.0), (1.0, 0.0, 0.0, 0.0)), joints=angles.tolist())
    robot.lock([name for name in JOINTS if name != "HeadPitch"], 100.0)
    track = []
    for _ in range(3000):
        engine.run(1)
        track.append(robot.position[i] - rest)
    signs = np.sign(track)
    crossings = np.flatnonzero((signs[1:] > 0) & (signs[:-1] <= 0))
    period = float(np.diff(crossings).mean()) * DT
    expected = 2.0 * math.pi * math.sqrt(inertia / (head.mass * G * reach))
    assert period == pytest.approx(expected * (1.0 + 0.05**2 / 16.0), rel=0.01)
    assert max(track[-1000:]) == pytest.approx(0.05, rel=0.1)


def test_a_torque_on_a_joint_turns_its_rotor_too(engine: Engine) -> None:
    """A wrist with a rotor of an inertia far above its own: acceleration = torque / rotor inertia."""
    engine.surround(engine.surroundings._replace(gravity=(0.0, 0.0, 0.0)))
    robot = engine.add_robot(BODY, Drives(ROTOR), held=True)
    i = JOINTS.index("LWristYaw")
    middle = [0.5 * (BODY.joints[name].lower + BODY.joints[name].upper) for name in JOINTS]
    robot.place(at(1.0), joints=middle)
    robot.lock([name for name in JOINTS if name != "LWristYaw"], 50.0)
    robot.torque[i] = 0.02
    run(engine, 20)
    own = BODY.links["LWristYaw"].inertia[0] + BODY.links["LWristYaw"].mass * float(
        np.sum(np.square(BODY.links["LWristYaw"].com[1:]))
    )
    assert robot.velocity[i] == pytest.approx(0.02 / (0.004 + own) * 0.02, rel=0.05)


def test_a_blocked_joint_holds_what_its_load_demands(engine: Engine) -> None:
    """The arm held out to the front in a locked shoulder: torque = weight x arm, about its axis."""
    robot = engine.add_robot(BODY, Drives(ROTOR), held=True)
    robot.place(at(1.0))
    robot.lock(JOINTS, 50.0)
    run(engine, 300)
    i = JOINTS.index("LShoulderPitch")
    shoulder = np.array(robot.state("LShoulderPitch").position)
    names = [n for n in JOINTS if n.startswith(("LShoulder", "LElbow", "LWrist"))]
    moment = sum(BODY.links[name].mass * G * (robot.link_com(name)[0] - shoulder[0]) for name in names)
    assert abs(robot.lock_torque[i]) == pytest.approx(moment, rel=0.03)
    assert abs(robot.position[i]) < 2e-3


@pytest.mark.parametrize(("degrees", "slides"), [(10.5, False), (12.5, True)])
def test_a_box_on_a_slope_obeys_coulombs_cone(engine: Engine, degrees: float, slides: bool) -> None:
    """mu = 0.2: it slides from atan(0.2) = 11.3 degrees on, with g (sin a - mu cos a)."""
    slope = math.radians(degrees)
    floor = Pose(ORIGIN.position, quaternion(pitch=slope))
    engine.surround(engine.surroundings._replace(surface=replace(WOOD, friction=0.2), floor=floor))
    box = engine.add(Box((0.2, 0.2, 0.05), mass=0.5), at(0.025))
    before = np.array(box.state().position)
    engine.run(1000)
    way = float(np.linalg.norm(box.state().position - before))
    expected = 0.5 * G * (math.sin(slope) - 0.2 * math.cos(slope))
    assert way == pytest.approx(expected, rel=0.05) if slides else way < 2e-3


def test_a_movable_box_flies_as_it_was_moved_and_as_it_is_pushed(engine: Engine) -> None:
    engine.surround(engine.surroundings._replace(gravity=(0.0, 0.0, 0.0)))
    robot = engine.add_robot(BODY, Drives(ROTOR), held=True)
    robot.place(at(5.0))
    box = engine.add(Box((0.1, 0.2, 0.3), mass=2.0), at(1.0))
    spin = (0.0, 0.0, 1.5)
    box.place(Pose((0.0, 0.0, 1.0), quaternion(yaw=0.3)), (0.4, 0.0, 0.0), spin)
    engine.run(100, before_step=lambda: box.push((0.0, 5.0, 0.0)))
    state = box.state()
    np.testing.assert_allclose(state.angular_velocity, spin, atol=1e-3)
    np.testing.assert_allclose(state.velocity, (0.4, 5.0 * 0.1 / 2.0, 0.0), atol=1e-3)


def test_rays_meet_what_is_there_and_no_more(engine: Engine) -> None:
    step = engine.add(Box((0.2, 0.2, 0.1)), at(0.05))
    engine.add(Box((0.2, 0.2, 0.2), mass=1.0), Pose((1.0, 0.0, 0.1), ORIGIN.orientation))
    starts = [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (3.0, 0.0, 1.0), (3.0, 0.0, 1.0)]
    ends = [(0.0, 0.0, -1.0), (1.0, 0.0, -1.0), (3.0, 0.0, -1.0), (4.0, 0.0, 1.0)]
    hits = engine.rays(starts, ends)
    assert [hit.kind for hit in hits] == ["scene", "scene", "scene", "nothing"]
    np.testing.assert_allclose([hit.point[2] for hit in hits[:3]], (0.1, 0.2, 0.0), atol=1e-3)
    np.testing.assert_allclose([hit.normal for hit in hits[:3]], [(0.0, 0.0, 1.0)] * 3, atol=1e-6)
    ground = engine.rays(starts[:2], ends[:2], ground_only=True)
    np.testing.assert_allclose([hit.fraction for hit in ground], (0.45, 0.5), atol=1e-3)
    engine.remove(step)
    (gone,) = engine.rays(starts[:1], ends[:1])
    assert gone.fraction == pytest.approx(0.5, abs=1e-3)


def test_something_new_leaves_the_motion_of_the_rest_as_it_is(engine: Engine) -> None:
    robot = engine.add_robot(BODY, Drives(ROTOR))
    robot.place(at(3.0))
    run(engine, 100)
    before = robot.state()
    engine.add(Box((0.1, 0.1, 0.1), mass=1.0), Pose((2.0, 0.0, 0.5), ORIGIN.orientation))
    engine.surround(engine.surroundings._replace(surface=replace(WOOD, friction=0.3)))
    after = robot.state()
    assert (after.position, after.velocity) == (before.position, before.velocity)
    run(engine, 100)
    assert robot.state().velocity[2] == pytest.approx(-G * 0.2, abs=1e-3)


def test_a_new_engine_gives_the_same_bits_again(physics: str) -> None:
    ends = []
    for _ in range(2):
        engine = open_engine(physics, PhysicsSettings())
        engine.surround(engine.surroundings._replace(surface=replace(WOOD, friction=0.7)))
        robot = engine.add_robot(BODY, Drives(ROTOR))
        robot.place(at(0.4))
        engine.run(600)
        ends.append((robot.position.tolist(), robot.state(), robot.contacts))
        engine.close()
    assert ends[0] == ends[1]
    assert sum(foot.force[2] for foot in ends[0][2].feet.values()) > 0.1 * MASS * G


def test_limbs_meet_each_other(engine: Engine) -> None:
    robot = engine.add_robot(BODY, Drives(ROTOR), held=True)
    robot.place(at(1.0))
    assert engine.overlap(robot, robot) == 0.0
    angles = dict.fromkeys(JOINTS, 0.0) | {"LHipRoll": -0.37, "RHipRoll": 0.37}
    robot.place(at(1.0), joints=list(angles.values()))
    assert engine.overlap(robot, robot) > 0.01


def test_a_robot_on_a_hook_hangs_where_it_was_and_falls_when_it_is_let_go(engine: Engine) -> None:
    robot = engine.add_robot(BODY, Drives(ROTOR))
    pose = Pose((0.1, 0.2, 1.5), quaternion(0.3, 0.2, -0.4))
    robot.place(pose, held=True)
    run(engine, 300)
    engine.add(Box((0.1, 0.1, 0.1)), Pose((2.0, 0.0, 0.05), ORIGIN.orientation))
    run(engine, 300)
    np.testing.assert_allclose(robot.state().position, pose.position, atol=3e-3)
    np.testing.assert_allclose(robot.state().orientation, pose.orientation, atol=5e-3)
    robot.place(pose)
    before = robot.com()[2]
    run(engine, 100)
    assert before - robot.com()[2] == pytest.approx(0.5 * G * 0.1**2, rel=0.1)


def test_the_places_of_fields_are_those_of_the_installed_version() -> None:
    engine = MujocoEngine(PhysicsSettings())
    surface = Surface(friction=1.0, stiffness_per_area=1e8, relaxation=0.01)
    engine.surround(engine.surroundings._replace(surface=surface))
    robot = engine.add_robot(BODY, passive(BODY, 0.01))
    robot.place(Pose((0.0, 0.0, 0.333)))
    engine.run(20)
    data = engine.simulation.data
    state, contact = structure("mjData"), structure("mjContact")
    seen = state.from_address(data._address)
    assert data.ncon > 4
    assert (seen.ncon, seen.nefc, seen.time) == (data.ncon, data.nefc, data.time)
    assert seen.qpos == data.qpos.ctypes.data
    assert seen.efc_force == data.efc_force.ctypes.data
    for i in range(data.ncon):
        one = contact.from_address(seen.contact + i * data.contact.pos.strides[0])
        assert (*one.pos, *one.frame) == (*data.contact.pos[i], *data.contact.frame[i])
        assert (*one.geom, one.efc_address) == (*data.contact.geom[i], data.contact.efc_address[i])
