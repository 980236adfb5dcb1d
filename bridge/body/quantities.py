"""Quantities computed from a data sheet: joint-side figures of the drives, ranges, mass, absent joints."""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import Final

import numpy as np

from bridge.body.joints import JOINTS
from bridge.body.model import Body, CouplingRow, Tensor
from bridge.types import Array

GRAVITY: Final = 9.81
"""m/s^2 (thesis 2.5)."""

HANDS: Final = ("LHand", "RHand")
"""Slots of the hands: opening fractions, no angles; never part of the tree of joints."""

HAND_RANGE: Final = (0.0, 1.0)
"""Closed and open hand (vendor's joint table)."""

COUPLED_TO: Final = {"LAnkleRoll": "LAnklePitch", "RAnkleRoll": "RAnklePitch", "HeadPitch": "HeadYaw"}
"""Joints whose range depends on another joint's position, and that joint."""


def total_mass(body: Body) -> float:
    """Mass of the whole robot, kg."""
    return math.fsum(link.mass for link in body.links.values())


def tensor_matrix(tensor: Tensor) -> Array:
    """Symmetric 3 x 3 matrix of the elements (ixx, iyy, izz, ixy, ixz, iyz), kg m^2."""
    ixx, iyy, izz, ixy, ixz, iyz = tensor
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])


def standing_height(body: Body) -> float:
    """Height of the Torso frame over the soles with the legs straight, m."""
    length = body.lengths
    return length.HipOffsetZ + length.ThighLength + length.TibiaLength + length.FootHeight


def absent_joints(body: Body) -> tuple[str, ...]:
    """Joints of the frames that this body lacks, in frame order: wrists and hands of an H21, none of an H25."""
    has_hands = body.model == "H25"
    return tuple(j for j in JOINTS if j not in body.joints and not (j in HANDS and has_hands))


def limits(body: Body, joint: str) -> tuple[float, float]:
    """Lower and upper end of a joint's range, rad (a hand's: 0 and 1).

    Raises:
        KeyError: the body has no such joint.
    """
    if joint in HANDS and joint not in absent_joints(body):
        return HAND_RANGE
    sheet = body.joints[joint]
    return sheet.lower, sheet.upper


class CoupledRange:
    """Range of a joint that depends on the position of another one (`COUPLED_TO`).

    The published anti-collision points, linear between them (assumed) and constant beyond them, cut to the
    joint's own range.

    Args:
        body: the data sheet.
        joint: one of `COUPLED_TO`.
    """

    def __init__(self, body: Body, joint: str) -> None:
        rows: dict[float, CouplingRow] = {row.at: row for row in getattr(body.coupling, joint)}
        if joint == "HeadPitch":  # published for one side of a symmetric head
            rows |= {-at: row for at, row in rows.items()}
        self._own = limits(body, joint)
        self.table: Final = tuple((at, rows[at].lower, rows[at].upper) for at in sorted(rows))
        """Place of the other joint, lower and upper end before the cut, rad."""
        self._at = [at for at, *_ in self.table]

    def at(self, other: float) -> tuple[float, float]:
        """Lower and upper end while the other joint is at a position, rad."""
        table = self.table
        other = min(max(other, table[0][0]), table[-1][0])
        i = bisect_left(self._at, other, lo=1, hi=len(table) - 1)
        (a, lower_a, upper_a), (b, lower_b, upper_b) = table[i - 1], table[i]
        share = (other - a) / (b - a)
        lower = (1.0 - share) * lower_a + share * lower_b
        upper = (1.0 - share) * upper_a + share * upper_b
        return max(self._own[0], lower), min(self._own[1], upper)


def coupled_limits(body: Body, joint: str, other_position: float) -> tuple[float, float]:
    """A joint's range while the joint it is coupled to is at `other_position`.

    Args:
        body: the data sheet.
        joint: any joint; one outside `COUPLED_TO` keeps its own range.
        other_position: rad, of joint `COUPLED_TO[joint]`.

    Raises:
        KeyError: the body has no such joint.
    """
    return CoupledRange(body, joint).at(other_position) if joint in COUPLED_TO else limits(body, joint)


def joint_no_load_speed(body: Body, joint: str) -> float:
    """Speed of a joint without load, rad/s: the motor's over the gear ratio."""
    sheet = body.joints[joint]
    return body.motors[sheet.motor].no_load_speed_rpm * 2.0 * math.pi / 60.0 / sheet.gear_ratio


def joint_stall_torque(body: Body, joint: str) -> float:
    """Torque of a joint at standstill, N m: the motor's times the gear ratio, without gear losses."""
    sheet = body.joints[joint]
    return body.motors[sheet.motor].stall_torque * sheet.gear_ratio


def joint_nominal_torque(body: Body, joint: str) -> float:
    """Torque of a joint at the motor's nominal point, N m, without gear losses."""
    sheet = body.joints[joint]
    return body.motors[sheet.motor].nominal_torque * sheet.gear_ratio
