"""MuJoCo's structures as machine code sees them, beside what MuJoCo's own Python package reads in them."""

import numpy as np

from bridge.body import joint_tree, load_body
from emulator.engine.mujoco.engine import MujocoEngine
from emulator.engine.mujoco.native import structure
from emulator.engine.values import PhysicsSettings, Surface
from emulator.poses import Pose


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
