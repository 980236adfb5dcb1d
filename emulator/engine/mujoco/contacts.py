"""Contact forces on the robot from MuJoCo's contacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numba import carray
from numpy.typing import NDArray

from bridge.types import SIDES, Array
from emulator.compiled import compilable, compiled
from emulator.engine.contacts import RIM_COSINE, ground_contacts
from emulator.engine.mujoco.native import Layout, pointer
from emulator.engine.mujoco.robot import MujocoRobot
from emulator.engine.mujoco.scene import MujocoScene
from emulator.engine.mujoco.simulation import Simulation
from emulator.engine.shapes import FOOT_LINKS
from emulator.poses import matrix
from emulator.vectors import put

_LINK, _GROUND, _OTHER = -1, -2, -3
"""Owner of a geom; feet are counted from 0, two for each robot."""
_MAX_RIM_CONTACTS: Final = 64
"""Contacts on the rims of a robot's feet that one cycle keeps."""


class MujocoContacts:
    """Collects the contacts of robots step by step.

    Args:
        simulation: With the robots.
        robots: The robots.
        scene: Their surroundings.
    """

    def __init__(self, simulation: Simulation, robots: Sequence[MujocoRobot], scene: MujocoScene) -> None:
        self._simulation, self._robots, self._scene = simulation, robots, scene
        feet = 2 * len(robots)
        # as for `ground_contacts`: sums of the contacts, and of one contact with the force of all
        self._sums, self._whole = np.zeros((feet, 7)), np.zeros((feet, 7))
        self._frames, self._normals = np.zeros((feet, 12)), np.zeros((feet, 3))
        self._rim = np.zeros((_MAX_RIM_CONTACTS * len(robots), 4))
        self._counts = np.zeros(2, dtype=np.int64)
        self._version = -1

    def _find(self) -> None:
        if self._version == self._simulation.version:
            return
        model = self._simulation.model
        self._version = self._simulation.version
        for robot in self._robots:
            robot.find()
        links = {number: link for robot in self._robots for link, number in robot.bodies.items()}
        feet = [robot.bodies[FOOT_LINKS[side]] for robot in self._robots for side in SIDES]
        self._feet = np.array(feet, dtype=np.int64)
        kind = dict.fromkeys(links, _LINK) | {foot: i for i, foot in enumerate(feet)}
        kind[self._scene.ground] = _GROUND
        self._links = [links.get(body, "") for body in model.geom_bodyid.tolist()]
        self._kind = np.array([kind.get(body, _OTHER) for body in model.geom_bodyid.tolist()])
        self._touching = np.zeros(model.ngeom, dtype=np.bool_)
        self._positions, self._turns = self._simulation.data.xpos, self._simulation.data.xquat

    def arrays(self) -> tuple[NDArray[Any], ...]:
        """The last arguments of `add_contacts`, for the model as it is compiled now."""
        self._find()
        return self._kind, self._normals, self._sums, self._rim, self._counts, self._touching

    def begin(self) -> None:
        """Forget the last cycle; the soles' normals are those of now until `mean`."""
        self._simulation.bring_up_to_date()
        self._find()
        _begin(
            self._positions,
            self._turns,
            self._feet,
            self._frames,
            self._normals,
            self._sums,
            self._counts,
            self._touching,
        )

    def give(self, steps: int) -> None:
        """Give each robot the means over the steps since `begin`."""
        self._simulation.bring_up_to_date()
        self._find()
        _end(self._positions, self._turns, self._feet, self._frames, self._sums, self._normals, self._whole)
        rims, touches = self._counts.tolist()
        rim = [(int(foot), (x, y, z)) for foot, x, y, z in self._rim[:rims].tolist()] if rims else []
        touched = np.flatnonzero(self._touching).tolist() if touches else []
        for i, robot in enumerate(self._robots):
            feet = slice(2 * i, 2 * i + 2)
            own = [(foot - 2 * i, place) for foot, place in rim if foot // 2 == i]
            geoms = robot.geoms if touched else ()
            touching = frozenset(self._links[geom] for geom in touched if geom in geoms)
            robot.contacts = ground_contacts(
                self._whole[feet], own, self._frames[feet], max(steps, 1), self._scene.normal, touching
            )


@compiled
def _begin(
    positions: Array,
    turns: Array,
    feet: NDArray[np.int64],
    frames: Array,
    normals: Array,
    sums: Array,
    counts: NDArray[np.int64],
    touching: NDArray[np.bool_],
) -> None:
    _place_feet(positions, turns, feet, frames)
    for i in range(len(feet)):
        put(normals[i], (frames[i, 5], frames[i, 8], frames[i, 11]))
    sums.fill(0.0)
    counts.fill(0)
    touching.fill(False)


@compiled
def _end(
    positions: Array,
    turns: Array,
    feet: NDArray[np.int64],
    frames: Array,
    sums: Array,
    normals: Array,
    whole: Array,
) -> None:
    _place_feet(positions, turns, feet, frames)
    _unite(sums, normals, whole)


@compilable
def _place_feet(positions: Array, turns: Array, feet: NDArray[np.int64], frames: Array) -> None:
    """The feet's frames as for `ground_contacts`, written, of MuJoCo's positions and quaternions of bodies."""
    for i in range(len(feet)):
        w, x, y, z = turns[feet[i], 0], turns[feet[i], 1], turns[feet[i], 2], turns[feet[i], 3]
        rotation = matrix((x, y, z, w))
        for axis in range(3):
            frames[i, axis] = positions[feet[i], axis]
        for entry in range(9):
            frames[i, 3 + entry] = rotation[entry]


@compilable
def _unite(sums: Array, normals: Array, whole: Array) -> None:
    """Take the force of all contacts of a foot at their centre of pressure for one contact, written."""
    for i in range(len(sums)):
        weight = sums[i, 3]
        pressing = normals[i, 0] * sums[i, 0] + normals[i, 1] * sums[i, 1] + normals[i, 2] * sums[i, 2]
        whole[i].fill(0.0)
        if weight != 0.0:
            whole[i, 3] = pressing
            for axis in range(3):
                whole[i, axis] = sums[i, axis]
                whole[i, 4 + axis] = pressing * (sums[i, 4 + axis] / weight)


@compiled
def add_contacts(
    data: int,
    layout: Layout,
    kind: NDArray[np.int64],
    normals: Array,
    sums: Array,
    rim: Array,
    counts: NDArray[np.int64],
    touching: NDArray[np.bool_],
) -> None:
    """Take in the contacts of the physics step just done.

    Args:
        data: Address of MuJoCo's state.
        layout: `native.LAYOUT`.
        kind: Owner of each geom.
        normals: Of the soles, (feet, 3), world frame.
        sums: Over the contacts of each foot; changed.
        rim: Contacts on the rims of the feet; changed.
        counts: How many of these, and how often a link touched the ground; changed.
        touching: Geoms of the robot that touch the ground; changed.
    """
    count_at, contacts_at, forces_at, size, geom_at, place_at, frame_at, address_at = layout
    contact = carray(pointer(data + contacts_at), 1, np.int64)[0]
    forces_of = carray(pointer(data + forces_at), 1, np.int64)[0]
    for _ in range(carray(pointer(data + count_at), 1, np.int32)[0]):
        address = carray(pointer(contact + address_at), 1, np.int32)[0]
        geoms = carray(pointer(contact + geom_at), 2, np.int32)
        place = carray(pointer(contact + place_at), 3, np.float64)
        frame = carray(pointer(contact + frame_at), 9, np.float64)
        contact += size
        if address < 0:
            continue
        forces = carray(pointer(forces_of + 8 * address), 3, np.float64)
        # The frame's rows are the normal from the first geom to the second, and two tangents. The force in it,
        # normal and tangents, acts on the second geom, its opposite on the first.
        for which in range(2):
            geom, sign = geoms[which], 2.0 * which - 1.0
            own, other = kind[geom], kind[geoms[1 - which]]
            if own == _LINK and other == _GROUND:
                touching[geom] = True
                counts[1] += 1
            if own < 0:
                continue
            normal_force, weight, slope = forces[0], 0.0, 0.0
            for axis in range(3):
                part = normal_force * frame[axis]
                part += forces[1] * frame[3 + axis] + forces[2] * frame[6 + axis]
                sums[own, axis] += sign * part
                weight += sign * part * normals[own, axis]
                slope += frame[axis] * normals[own, axis]
            sums[own, 3] += weight
            for axis in range(3):
                sums[own, 4 + axis] += weight * place[axis]
            # A contact across the sole's normal pushes on the rim of the foot.
            if normal_force > 0.0 and abs(slope) < RIM_COSINE and counts[0] < len(rim):
                entry = rim[counts[0]]
                entry[0] = own
                for axis in range(3):
                    entry[1 + axis] = place[axis]
                counts[0] += 1
