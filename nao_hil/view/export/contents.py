"""What an exported page holds: the shapes of the robot, and all moments as tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from bridge.rotations import matrix, rotation
from bridge.types import SIDES
from nao_hil.analysis.diagnosis import Balance
from nao_hil.analysis.diagnosis.symptoms import MEANING
from nao_hil.view.charts import CHARTS, PHASES
from nao_hil.view.export.packing import PackedTable, pack
from nao_hil.view.footprints import Footprints
from nao_hil.view.history import COLUMNS
from nao_hil.view.looks import ColouredMesh, Floats, link_parts, terrain_meshes
from nao_hil.view.recorded_run import RecordedRun
from nao_hil.view.scene.lines import quaternions
from nao_hil.view.scene.palette import BARS_OVER, GROUND, LOST, NEWTON, OBSTACLE, OVER, POINTS, PRINTS, SAFE
from nao_hil.view.support import soles_that_touch, tips
from walker.estimation.odometry import GroundPlane
from walker.model.floating_base import FloatingBase

RATE: Final = 33.0
"""Moments per second that are kept; the page interpolates between them."""
LENGTH: Final = 1e-4
"""Step of lengths, m."""
TURN: Final = 1.0 / 16384.0
"""Step of a quaternion's components."""
WORLD: Final = 0
"""Place of the world among the frames that things are drawn in; the links follow."""
_CORNERS: Final = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_BOX: Final = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ]
)


def packed_run(run: RecordedRun, title: str, subtitle: str) -> bytes:
    """A recorded run, packed.

    Args:
        run: The run.
        title: Its name.
        subtitle: Robot, gait, seed.
    """
    stride = max(1, round(1.0 / (RATE * run.body.cycle * run.stride)))
    shown = run.balances[::stride]
    kinematics = FloatingBase(run.body)
    parts = link_parts(run.body)
    links = [name for name in kinematics.links if name in parts]
    pieces = [(1 + i, part) for i, name in enumerate(links) for part in parts[name]]
    pieces += [(WORLD, part) for part in _surroundings(run)]
    floor = GroundPlane(*run.world.floor, 0.0) if run.world else GroundPlane()
    phases = list(PHASES)
    header = {
        "title": title,
        "subtitle": subtitle,
        "pieces": [
            {"link": link, "colour": part.colour, "vertices": len(part.vertices), "faces": len(part.faces)}
            for link, part in pieces
        ],
        "links": links,
        "floor": rotation(floor.roll, floor.pitch, 0.0)[:, 2].tolist(),
        "points": [
            {k: getattr(p, k) for k in ("name", "label", "colour", "radius", "meaning")} for p in POINTS
        ],
        "cells": _cells(run, links),
        "newton": NEWTON,
        "colours": {"safe": SAFE, "lost": LOST, **PRINTS},
        "charts": _charts(),
        "phases": [{"name": name, "colour": colour} for name, colour in PHASES.items()],
        "events": [{"time": s.time, "kind": s.kind, "text": s.text} for s in run.symptoms],
        "fall": _fall(run),
    }
    tables = {
        "vertices": PackedTable(np.vstack([part.vertices for _, part in pieces]), LENGTH),
        "faces": PackedTable(np.vstack([part.faces for _, part in pieces]), 1.0),
        "time": PackedTable([[b.moment.sensors.time] for b in shown], 1e-3),
        **_poses(shown, [kinematics.links.index(name) for name in links]),
        "points": PackedTable([_points(b, floor) for b in shown], LENGTH),
        "loads": PackedTable([b.moment.sensors.fsr for b in shown], 0.1),
        "support": PackedTable(_support(shown, kinematics, floor), LENGTH),
        "steps": PackedTable([[b.moment.walk.step if b.moment.walk else math.nan] for b in shown], 1.0),
        "footprints": PackedTable(_footprints(run.balances, kinematics, floor), LENGTH),
        **_curves(run, stride, phases),
    }
    return pack(header, tables)


def _surroundings(run: RecordedRun) -> list[ColouredMesh]:
    """Boxes, tiles and heights of the world."""
    if run.world is None:
        return []
    parts = []
    for thing in run.world.objects:
        turn = matrix(thing.orientation)
        parts.append(ColouredMesh(_CORNERS * thing.size @ turn.T + thing.position, _BOX, OBSTACLE))
    if run.world.terrain is not None:
        turn = rotation(*run.world.floor, 0.0)
        parts += [ColouredMesh(v @ turn.T, faces, GROUND) for v, faces in terrain_meshes(run.world.terrain)]
    return parts


