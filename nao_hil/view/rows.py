"""A run as numbers that the page draws: a header, and one row of fixed width for some of its cycles.

Tables of numbers, rounded, and packed for a script to read.

Unpacked: the length of the header (uint32, little endian), the header (JSON, padded by spaces to a multiple of
4 bytes), then each table column by column as int32: the first number and the differences, modulo 2**32, of the
numbers divided by the table's step.
"""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from bridge.body import Body, joint_tree
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS
from bridge.body.kinematics import FloatingBase
from bridge.dcm.actuators import led_names
from bridge.messages import TruthFrame
from bridge.messages.frames import N_LEDS
from bridge.messages.game import GameState, Penalty
from bridge.messages.world_state import WorldObject, WorldReply
from bridge.polygon import SupportPolygon, convex_hull
from bridge.rotations import heading, rotation
from bridge.types import SIDES, Array
from emulator.shell import Colour, ColouredMesh, lamps, shell
from nao_hil.analysis.diagnosis import Balance, Diagnosis, Stand, Symptom
from nao_hil.analysis.diagnosis.symptoms import MEANING
from nao_hil.runs.run import TIME_TOLERANCE
from nao_hil.view.signals import CHARTS, PHASES, SIGNALS, signal_values
from nao_hil.view.surroundings import Footprints, terrain_meshes
from walker.estimation.odometry import GroundPlane

PLANNED: Final[Colour] = (51, 154, 240)
MEASURED: Final[Colour] = (255, 146, 43)
TRUE: Final[Colour] = (64, 192, 87)
CAPTURE: Final[Colour] = (204, 93, 232)
COM: Final[Colour] = (250, 82, 82)
SAFE: Final[Colour] = (32, 201, 151)
LOST: Final[Colour] = (250, 82, 82)
OBSTACLE: Final[Colour] = (212, 163, 92)
GOAL: Final[Colour] = (236, 238, 240)
GROUND: Final[Colour] = (104, 92, 72)
PRINTS: Final[dict[str, Colour]] = {"planned": PLANNED, "made": (173, 181, 189)}
"""Colours of the footprints."""
BAR_PER_NEWTON: Final = 0.006
"""Height of a load's bar, m/N: 150 mm for a full cell."""
BAR_BASE: Final = 0.02
"""Height over the sole at which the bars begin, m."""
MARK_HEIGHT: Final = 0.002
"""Height over the floor of marks on it, m."""
TIPPING_DISTANCE: Final = 0.03
"""A capture point this far outside the support polygon is marked, m."""
NAN_INTEGER: Final = -(2**31)
"""The integer for NaN."""
ROW_PERIOD: Final = 0.03
"""Robot time from one row to the next, s; the page interpolates between them."""
LENGTH_STEP: Final = 1e-4
"""Step to which lengths are rounded in a file, m."""
TURN_STEP: Final = 1.0 / 16384.0
"""Likewise of a quaternion's components."""
STATES: Final = get_args(GameState)
PENALTIES: Final = get_args(Penalty)
POSE_WIDTH: Final = 7 + len(JOINTS)
"""Numbers of the pose of another robot."""


class Point(NamedTuple):
    """A point of the balance: its name on the page, and its colour."""

    name: str
    label: str
    colour: Colour
    radius: float
    overlay: str
    """Switch of the page that shows it: `com`, `capture` or `zmp`."""


POINTS: Final = (
    Point("zmp_plan", "ZMP planned", PLANNED, 0.009, "zmp"),
    Point("zmp_fsr", "ZMP by the FSR", MEASURED, 0.009, "zmp"),
    Point("zmp_true", "ZMP true", TRUE, 0.009, "zmp"),
    Point("com", "centre of mass", COM, 0.014, "com"),
    Point("com_ground", "its projection", COM, 0.007, "com"),
    Point("capture", "capture point", CAPTURE, 0.010, "capture"),
)


