"""What every engine must do, against closed forms: fall, swing, rest, slide, land, turn, block."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from bridge.body import TORSO, Body, joint_tree, load_body
from emulator.engine.base import Engine
from emulator.engine.catalogue import open_engine
from emulator.engine.mujoco.engine import MujocoEngine
from emulator.engine.mujoco.native import structure
from emulator.engine.values import PhysicsSettings, PinholeCamera, Surface
from emulator.poses import ORIGIN, Pose, quaternion
from emulator.world.world import WOOD

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
        engine.step(np.zeros(len(JOINTS)))


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
    engine.add_robot(BODY, ROTOR)
    engine.robot.set_torso(Pose((0.3, -0.2, 1.0), quaternion(0.2, -0.1, 0.7)))
    turn = np.reshape(engine.robot.torso().rotation, (3, 3))
    total = np.zeros(3)
    for name in (TORSO, *JOINTS):
        place = (0.3, -0.2, 1.0) + turn @ zero_pose_frame(BODY, name)
        np.testing.assert_allclose(engine.robot.link_pose(name).position, place, atol=1e-6)
        com = place + turn @ BODY.links[name].com
        np.testing.assert_allclose(engine.robot.link_com(name), com, atol=1e-6)
        total += BODY.links[name].mass * com
    np.testing.assert_allclose(engine.robot.com(), total / MASS, atol=1e-6)


def test_free_fall_is_galileos_and_keeps_the_energy(engine: Engine) -> None:
    engine.add_robot(BODY, ROTOR)
    engine.robot.set_torso(at(3.0))
    start, energy = np.array(engine.robot.com()), engine.robot.energy()
    run(engine, 500)
    # symplectic Euler falls half a step further than g t^2 / 2
    drop = 0.5 * G * 0.5 * (0.5 + DT)
    np.testing.assert_allclose(engine.robot.com() - start, (0.0, 0.0, -drop), atol=1e-4)
    # and so has lost the energy of that half step, m g (g t dt / 2)
    assert engine.robot.energy() == pytest.approx(energy - MASS * G * G * 0.5 * DT / 2.0, rel=1e-3)


def test_a_link_of_a_held_robot_swings_as_a_physical_pendulum(engine: Engine) -> None:
    """Small swings of the head about its pitch axis, upside down: T = 2 pi sqrt(I / m g d)."""
    engine.add_robot(BODY, NOTHING, held=True)
    engine.robot.set_torso(Pose((0.0, 0.0, 2.0), (1.0, 0.0, 0.0, 0.0)))
    head = BODY.links["HeadPitch"]
    arm = np.array(head.com)
    reach = math.hypot(arm[0], arm[2])
    inertia = head.inertia[1] + head.mass * reach**2
    i = JOINTS.index("HeadPitch")
    rest = -math.atan2(arm[0], arm[2])
    angles = np.zeros(len(JOINTS))
    angles[i] = rest + 0.05
    engine.robot.set_joints(angles.tolist())
    engine.robot.lock([name for name in JOINTS if name != "HeadPitch"], 100.0)
    track = []
    for _ in range(3000):
        engine.step(np.zeros(len(JOINTS)))
        track.append(engine.robot.position[i] - rest)
    signs = np.sign(track)
    crossings = np.flatnonzero((signs[1:] > 0) & (signs[:-1] <= 0))
    period = float(np.diff(crossings).mean()) * DT
    expected = 2.0 * math.pi * math.sqrt(inertia / (head.mass * G * reach))
    assert period == pytest.approx(expected * (1.0 + 0.05**2 / 16.0), rel=0.01)
    assert max(track[-1000:]) == pytest.approx(0.05, rel=0.1)


def test_a_torque_on_a_joint_turns_its_rotor_too(engine: Engine) -> None:
    """A wrist with a rotor of an inertia far above its own: acceleration = torque / rotor inertia."""
    engine.set_gravity((0.0, 0.0, 0.0))
    engine.add_robot(BODY, ROTOR, held=True)
    engine.robot.set_torso(at(1.0))
    i = JOINTS.index("LWristYaw")
    engine.robot.set_joints([0.5 * (BODY.joints[name].lower + BODY.joints[name].upper) for name in JOINTS])
    engine.robot.lock([name for name in JOINTS if name != "LWristYaw"], 50.0)
    torque = np.zeros(len(JOINTS))
    for _ in range(20):
        torque[:] = 0.0
        torque[i] = 0.02
        engine.step(torque)
    own = BODY.links["LWristYaw"].inertia[0] + BODY.links["LWristYaw"].mass * float(
        np.sum(np.square(BODY.links["LWristYaw"].com[1:]))
    )
    assert engine.robot.velocity[i] == pytest.approx(0.02 / (0.004 + own) * 0.02, rel=0.05)


def test_the_hips_are_one_motor(engine: Engine) -> None:
    engine.add_robot(BODY, ROTOR, held=True)
    engine.robot.set_torso(at(1.0))
    left, right = JOINTS.index("LHipYawPitch"), JOINTS.index("RHipYawPitch")
    for _ in range(100):
        torque = np.zeros(len(JOINTS))
        torque[left] = -1.0
        engine.step(torque)
        assert engine.robot.position[left] == pytest.approx(engine.robot.position[right], abs=1e-3)
    assert engine.robot.position[left] < -0.05


def test_a_blocked_joint_holds_what_its_load_demands(engine: Engine) -> None:
    """The arm held out to the front in a locked shoulder: torque = weight x arm, about its axis."""
    engine.add_robot(BODY, ROTOR, held=True)
    engine.robot.set_torso(at(1.0))
    engine.robot.lock(JOINTS, 50.0)
    run(engine, 300)
    i = JOINTS.index("LShoulderPitch")
    shoulder = np.array(engine.robot.link_pose("LShoulderPitch").position)
    names = [n for n in JOINTS if n.startswith(("LShoulder", "LElbow", "LWrist"))]
    moment = sum(BODY.links[name].mass * G * (engine.robot.link_com(name)[0] - shoulder[0]) for name in names)
    assert abs(engine.robot.lock_torque()[i]) == pytest.approx(moment, rel=0.03)
    assert abs(engine.robot.position[i]) < 2e-3


@pytest.mark.parametrize(("degrees", "slides"), [(10.5, False), (12.5, True)])
def test_a_box_on_a_slope_obeys_coulombs_cone(engine: Engine, degrees: float, slides: bool) -> None:
    """mu = 0.2: it slides from atan(0.2) = 11.3 degrees on, with g (sin a - mu cos a)."""
    engine.scene.set_surface(replace(WOOD, friction=0.2))
    slope = math.radians(degrees)
    engine.scene.place_floor(Pose(ORIGIN.position, quaternion(pitch=slope)))
    engine.scene.add_box("box", (0.2, 0.2, 0.05), at(0.025), mass=0.5)
    before = np.array(engine.scene.pose("box").position)
    for _ in range(1000):
        engine.bare_step()
    way = float(np.linalg.norm(engine.scene.pose("box").position - before))
    expected = 0.5 * G * (math.sin(slope) - 0.2 * math.cos(slope))
    assert way == pytest.approx(expected, rel=0.05) if slides else way < 2e-3


def test_a_box_that_lands_stays_down(engine: Engine) -> None:
    """Restitution 0: after the fall of 20 cm it never leaves the floor again by more than a millimetre."""
    engine.scene.add_box("box", (0.1, 0.1, 0.1), at(0.25), mass=0.5)
    heights = []
    for _ in range(600):
        engine.bare_step()
        heights.append(engine.scene.pose("box").position[2])
    landed = int(np.argmax(np.array(heights) < 0.0505))
    # t = sqrt(2 h / g)
    assert landed * DT == pytest.approx(math.sqrt(2.0 * 0.2 / G), abs=3 * DT)
    assert max(heights[landed:]) < 0.0515
    assert heights[-1] == pytest.approx(0.05, abs=5e-4)


def test_a_movable_box_flies_as_it_was_moved_and_as_it_is_pushed(engine: Engine) -> None:
    engine.set_gravity((0.0, 0.0, 0.0))
    engine.add_robot(BODY, ROTOR, held=True)
    engine.robot.set_torso(at(5.0))
    engine.scene.add_box("box", (0.1, 0.2, 0.3), at(1.0), mass=2.0)
    spin = (0.0, 0.0, 1.5)
    engine.scene.move("box", Pose((0.0, 0.0, 1.0), quaternion(yaw=0.3)), ((0.4, 0.0, 0.0), spin))
    for _ in range(100):
        engine.scene.push("box", (0.0, 5.0, 0.0))
        run(engine, 1)
    velocity, turning = engine.scene.velocity("box")
    np.testing.assert_allclose(turning, spin, atol=1e-3)
    np.testing.assert_allclose(velocity, (0.4, 5.0 * 0.1 / 2.0, 0.0), atol=1e-3)


def test_rays_meet_what_is_there_and_no_more(engine: Engine) -> None:
    engine.scene.add_box("step", (0.2, 0.2, 0.1), at(0.05))
    engine.scene.add_box("loose", (0.2, 0.2, 0.2), Pose((1.0, 0.0, 0.1), ORIGIN.orientation), mass=1.0)
    starts = [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (3.0, 0.0, 1.0), (3.0, 0.0, 1.0)]
    ends = [(0.0, 0.0, -1.0), (1.0, 0.0, -1.0), (3.0, 0.0, -1.0), (4.0, 0.0, 1.0)]
    hits = engine.rays(starts, ends)
    assert [hit.kind for hit in hits] == ["scene", "scene", "scene", "nothing"]
    np.testing.assert_allclose([hit.point[2] for hit in hits[:3]], (0.1, 0.2, 0.0), atol=1e-3)
    np.testing.assert_allclose([hit.normal for hit in hits[:3]], [(0.0, 0.0, 1.0)] * 3, atol=1e-6)
    ground = engine.rays(starts[:2], ends[:2], ground_only=True)
    np.testing.assert_allclose([hit.fraction for hit in ground], (0.45, 0.5), atol=1e-3)
    engine.scene.remove("step")
    (gone,) = engine.rays(starts[:1], ends[:1])
    assert gone.fraction == pytest.approx(0.5, abs=1e-3)


def test_something_new_leaves_the_motion_of_the_rest_as_it_is(engine: Engine) -> None:
    engine.add_robot(BODY, ROTOR)
    engine.robot.set_torso(at(3.0))
    run(engine, 100)
    before = engine.robot.torso()
    engine.scene.add_box("new", (0.1, 0.1, 0.1), Pose((2.0, 0.0, 0.5), ORIGIN.orientation), mass=1.0)
    engine.scene.set_surface(replace(WOOD, friction=0.3))
    after = engine.robot.torso()
    assert (after.position, after.velocity) == (before.position, before.velocity)
    run(engine, 100)
    assert engine.robot.torso().velocity[2] == pytest.approx(-G * 0.2, abs=1e-3)


def test_reset_gives_the_same_bits_again(engine: Engine) -> None:
    ends = []
    for _ in range(2):
        engine.reset()
        engine.scene.set_surface(replace(WOOD, friction=0.7))
        engine.add_robot(BODY, ROTOR)
        engine.robot.set_torso(at(0.4))
        engine.begin_cycle()
        run(engine, 600)
        ends.append((engine.robot.position.tolist(), engine.robot.torso(), engine.contacts()))
    assert ends[0] == ends[1]
    assert sum(foot.force[2] for foot in ends[0][2].feet.values()) > 0.1 * MASS * G


def test_limbs_meet_each_other(engine: Engine) -> None:
    engine.add_robot(BODY, ROTOR, held=True)
    engine.robot.set_torso(at(1.0))
    assert engine.robot.overlap() == 0.0
    angles = dict.fromkeys(JOINTS, 0.0) | {"LHipRoll": -0.37, "RHipRoll": 0.37}
    engine.robot.set_joints(list(angles.values()))
    assert engine.robot.overlap() > 0.01


def test_a_picture_shows_the_robot(engine: Engine) -> None:
    if hasattr(engine, "simulation"):
        pytest.importorskip("mujoco.egl", exc_type=Exception)
    engine.add_robot(BODY, ROTOR, held=True)
    engine.robot.set_torso(at(1.0))
    front = PinholeCamera((1.5, 0.0, 1.0), (0.0, 0.0, 1.0), 64, 48, math.radians(40.0))
    away = PinholeCamera((1.5, 0.0, 1.0), (3.0, 0.0, 1.0), 64, 48, math.radians(40.0))
    with_robot, without = engine.picture(front), engine.picture(away)
    assert with_robot.shape == (48, 64, 3)
    assert np.abs(with_robot[24, 32].astype(int) - without[24, 32].astype(int)).max() > 20


def test_a_robot_on_a_hook_hangs_where_it_was_and_falls_when_it_is_let_go(engine: Engine) -> None:
    engine.add_robot(BODY, ROTOR)
    pose = Pose((0.1, 0.2, 1.5), quaternion(0.3, 0.2, -0.4))
    engine.robot.set_torso(pose)
    engine.robot.hold_torso(True)
    run(engine, 300)
    engine.scene.add_box("new", (0.1, 0.1, 0.1), Pose((2.0, 0.0, 0.05), ORIGIN.orientation))
    run(engine, 300)
    np.testing.assert_allclose(engine.robot.torso().position, pose.position, atol=3e-3)
    np.testing.assert_allclose(engine.robot.torso().orientation, pose.orientation, atol=5e-3)
    engine.robot.hold_torso(False)
    before = engine.robot.com()[2]
    run(engine, 100)
    assert before - engine.robot.com()[2] == pytest.approx(0.5 * G * 0.1**2, rel=0.1)


def test_the_places_of_fields_are_those_of_the_installed_version() -> None:
    engine = MujocoEngine(PhysicsSettings())
    engine.scene.set_surface(Surface(friction=1.0, stiffness_per_area=1e8, relaxation=0.01))
    body = load_body("nao-v6")
    engine.add_robot(body, np.full(len(joint_tree(body)), 0.01))
    engine.robot.set_torso(Pose((0.0, 0.0, 0.333)))
    engine.begin_cycle()
    for _ in range(20):
        engine.step(np.zeros(len(engine.robot.joints)))
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
