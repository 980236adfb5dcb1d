"""Limits of requests: joint ranges, and the anti-collision tables of ankles and head."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.model import CouplingRow
from bridge.body.quantities import COUPLED_TO
from emulator.compiled import compiled

Vector = NDArray[np.float64]


def _coupling(body: Body, joint: str) -> Vector:
    """Range of one joint over the request of another, rows of place, lower and upper, (3, rows), rad."""
    rows: dict[float, CouplingRow] = {row.at: row for row in getattr(body.coupling, joint)}
    if joint == "HeadPitch":  # published for one side of a symmetric head
        rows |= {-at: row for at, row in rows.items()}
    return np.array([[at, rows[at].lower, rows[at].upper] for at in sorted(rows)]).T.copy()


@compiled
def _couple(request: Vector, joint: int, other: int, table: Vector) -> None:
    """Clip the request of a joint by that of the other, linear between the table's rows (assumed)."""
    at = request[other]
    lower, upper = np.interp(at, table[0], table[1]), np.interp(at, table[0], table[2])
    request[joint] = min(max(request[joint], lower), upper)


class RequestLimits:
    """Clips requests as the robot's boards do.

    A coupled joint's range follows the *request* of the joint it is coupled to (assumed: the tables' page
    does not say whether request or measurement counts).

    Args:
        body: Data sheet.
        joints: Mechanical joints in the order of the requests.
    """

    def __init__(self, body: Body, joints: Sequence[str]) -> None:
        self._lower = np.array([body.joints[name].lower for name in joints])
        self._upper = np.array([body.joints[name].upper for name in joints])
        self._couplings = [
            (joints.index(joint), joints.index(other), _coupling(body, joint))
            for joint, other in COUPLED_TO.items()
            if joint in joints and other in joints
        ]

    def clip(self, request: Vector) -> Vector:
        """The nearest allowed request, rad."""
        allowed: Vector = np.minimum(np.maximum(request, self._lower), self._upper)
        for joint, other, table in self._couplings:
            _couple(allowed, joint, other, table)
        return allowed