def soles_that_touch(kinematics: FloatingBase, stand: Stand) -> SupportPolygon | None:
    """The hull of the soles that touch the ground, world frame; None in flight."""
    soles = [kinematics.sole_in_world(s, stand.robot.feet[s])[:, :2] for s in SIDES if stand.contacts.of(s)]
    return SupportPolygon(convex_hull(np.vstack(soles))) if soles else None


def tips(stand: Stand, polygon: SupportPolygon) -> bool:
    """Whether the robot is about to fall: its capture point is far outside, or nothing bears it."""
    return stand.zmp is None or polygon.margin(stand.capture) < -TIPPING_DISTANCE


class PackedTable(NamedTuple):
    """Rows of numbers."""

    values: ArrayLike
    """Shape (rows, columns); NaN: nothing."""
    step: float
    """To which they are rounded."""


def pack(header: Mapping[str, Any], tables: Mapping[str, PackedTable]) -> bytes:
    """Header and tables, compressed by gzip.

    Args:
        header: Data for JSON, to which the layout is added as `tables`.
        tables: By their names.
    """
    layout, columns = [], []
    for name, table in tables.items():
        values = np.asarray(table.values, dtype=np.float64)
        layout.append({"name": name, "rows": len(values), "columns": values.shape[1], "step": table.step})
        rounded = np.where(np.isnan(values), NAN_INTEGER, np.round(np.nan_to_num(values) / table.step))
        columns.append(np.diff(rounded.astype(np.int64), axis=0, prepend=0).T.astype("<i4").tobytes())
    text = json.dumps({**header, "tables": layout}).encode()
    text += b" " * (-len(text) % 4)
    return gzip.compress(np.array(len(text), dtype="<u4").tobytes() + text + b"".join(columns), mtime=0)


class _DrawnBody:
    """Shapes and joints of a body, as the page draws it."""

    def __init__(self, body: Body) -> None:
        self.parts = shell(body)
        links = FloatingBase(body).links
        self.links = [name for name in links if name in self.parts]
        tree = joint_tree(body)
        self.chain = [
            {
                "link": name,
                "parent": tree[name].parent,
                "offset": tree[name].offset,
                "axis": tree[name].axis,
                "joint": JOINTS[INDEX_WITH_MIRROR[name]],
                "index": INDEX_WITH_MIRROR[name],
            }
            for name in links[1:]
        ]
        """Joints from the Torso outward, each by its place in `JOINTS`: the page places the links by angles."""


def pose_values(truth: TruthFrame | None) -> Array:
    """Place (m), attitude (w, x, y, z) and joint angles (rad) of a robot, shape (32,); NaN: not known."""
    if truth is None:
        return np.full(POSE_WIDTH, math.nan)
    x, y, z, w = truth.torso_orientation
    return np.array([*truth.torso_position, w, x, y, z, *truth.joints])