def _poses(shown: Sequence[Balance], places: Sequence[int]) -> dict[str, PackedTable]:
    """Where the links are, and how they are turned: (w, x, y, z), without jumps of the sign."""
    frames = np.array([b.best.robot.frames[list(places)] for b in shown])
    n = len(frames)
    turns = quaternions(frames[:, :, :3, :3].reshape(-1, 3, 3)).reshape(n, -1, 4)
    flips = np.sign((turns[1:] * turns[:-1]).sum(axis=2))
    turns[1:] *= np.cumprod(np.where(flips == 0.0, 1.0, flips), axis=0)[:, :, None]
    return {
        "position": PackedTable(frames[:, :, :3, 3].reshape(n, -1), LENGTH),
        "attitude": PackedTable(turns.reshape(n, -1), TURN),
    }


def _points(balance: Balance, floor: GroundPlane) -> list[float]:
    """Places of `POINTS`, in their order."""
    best, com = balance.best, balance.best.robot.com
    flat = {
        "zmp_plan": balance.plan.zmp if balance.plan else None,
        "zmp_fsr": balance.felt,
        "zmp_true": balance.true.zmp if balance.true else None,
        "com_ground": (float(com[0]), float(com[1])),
        "capture": best.capture,
    }
    numbers: list[float] = []
    for point in POINTS:
        if point.name == "com":
            numbers += (float(c) for c in com)
        else:
            numbers += _on_floor(flat[point.name], floor)
    return numbers


def _on_floor(point: tuple[float, float] | None, floor: GroundPlane) -> tuple[float, float, float]:
    if point is None:
        return (math.nan,) * 3
    return (*point, floor.at(*point) + OVER)


def _support(shown: Sequence[Balance], kinematics: FloatingBase, floor: GroundPlane) -> Floats:
    """Whether it tips (1), then the corners of the support polygon, up to its last one."""
    rows = []
    for balance in shown:
        polygon = soles_that_touch(kinematics, balance.best)
        row = [math.nan] if polygon is None else [float(tips(balance.best, polygon))]
        for corner in polygon.corners if polygon is not None else ():
            row += _on_floor((float(corner[0]), float(corner[1])), floor)
        rows.append(row)
    return _padded(rows)


def _footprints(balances: Sequence[Balance], kinematics: FloatingBase, floor: GroundPlane) -> Floats:
    """Time, kind by its place in `PRINTS`, and corners."""
    rows, prints, kinds = [], Footprints(kinematics), list(PRINTS)
    for balance in balances:
        for kind, corners in prints.update(balance):
            row = [balance.moment.sensors.time, float(kinds.index(kind))]
            for x, y in corners:
                row += _on_floor((float(x), float(y)), floor)
            rows.append(row)
    return _padded(rows)


def _padded(rows: Sequence[Sequence[float]]) -> Floats:
    """Rows of one length, filled up with NaN."""
    width = max((len(row) for row in rows), default=1)
    return np.array([[*row, *[math.nan] * (width - len(row))] for row in rows]).reshape(-1, width)


def _cells(run: RecordedRun, links: Sequence[str]) -> list[dict[str, Any]]:
    """The force sensors: the link that each is in, its place there, m, and the end of its range, N."""
    fsr = run.body.fsr
    return [
        {"link": 1 + links.index(f"{s}AnkleRoll"), "at": [*at[:2], at[2] + BARS_OVER], "range": fsr.range}
        for s, places in zip(SIDES, (fsr.L, fsr.R), strict=True)
        for at in places
    ]


def _curves(run: RecordedRun, stride: int, phases: Sequence[str]) -> dict[str, PackedTable]:
    """Numbers of the charts and phases of the walk, at the moments shown."""
    last = run.balances[-1].moment.sensors.time
    rows, names = run.history.window(last, math.inf)
    thinned = run.stride * stride
    kept = [COLUMNS.index(line["column"]) for chart in _charts() for line in chart["lines"]]
    place = {name: float(i) for i, name in enumerate(phases)}
    return {
        "curves": PackedTable(rows[::thinned, kept], 0.01),
        "phase": PackedTable([[place.get(name, math.nan)] for name in names[::thinned]], 1.0),
    }


def _charts() -> list[dict[str, Any]]:
    """The charts; those of the wall clock are left out, which recordings do not have."""
    return [
        {
            "title": chart.title,
            "least": chart.least,
            "most": [bound if math.isfinite(bound) else None for bound in chart.most],
            "height": chart.height,
            "lines": [{"column": x.column, "name": x.name, "colour": x.colour} for x in chart.lines],
        }
        for chart in CHARTS
        if chart.lines[0].column != "late"
    ]


def _fall(run: RecordedRun) -> dict[str, Any] | None:
    """When it fell, and what went wrong first."""
    if run.diagnosis is None:
        return None
    first = run.diagnosis.first
    return {
        "time": run.diagnosis.fell,
        "first": first.time if first else run.diagnosis.fell,
        "text": first.text if first else "there was no sign before",
        "meaning": MEANING[first.kind] if first else "",
    }
