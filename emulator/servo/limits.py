"""Limits of requests: joint ranges, and the anti-collision tables of ankles and head."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.model import CouplingRow
from bridge.body.quantities import COUPLED_TO
from emulator.compiled import compilable, compiled

Vector = NDArray[np.float64]


def _coupling(body: Body, joint: str) -> Vector:
    """Range of one joint over the request of another, rows of place, lower and upper, (3, rows), rad."""
    rows: dict[float, CouplingRow] = {row.at: row for row in getattr(body.coupling, joint)}
    if joint == "HeadPitch":  # published for one side of a symmetric head
        rows |= {-at: row for at, row in rows.items()}
    return np.array([[at, rows[at].lower, rows[at].upper] for at in sorted(rows)]).T.copy()


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
        coupled = [(a, b) for a, b in COUPLED_TO.items() if a in joints and b in joints]
        places = [(joints.index(a), joints.index(b)) for a, b in coupled]
        self._places = np.array(places, dtype=np.int64).reshape(-1, 2)
        tables = [_coupling(body, joint) for joint, _ in coupled]
        self._tables = np.concatenate([np.zeros((3, 0)), *tables], axis=1)
        """One after the other."""
        self._ends = np.cumsum([0, *(table.shape[1] for table in tables)])

    def clip(self, request: Vector) -> Vector:
        """The nearest allowed request, rad."""
        return _clip(request, self._lower, self._upper, self._places, self._tables, self._ends)


@compiled
def _clip(
    request: Vector,
    lower: Vector,
    upper: Vector,
    places: NDArray[np.int64],
    tables: Vector,
    ends: NDArray[np.int64],
) -> Vector:
    allowed: Vector = np.minimum(np.maximum(request, lower), upper)
    for i in range(len(places)):
        # clip the request of a joint by that of the other, linear between the table's rows (assumed)
        joint, other, table = places[i, 0], places[i, 1], tables[:, ends[i] : ends[i + 1]]
        at = allowed[other]
        low, high = _between(at, table[0], table[1]), _between(at, table[0], table[2])
        allowed[joint] = min(max(allowed[joint], low), high)
    return allowed


@compilable
def _between(at: float, places: Vector, values: Vector) -> float:
    """Linear between the rows of a table, its end values outside."""
    if at <= places[0]:
        return float(values[0])
    for i in range(1, len(places)):
        if at < places[i]:
            slope = (values[i] - values[i - 1]) / (places[i] - places[i - 1])
            return float(slope * (at - places[i - 1]) + values[i - 1])
    return float(values[-1])