class RunRows:
    """Turns the cycles of one robot into rows.

    Args:
        body: Its data sheet.
        world: Its surroundings.
        others: Data sheets of the other robots of its world, by name.
    """

    def __init__(
        self, body: Body, world: WorldReply | None = None, others: Mapping[str, Body] | None = None
    ) -> None:
        self.body, self.world, self.others = body, world, dict(others or {})
        bodies = {each.name: each for each in (*self.others.values(), body)}
        self._drawn = {name: _DrawnBody(bodies[name]) for name in dict.fromkeys((body.name, *bodies))}
        self._kinematics = FloatingBase(body)
        self.links = self._drawn[body.name].links
        self._lamps = lamps(body)
        self._lit = np.array([_share(lamp) for lamp in self._lamps]).reshape(-1, N_LEDS)
        self._places = [self._kinematics.links.index(name) for name in self.links]
        corners = 3 * sum(len(sole) for sole in self._kinematics.soles.values())
        n = len(self.links)
        self.fields: dict[str, tuple[int, float]] = {
            "time": (1, 1e-3),
            "position": (3 * n, LENGTH_STEP),
            "attitude": (4 * n, TURN_STEP),
            "heading": (1, TURN_STEP),
            "points": (3 * len(POINTS), LENGTH_STEP),
            "loads": (8, 0.1),
            "tips": (1, 1.0),
            "support": (corners, LENGTH_STEP),
            "step": (1, 1.0),
            "phase": (1, 1.0),
            "lights": (3 * len(self._lamps), 1.0),
            "others": (POSE_WIDTH * len(self.others), LENGTH_STEP),
            "game": (5 + len(self.others), 1.0),
            "signals": (len(SIGNALS), 0.01),
        }
        """Columns of a row: name -> width, and step to which a file rounds."""
        self.width = sum(width for width, _ in self.fields.values())
        self._turns = np.zeros((n, 4))
        self._phases = {name: float(i) for i, name in enumerate(PHASES)}
        self._footprints = Footprints(self._kinematics)
        self._last = -math.inf

    @property
    def floor(self) -> GroundPlane:
        """The floor that marks are drawn on."""
        return GroundPlane(*self.world.floor, 0.0) if self.world else GroundPlane()

    def due(self, time: float) -> bool:
        """Whether a cycle of this robot time, s, gets a row; an earlier one than the last does."""
        if self._last <= time < self._last + ROW_PERIOD - TIME_TOLERANCE:
            return False
        self._last = time
        return True

    def row(
        self, balance: Balance, late: float = math.nan, others: Mapping[str, TruthFrame | None] | None = None
    ) -> Array:
        """One row.

        Args:
            balance: Of the robot.
            late: As of `signal_values`.
            others: Truth of the other robots, by name.

        Returns:
            Shape (width,).
        """
        frame, walk = balance.cycle.sensors, balance.cycle.walk
        frames = balance.best.robot.frames
        turns = Rotation.from_matrix(frames[self._places, :3, :3]).as_quat()[:, [3, 0, 1, 2]]
        turns[(turns * self._turns).sum(axis=1) < 0.0] *= -1.0
        self._turns = turns
        polygon, width = soles_that_touch(self._kinematics, balance.best), self.fields["support"][0]
        corners = np.full(width, math.nan)
        if polygon is not None:
            flat = np.array([self._on_floor((float(x), float(y))) for x, y in polygon.corners]).ravel()
            corners[: len(flat)] = flat
        return np.concatenate(
            [
                [frame.time],
                frames[self._places, :3, 3].ravel(),
                turns.ravel(),
                [heading(frames[0])],
                self._points(balance),
                frame.fsr,
                [math.nan if polygon is None else float(tips(balance.best, polygon))],
                corners,
                [walk.step if walk else math.nan, self._phases.get(walk.phase, math.nan) if walk else math.nan],
                self._lights(balance.cycle.truth),
                *(pose_values((others or {}).get(name)) for name in self.others),
                self._game(balance.cycle.truth, others or {}),
                signal_values(balance, late),
            ]
        )

    def prints(self, balance: Balance) -> list[list[float]]:
        """Footprints that a cycle adds: time, kind by its place in `PRINTS`, corners on the floor, m."""
        kinds = list(PRINTS)
        return [
            [
                balance.cycle.sensors.time,
                float(kinds.index(kind)),
                *(c for x, y in corners for c in self._on_floor((float(x), float(y)))),
            ]
            for kind, corners in self._footprints.update(balance)
        ]

    def _lights(self, truth: TruthFrame | None) -> Array:
        """Red, green and blue of each lamp, 0 to 255: the mean of its LEDs."""
        leds = truth.leds if truth is not None else ()
        lights: Array = self._lit @ np.array(leds) if leds else np.zeros(len(self._lit))
        return lights

    def _game(self, truth: TruthFrame | None, others: Mapping[str, TruthFrame | None]) -> list[float]:
        """State, both scores, seconds left and penalties, the other robots' last; NaN: no game."""
        if truth is None or not truth.game.state:
            return [math.nan] * self.fields["game"][0]
        game, found = truth.game, [truth, *map(others.get, self.others)]
        penalties = [math.nan if one is None else float(PENALTIES.index(one.game.penalty)) for one in found]
        return [float(STATES.index(game.state)), *map(float, game.score), game.seconds_remaining, *penalties]

    def _points(self, balance: Balance) -> list[float]:
        """Places of `POINTS`, in their order."""
        best, com = balance.best, balance.best.robot.com
        flat = {
            "zmp_plan": balance.plan.zmp if balance.plan else None,
            "zmp_fsr": balance.felt,
            "zmp_true": balance.true.zmp if balance.true else None,
            "com_ground": (float(com[0]), float(com[1])),
            "capture": best.capture,
        }
        return [c for p in POINTS for c in (com if p.name == "com" else self._on_floor(flat[p.name]))]

    def _on_floor(self, point: tuple[float, float] | None) -> tuple[float, float, float]:
        if point is None:
            return (math.nan,) * 3
        return (*point, self.floor.at(*point) + MARK_HEIGHT)

    def pack(
        self,
        rows: Array,
        prints: Sequence[Sequence[float]],
        objects: Sequence[Sequence[WorldObject]] = (),
        **header: Any,
    ) -> bytes:
        """The run, packed.

        Args:
            rows: Shape (n, width).
            prints: As `prints` gives them.
            objects: Those of the ground truth at each row; none: all stay where the world has them.
            header: Added to the header: title, subtitle, `events_json` and the like.
        """
        moving = {thing.name: thing for row in reversed(objects) for thing in row}
        place = {name: i for i, name in enumerate(moving)}
        poses = np.full((len(rows), len(moving), 7), math.nan)
        for i, row in enumerate(objects):
            for thing in row:
                poses[i, place[thing.name]] = (*thing.position, *_attitude(thing))
        pieces = [
            (k, 1 + i, part)
            for k, drawn in enumerate(self._drawn.values())
            for i, name in enumerate(drawn.links)
            for part in drawn.parts[name]
        ]
        pieces += [(0, 0, part) for part in self._terrain()]
        fields = self.fields | {"objects": (7 * len(moving), LENGTH_STEP)}
        columns = np.split(rows, np.cumsum([width for width, _ in self.fields.values()])[:-1], axis=1)
        columns.append(poses.reshape(len(rows), 7 * len(moving)))
        tables = {
            "vertices": PackedTable(np.vstack([part.vertices for *_, part in pieces]), LENGTH_STEP),
            "faces": PackedTable(np.vstack([part.faces for *_, part in pieces]), 1.0),
            "footprints": PackedTable(_padded(prints), LENGTH_STEP),
            **{
                name: PackedTable(values, step)
                for (name, (_, step)), values in zip(fields.items(), columns, strict=True)
            },
        }
        widths = {"fields": [[name, width] for name, (width, _) in fields.items()]}
        return pack({**self._header(pieces), **world_json(self.world, moving), **widths, **header}, tables)

    def _header(self, pieces: Sequence[tuple[int, int, ColouredMesh]]) -> dict[str, Any]:
        bodies = list(self._drawn)
        return {
            "body": self.body.name,
            "pieces": [
                {
                    "body": body,
                    "link": link,
                    "colour": part.colour,
                    "vertices": len(part.vertices),
                    "faces": len(part.faces),
                }
                for body, link, part in pieces
            ],
            "bodies": [{"links": drawn.links, "chain": drawn.chain} for drawn in self._drawn.values()],
            "others": [{"name": name, "body": bodies.index(b.name)} for name, b in self.others.items()],
            "points": [p._asdict() for p in POINTS],
            "cells": self._cells(),
            "lamps": [
                {"link": 1 + self.links.index(link), "at": at, "radius": radius}
                for link, at, radius in self._lamps.values()
            ],
            "newton": BAR_PER_NEWTON,
            "colours": {"safe": SAFE, "lost": LOST, **PRINTS},
            "field": field_json(self.world),
            "prints": list(PRINTS),
            "charts": [chart.to_json() for chart in CHARTS],
            "signals": list(SIGNALS.items()),
            "joints": [[j, *np.degrees([s.lower, s.upper])] for j in JOINTS if (s := self.body.joints.get(j))],
            "game": {"states": STATES, "penalties": PENALTIES},
            "phases": [{"name": name, "colour": colour} for name, colour in PHASES.items()],
        }

    def _terrain(self) -> list[ColouredMesh]:
        """Tiles and heights of the ground."""
        if self.world is None or self.world.terrain is None:
            return []
        turn = rotation(*self.world.floor, 0.0)
        return [ColouredMesh(v @ turn.T, faces, GROUND) for v, faces in terrain_meshes(self.world.terrain)]

    def _cells(self) -> list[dict[str, Any]]:
        """The force sensors: the link that each is in, its place there, m, and the end of its range, N."""
        fsr = self.body.fsr
        return [
            {
                "link": 1 + self.links.index(f"{s}AnkleRoll"),
                "at": [*at[:2], at[2] + BAR_BASE],
                "range": fsr.range,
            }
            for s, places in zip(SIDES, (fsr.L, fsr.R), strict=True)
            for at in places
        ]


