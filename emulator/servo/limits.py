"""Limits of requests: joint ranges, and the anti-collision tables of ankles and head."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.model import CouplingRow
from bridge.body.quantities import COUPLED_TO

Vector = NDArray[np.float64]


class _Coupling:
    """Range of one joint over the request of another: the table's rows, linear between them (assumed)."""

    def __init__(self, body: Body, joint: str, joints: Sequence[str]) -> None:
        self.joint, self.other = joints.index(joint), joints.index(COUPLED_TO[joint])
        rows: dict[float, CouplingRow] = {row.at: row for row in getattr(body.coupling, joint)}
        if joint == "HeadPitch":  # published for one side of a symmetric head
            rows |= {-at: row for at, row in rows.items()}
        self._places = sorted(rows)
        self._lower = [rows[at].lower for at in self._places]
        self._upper = [rows[at].upper for at in self._places]

    def clip(self, request: Vector) -> None:
        at = request[self.other]
        lower = np.interp(at, self._places, self._lower)
        upper = np.interp(at, self._places, self._upper)
        request[self.joint] = min(max(request[self.joint], lower), upper)


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
            _Coupling(body, joint, joints)
            for joint, other in COUPLED_TO.items()
            if joint in joints and other in joints
        ]

    def clip(self, request: Vector) -> Vector:
        """The nearest allowed request, rad."""
        allowed = np.clip(request, self._lower, self._upper)
        for coupling in self._couplings:
            coupling.clip(allowed)
        return allowed
