"""Physics steps of drives, stops, MuJoCo and contacts as machine code, without Python's lock."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emulator.compiled import compilable, compiled
from emulator.drives import run_drives, take_over
from emulator.engine.mujoco.contacts import add_contacts
from emulator.engine.mujoco.native import Layout, mj_step
from emulator.engine.stops import brake_joints

Vector = NDArray[np.float64]
Places = NDArray[np.int64]


@partial(compiled, nogil=True)
def run_steps(
    steps: int,
    change: int,
    drives: NDArray[Any],
    torque: Vector,
    model: int,
    data: int,
    layout: Layout,
    angles: Places,
    dofs: Places,
    qpos: Vector,
    qvel: Vector,
    force: Vector,
    pushes: Vector,
    stops: tuple[Vector, Vector, Vector, float],
    contacts: tuple[NDArray[Any], ...],
) -> tuple[Vector, Vector]:
    """Run steps.

    Args:
        steps: How many.
        change: Step, from 0, before which the drives take over their next request; -1: none.
        drives: Of `emulator.drives.DRIVE`, (n,); none of them: the torques are given.
        torque: Of the drives, (n,), N m; overwritten.
        model: Address of MuJoCo's model.
        data: Address of its state.
        layout: `native.LAYOUT`.
        angles: Places of the joints in `qpos`, (n,).
        dofs: Places of the joints in `qvel` and `force`, (n,).
        qpos: MuJoCo's positions.
        qvel: MuJoCo's velocities.
        force: MuJoCo's applied torques.
        pushes: MuJoCo's applied forces of bodies, (bodies, 6); they act in the first step.
        stops: `Stops.constants`.
        contacts: `MujocoContacts.arrays`, to which those of the steps are added.

    Returns:
        Positions and velocities of the joints after them, (n,), rad and rad/s.
    """
    position, velocity = np.empty(len(angles)), np.empty(len(angles))
    _read_joints(angles, dofs, qpos, qvel, position, velocity)
    for step in range(steps):
        if step == change:
            take_over(drives)
        if len(drives) > 0:
            run_drives(drives, position, velocity, torque)
        brake_joints(*stops, position, velocity, torque)
        for i in range(len(angles)):
            force[dofs[i]] = torque[i]
        mj_step(model, data)
        pushes.fill(0.0)
        add_contacts(data, layout, *contacts)
        _read_joints(angles, dofs, qpos, qvel, position, velocity)
    return position, velocity


@compilable
def _read_joints(
    angles: Places, dofs: Places, qpos: Vector, qvel: Vector, position: Vector, velocity: Vector
) -> None:
    for i in range(len(angles)):
        position[i], velocity[i] = qpos[angles[i]], qvel[dofs[i]]