def world_json(world: WorldReply | None, moving: Mapping[str, WorldObject] | None = None) -> dict[str, Any]:
    """Floor (its upward normal) and objects; `moving`: those with a pose in each row, in that order."""
    floor = world.floor if world else (0.0, 0.0)
    field = world.terrain.field if world and world.terrain else None
    goals, moving = field.goals if field else (), moving or {}
    objects = [*moving.values(), *(o for o in (world.objects if world else ()) if o.name not in moving)]
    return {
        "floor": rotation(*floor, 0.0)[:, 2].tolist(),
        "objects": [
            {
                "name": o.name,
                "shape": o.shape,
                "size": o.size,
                "position": o.position,
                "attitude": _attitude(o),
                "colour": GOAL if o.name in goals else OBSTACLE,
                "moves": o.name in moving,
            }
            for o in objects
        ],
    }


def _attitude(thing: WorldObject) -> list[float]:
    """Quaternion w, x, y, z of an object."""
    return [thing.orientation[3], *thing.orientation[:3]]


def field_json(world: WorldReply | None) -> dict[str, Any] | None:
    """Size of a field's carpet, and begin, end and width of its lines, floor frame, m; None: no field."""
    field = world.terrain.field if world and world.terrain else None
    if field is None:
        return None
    return {"size": field.size, "stripes": [(*line.begin, *line.end, line.width) for line in field.stripes]}


