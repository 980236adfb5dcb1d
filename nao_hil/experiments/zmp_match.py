"""Agreement of the planned ZMP with the one of the contact forces and the one of the force sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.sole import sole_hull
from bridge.types import SIDES
from nao_hil.experiments.geometry import soles_in_world
from nao_hil.runs.track import Array, Track
from nao_hil.runs.walk import WalkOutcome

_NOTHING: Final = 2.0
"""N; a foot with less than this bears nothing."""


class ZmpMatch(msgspec.Struct, frozen=True, kw_only=True):
    """Planned against measured zero moment point, in the frame of the stance sole: medians over the runs."""

    rms_x: float
    """m; ground truth less plan, single supports."""
    rms_y: float
    delay: float
    """Time by which the truth follows the plan (largest correlation along y), s."""
    outside: float
    """Share of the time in single support for which the true point is not within the stance sole."""
    fsr_rms: float
    """From the stance foot's force sensors less the truth, while the other foot bears nothing, m."""


def in_stance_sole(track: Track, body: Body) -> tuple[Array, Array, Array]:
    """Planned and true ZMP in the frame of the stance sole in single support, y outwards.

    Args:
        track: Of the walk.
        body: Of the robot.

    Returns:
        Rows of the track, shape (n,); plan and truth, each (n, 2), m.
    """
    rows, plans, truths = [], [], []
    for side, phase in zip(SIDES, ("SSL", "SSR"), strict=True):
        of_side = np.flatnonzero(track.during(phase) & np.isfinite(track["zmp"][:, 0]))
        soles = soles_in_world(body, side, Track(track.rows[of_side]))
        off = track["zmp"][of_side] - soles[:, :2, 3]
        outward = np.array([1.0, 1.0 if side == "L" else -1.0])
        foot = track["plan_left" if side == "L" else "plan_right"][of_side, :2]
        rows.append(of_side)
        truths.append(np.einsum("nij,ni->nj", soles[:, :2, :2], off) * outward)
        plans.append((track["plan_zmp"][of_side] - foot) * outward)
    return np.concatenate(rows), np.concatenate(plans), np.concatenate(truths)


def zmp_match(results: Sequence[WalkOutcome], body: Body) -> ZmpMatch:
    """Planned against measured, medians over the runs, each until a second before its fall."""
    values = []
    for result in results:
        track = result.track if result.end.survived else result.track.until(result.end.time - 1.0)
        if track.during("SSL", "SSR").any():
            values.append(_match(track, body))
    middle = np.nanmedian(np.array(values), axis=0) if values else np.full(5, np.nan)
    return ZmpMatch(
        rms_x=float(middle[0]),
        rms_y=float(middle[1]),
        delay=float(middle[2]),
        outside=float(middle[3]),
        fsr_rms=float(middle[4]),
    )


def _match(track: Track, body: Body) -> tuple[float, float, float, float, float]:
    rows, plan, truth = in_stance_sole(track, body)
    apart = np.sqrt(np.mean((truth - plan) ** 2, axis=0))
    hull = sole_hull(body, "L")
    edges = np.roll(hull, -1, axis=0) - hull
    inside = np.ones(len(truth), dtype=bool)
    for corner, edge in zip(hull, edges, strict=True):
        inside &= edge[0] * (truth[:, 1] - corner[1]) - edge[1] * (truth[:, 0] - corner[0]) >= 0.0
    fsr = _from_sensors(track, body, rows) - truth
    return (
        float(apart[0]),
        float(apart[1]),
        _delay(track),
        float(1.0 - inside.mean()),
        float(np.sqrt(np.nanmean(np.sum(fsr**2, axis=1)))),
    )


def _from_sensors(track: Track, body: Body, rows: Array) -> Array:
    """Centre of pressure of the stance foot by its four cells, y outwards, shape (n, 2), m."""
    left = np.isin(rows, np.flatnonzero(track.during("SSL")))
    points = np.empty((len(rows), 2))
    for mask, columns, places, outward in (
        (left, slice(0, 4), body.fsr.L, 1.0),
        (~left, slice(4, 8), body.fsr.R, -1.0),
    ):
        forces = np.maximum(track["fsr"][rows[mask], columns], 0.0)
        total = forces.sum(axis=1)
        other = track["fsr"][rows[mask], 4:] if columns.start == 0 else track["fsr"][rows[mask], :4]
        total[other.sum(axis=1) > _NOTHING] = np.nan
        with np.errstate(invalid="ignore", divide="ignore"):
            points[mask] = forces @ np.array(places)[:, :2] / total[:, None] * (1.0, outward)
    return points


def _delay(track: Track) -> float:
    """Shift, s, at which the true ZMP's y, less the mass', goes best with the planned one's."""
    walking = track.during("DSL", "SSL", "DSR", "SSR")
    plan = (track["plan_zmp"] - track["plan_com"])[walking, 1]
    truth = (track["zmp"] - track["com"][:, :2])[walking, 1]
    truth = np.nan_to_num(truth - np.nanmean(truth))
    cycle = float(np.median(np.diff(track["time"])))
    shifts = range(0, 16)
    scores = [float(np.dot(plan[: len(plan) - s], truth[s:])) for s in shifts]
    return cycle * int(np.argmax(scores))