def events_json(
    symptoms: Sequence[Symptom], diagnosis: Diagnosis | None, stood: float = math.inf
) -> dict[str, Any]:
    """Events, and the fall with its first symptom; `stood`: robot time at which the robot is up again, s."""
    fall = None
    if diagnosis is not None:
        reasons = [s for s in (diagnosis.before, diagnosis.first) if s is not None]
        fall = {
            "time": diagnosis.fell,
            "until": stood if math.isfinite(stood) else None,
            "first": reasons[0].time if reasons else diagnosis.fell,
            "text": ", then ".join(s.text for s in reasons) or "there was no sign before",
            "meaning": " ".join(MEANING[s.kind] for s in reasons if s.kind in MEANING)
            + (" The torso control was off." if diagnosis.torso_off else ""),
        }
    return {"events": [{"time": s.time, "kind": s.kind, "text": s.text} for s in symptoms], "fall": fall}


def _share(lamp: str) -> list[list[float]]:
    """Share of each LED in red, green and blue of a lamp; those of ears and head are blue."""
    place, _, side = lamp.rpartition("Led/")
    found = [name if name.startswith(place) and side in name else "" for name in led_names()]
    of = [name if "/Red" in name or "/Green" in name else name and "/Blue" for name in found]
    rows = [[float(f"/{colour}" in name) for name in of] for colour in ("Red", "Green", "Blue")]
    return [[share / max(1.0, sum(row)) for share in row] for row in rows]


def _padded(rows: Sequence[Sequence[float]]) -> Array:
    """Rows of one length, filled up with NaN."""
    width = max((len(row) for row in rows), default=1)
    table: Array = np.array([[*row, *[math.nan] * (width - len(row))] for row in rows]).reshape(-1, width)
    return table
