"""Shell of a NAO: closed smooth surfaces, lofted from the data sheet's dimensions.

An own design, for pictures only: contacts use the shapes of `emulator.engine.shapes`.
Lengths of limbs, places of joints and the sole's outline are the published ones; the cross-sections between
them are drawn to suit them. Page, cameras and exported models show the same shell.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from bridge.body import TORSO, Body
from bridge.body.sole import sole_hull
from bridge.types import SIDES, Array, Side

Colour = tuple[int, int, int]

WHITE: Final[Colour] = (238, 240, 243)
GREY: Final[Colour] = (108, 114, 124)
DARK: Final[Colour] = (43, 46, 53)
ACCENT: Final[Colour] = (38, 104, 196)
LIGHT: Final[Colour] = (96, 205, 250)
_SOLE: Final = 0.012
"""Thickness of the sole's plate, m."""
_FINE, _MEDIUM, _COARSE = (26, 16), (18, 10), (12, 7)
"""Points around a cross-section, and cross-sections, of large, medium and small parts."""


class ColouredMesh(NamedTuple):
    """One coloured piece of a link, in the link's frame."""

    vertices: Array
    """(n, 3), m."""
    faces: NDArray[np.int64]
    """(m, 3), outward."""
    colour: Colour


class Section(NamedTuple):
    """Cross-section of a loft: a superellipse."""

    at: float
    """Place along the loft's axis, m."""
    half: tuple[float, float]
    """Half axes along the two other axes, in the order x, y, z, m."""
    centre: tuple[float, float] = (0.0, 0.0)
    """Along the two other axes, m."""


def loft(
    axis: int,
    sections: Sequence[Section],
    colour: Colour,
    caps: tuple[float, float] = (0.012, 0.012),
    squareness: float = 2.4,
    detail: tuple[int, int] = _FINE,
) -> ColouredMesh:
    """A closed surface through cross-sections, interpolated without overshoot, its ends rounded.

    Args:
        axis: 0, 1 or 2: x, y or z.
        sections: At least two, along the axis.
        colour: Of the piece.
        caps: Lengths over which the first and the last end are rounded, m.
        squareness: Exponent of the superellipse; 2: an ellipse.
        detail: Points around a cross-section, and number of cross-sections.
    """
    around, rings = detail
    table = np.array([(s.at, *s.half, *s.centre) for s in sections])
    first, last = table[0, 0], table[-1, 0]
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, rings + 2)[1:-1])  # dense at the ends
    at = first + share * (last - first)
    half_u, half_v, u, v = PchipInterpolator(table[:, 0], table[:, 1:])(at).T
    shrink = np.ones(rings)
    for cap, distance in zip(caps, (at - first, last - at), strict=True):
        inside = 1.0 - np.clip(distance / max(cap, 1e-9), 0.0, 1.0)
        shrink *= np.sqrt(1.0 - inside * inside)
    angle = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    circle = [np.sign(c) * np.abs(c) ** (2.0 / squareness) for c in (np.cos(angle), np.sin(angle))]
    grid = np.empty((rings, around, 3))
    others = [k for k in range(3) if k != axis]
    grid[:, :, axis] = at[:, None]
    grid[:, :, others[0]] = u[:, None] + (half_u * shrink)[:, None] * circle[0]
    grid[:, :, others[1]] = v[:, None] + (half_v * shrink)[:, None] * circle[1]
    ends = np.zeros((2, 3))
    ends[:, axis] = first, last
    ends[:, others] = table[[0, -1], 3:]
    return _closed(grid, ends, colour, flipped=axis == 1)


def _closed(grid: Array, ends: Array, colour: Colour, *, flipped: bool = False) -> ColouredMesh:
    """The surface over rings of points (rings, around, 3), closed by a point at each end (2, 3)."""
    rings, around, _ = grid.shape
    i = np.arange(around)
    j = (i + 1) % around
    faces = [np.column_stack([np.full(around, rings * around), j, i])]
    for ring in range(rings - 1):
        a, b = ring * around, (ring + 1) * around
        faces += [np.column_stack([a + i, a + j, b + j]), np.column_stack([a + i, b + j, b + i])]
    top = (rings - 1) * around
    faces.append(np.column_stack([top + i, top + j, np.full(around, rings * around + 1)]))
    triangles = np.vstack(faces)
    return ColouredMesh(
        np.vstack([grid.reshape(-1, 3), ends]), triangles[:, ::-1] if flipped else triangles, colour
    )


def _knob(
    axis: int, at: tuple[float, float, float], radius: float, half: float, colour: Colour, bulge: float = 0.4
) -> ColouredMesh:
    """A round disc or ball about a point: eyes, ears, buttons, joints."""
    u, v = (at[k] for k in range(3) if k != axis)
    middle = at[axis]
    ends = [Section(middle + s * half, (radius, radius), (u, v)) for s in (-1.0, 1.0)]
    cap = bulge * 2.0 * half
    return loft(axis, ends, colour, (cap, cap), 2.0, _COARSE if radius < 0.02 else _MEDIUM)


def _ball(at: tuple[float, float, float], radius: float, colour: Colour) -> ColouredMesh:
    return _knob(2, at, radius, radius, colour, 0.5)


def _trunk(body: Body) -> list[ColouredMesh]:
    d, size = body.lengths, body.shapes
    width, depth, top = 0.5 * size.torso_width, 0.5 * size.torso_depth, d.ShoulderOffsetZ
    chest = [
        Section(-0.052, (0.80 * depth, 0.62 * width), (0.000, 0.0)),
        Section(-0.010, (0.98 * depth, 0.80 * width), (0.003, 0.0)),
        Section(0.45 * top, (1.18 * depth, 1.06 * width), (0.006, 0.0)),
        Section(0.80 * top, (1.12 * depth, 1.20 * width), (0.002, 0.0)),
        Section(top + 0.018, (0.82 * depth, 1.02 * width), (-0.002, 0.0)),
    ]
    hip = d.HipOffsetZ
    pelvis = [
        Section(-hip - 0.018, (0.66 * depth, 0.85 * width)),
        Section(-hip + 0.012, (0.86 * depth, 1.02 * width)),
        Section(-0.035, (0.76 * depth, 0.60 * width)),
    ]
    collar = [Section(top + 0.006, (0.034, 0.036)), Section(top + 0.028, (0.024, 0.026))]
    back = [
        Section(-0.02, (0.014, 0.026), (-1.02 * depth, 0.0)),
        Section(0.07, (0.014, 0.034), (-1.12 * depth, 0.0)),
    ]
    front = 1.22 * depth + 0.004
    return [
        loft(2, chest, WHITE, (0.022, 0.026), 2.7),
        loft(2, pelvis, GREY, (0.022, 0.014), 2.5),
        loft(2, collar, DARK, (0.004, 0.008), 2.0, _MEDIUM),
        loft(2, back, ACCENT, (0.02, 0.02), 2.6, _MEDIUM),
        _knob(0, (front, 0.0, 0.05), 0.0145, 0.006, ACCENT),
        _knob(0, (front + 0.003, 0.0, 0.05), 0.0095, 0.006, LIGHT),
    ]


def _head(body: Body) -> list[ColouredMesh]:
    r, height = body.shapes.head_radius, body.shapes.head_height
    skull = [
        Section(height - 1.02 * r, (0.52 * r, 0.56 * r), (0.004, 0.0)),
        Section(height - 0.55 * r, (0.90 * r, 0.92 * r), (0.005, 0.0)),
        Section(height, (1.02 * r, 1.08 * r), (0.003, 0.0)),
        Section(height + 0.55 * r, (0.86 * r, 0.92 * r), (-0.002, 0.0)),
        Section(height + 0.98 * r, (0.48 * r, 0.54 * r), (-0.004, 0.0)),
    ]
    parts = [loft(2, skull, WHITE, (0.016, 0.022), 2.25)]
    for s in (1.0, -1.0):
        ear, eye = s * 1.06 * r, s * 0.42 * r
        parts += [
            _knob(1, (-0.004, ear, height + 0.004), 0.46 * r, 0.008, GREY),
            _knob(1, (-0.004, ear + s * 0.004, height + 0.004), 0.27 * r, 0.008, ACCENT),
            _knob(0, (0.895 * r, eye, height + 0.006), 0.235 * r, 0.008, DARK),
            _knob(0, (0.935 * r, eye, height + 0.006), 0.155 * r, 0.008, LIGHT),
        ]
    parts += [
        _knob(0, (0.86 * r, 0.0, height + 0.52 * r), 0.1 * r, 0.008, DARK),  # camera over the eyes
        _knob(0, (0.985 * r, 0.0, height - 0.36 * r), 0.1 * r, 0.007, DARK),  # and under them
    ]
    touch = [
        Section(0.62 * r * x - 0.004, (0.24 * r, 0.2 * r), (0.0, height + z * r))
        for x, z in ((-1.0, 0.70), (-0.45, 0.87), (0.0, 0.905), (0.45, 0.86), (1.0, 0.66))
    ]
    return [*parts, loft(0, touch, GREY, (0.008, 0.008), 2.6, _MEDIUM)]


def lamps(body: Body) -> dict[str, tuple[str, tuple[float, float, float], float]]:
    """Places of groups of LEDs: beginning of their names -> link, place there (m), radius (m)."""
    r, height = body.shapes.head_radius, body.shapes.head_height
    front = 1.22 * 0.5 * body.shapes.torso_depth + 0.004
    places: dict[str, tuple[str, tuple[float, float, float], float]] = {
        "ChestBoard/Led/": ("Torso", (front + 0.008, 0.0, 0.05), 0.011),
        "Head/Led/": ("HeadPitch", (0.0, 0.0, height + 0.93 * r), 0.2 * r),
    }
    for side, name, s in (("L", "Left", 1.0), ("R", "Right", -1.0)):
        places |= {
            f"Face/Led/{name}": ("HeadPitch", (0.96 * r, s * 0.42 * r, height + 0.006), 0.17 * r),
            f"Ears/Led/{name}": ("HeadPitch", (-0.004, s * 1.12 * r, height + 0.004), 0.28 * r),
            f"{side}Foot/Led/": (f"{side}AnkleRoll", (0.075, 0.0, -0.015), 0.01),
        }
    return places


def _hand(side: float, start: float) -> list[ColouredMesh]:
    """Palm, three fingers and the thumb, from the wrist at x = `start`, m."""
    palm = [
        Section(start - 0.004, (0.018, 0.018)),
        Section(start + 0.026, (0.024, 0.017), (0.0, -0.004)),
        Section(start + 0.052, (0.021, 0.013), (0.0, -0.008)),
    ]
    parts = [loft(0, palm, GREY, (0.006, 0.01), 2.5, _MEDIUM)]
    for y in (-0.0145, 0.0, 0.0145):
        finger = [
            Section(start + 0.042, (0.0062, 0.0078), (y, -0.007)),
            Section(start + 0.066, (0.0060, 0.0074), (y, -0.013)),
            Section(start + 0.084, (0.0050, 0.0062), (0.9 * y, -0.021)),
        ]
        parts.append(loft(0, finger, WHITE, (0.006, 0.006), 2.2, _COARSE))
    thumb = [
        Section(start + 0.018, (0.0062, 0.0062), (-side * 0.022, -0.008)),
        Section(start + 0.050, (0.0052, 0.0056), (-side * 0.026, -0.020)),
    ]
    return [*parts, loft(0, thumb, WHITE, (0.006, 0.006), 2.2, _COARSE)]


def _arm(body: Body, side: Side) -> dict[str, list[ColouredMesh]]:
    d, size, s = body.lengths, body.shapes, 1.0 if side == "L" else -1.0
    upper, lower, elbow = d.UpperArmLength, d.LowerArmLength, s * d.ElbowOffsetY
    r, q = size.upper_arm_radius, size.forearm_radius
    arm = [
        Section(-0.95 * r, (0.80 * r, 0.86 * r)),
        Section(0.25 * upper, (1.0 * r, 1.0 * r), (0.15 * elbow, 0.0)),
        Section(0.70 * upper, (0.92 * r, 0.90 * r), (0.5 * elbow, 0.0)),
        Section(upper + 0.004, (0.74 * r, 0.76 * r), (0.6 * elbow, 0.0)),
    ]
    forearm = [
        Section(-0.010, (0.86 * q, 0.86 * q)),
        Section(0.35 * lower, (1.10 * q, 1.06 * q)),
        Section(lower - 0.002, (0.88 * q, 0.88 * q)),
    ]
    cuff = [Section(0.70 * lower, (1.01 * q, 0.99 * q)), Section(0.92 * lower, (0.96 * q, 0.95 * q))]
    parts = {
        f"{side}ShoulderPitch": [_ball((0.0, -s * 0.010, 0.0), 0.84 * r, GREY)],
        f"{side}ShoulderRoll": [
            loft(0, arm, WHITE, (0.016, 0.010), 2.3),
            _knob(1, (0.0, s * 0.88 * r, 0.0), 0.52 * r, 0.006, ACCENT),
        ],
        f"{side}ElbowYaw": [_ball((0.0, 0.0, 0.0), 0.86 * q, GREY)],
        f"{side}ElbowRoll": [
            loft(0, forearm, WHITE, (0.010, 0.008), 2.3, _MEDIUM),
            loft(0, cuff, ACCENT, (0.002, 0.002), 2.3, _MEDIUM),
        ],
    }
    if f"{side}WristYaw" in body.links:
        parts[f"{side}WristYaw"] = _hand(s, 0.0)
    else:
        parts[f"{side}ElbowRoll"] += _hand(s, lower)
    return parts


def _leg(body: Body, side: Side) -> dict[str, list[ColouredMesh]]:
    d, size, s = body.lengths, body.shapes, 1.0 if side == "L" else -1.0
    thigh, shank, r, q = d.ThighLength, d.TibiaLength, size.thigh_radius, size.shank_radius
    upper = [
        Section(-thigh - 0.004, (0.88 * r, 0.86 * r), (0.001, 0.0)),
        Section(-0.62 * thigh, (1.08 * r, 0.98 * r), (0.007, 0.0)),
        Section(-0.22 * thigh, (1.14 * r, 1.06 * r), (0.006, 0.0)),
        Section(0.014, (0.94 * r, 0.92 * r), (0.001, 0.0)),
    ]
    lower = [
        Section(0.016 - shank, (0.76 * q, 0.76 * q)),
        Section(-0.62 * shank, (1.04 * q, 0.98 * q), (-0.001, 0.0)),
        Section(-0.28 * shank, (1.12 * q, 1.04 * q), (0.001, 0.0)),
        Section(-0.006, (0.90 * q, 0.90 * q), (0.002, 0.0)),
    ]
    shin = [
        Section(-0.84 * shank, (0.52 * q, 0.50 * q), (0.46 * q, 0.0)),
        Section(-0.50 * shank, (0.66 * q, 0.66 * q), (0.58 * q, 0.0)),
        Section(-0.16 * shank, (0.54 * q, 0.58 * q), (0.58 * q, 0.0)),
    ]
    return {
        f"{side}HipRoll": [_ball((0.0, 0.0, -0.004), 0.98 * r, GREY)],
        f"{side}HipPitch": [
            loft(2, upper, WHITE, (0.014, 0.020), 2.5),
            _knob(1, (0.004, s * 1.0 * r, -0.35 * thigh), 0.55 * r, 0.005, ACCENT),
        ],
        f"{side}KneePitch": [
            _knob(1, (0.003, 0.0, 0.0), 0.86 * q, 0.88 * q, GREY, 0.3),
            loft(2, lower, WHITE, (0.012, 0.014), 2.4),
            loft(2, shin, ACCENT, (0.014, 0.014), 2.6, _MEDIUM),
        ],
        f"{side}AnklePitch": [_knob(1, (0.0, 0.0, 0.0), 0.72 * q, 0.80 * q, GREY, 0.4)],
        f"{side}AnkleRoll": _foot(body, side),
    }


def _foot(body: Body, side: Side) -> list[ColouredMesh]:
    """The sole's plate with the published outline, a shell that rises to the ankle, and the bumper."""
    outline, low = sole_hull(body, side), -body.lengths.FootHeight
    n = len(outline)
    plate = np.array([np.column_stack([outline, np.full(n, low + z)]) for z in (0.0, _SOLE)])
    middle = np.asarray(outline.mean(axis=0), dtype=np.float64)
    ends = np.array([[*middle, low], [*middle, low + _SOLE]])
    angle = np.asarray(np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False), dtype=np.float64)
    round_outline = _ray_lengths(np.asarray(outline - middle, dtype=np.float64), angle)
    way = np.column_stack([np.cos(angle), np.sin(angle)])
    rings = []
    for share, scale, z in (
        (0.0, 0.95, _SOLE - 0.001),
        (0.0, 0.965, 0.018),
        (0.06, 0.93, 0.026),
        (0.30, 0.86, 0.034),
        (0.66, 0.80, 0.041),
        (0.92, 0.78, 0.048),
        (1.0, 0.62, 0.053),
    ):
        ankle = np.array([-0.004, 0.0])
        shape = (1.0 - share) * (middle + round_outline[:, None] * way) + share * (ankle + 0.036 * way)
        centre = (1.0 - share) * middle + share * ankle
        rings.append(np.column_stack([centre + scale * (shape - centre), np.full(len(angle), low + z)]))
    shell_ends = np.array([[*middle, low + _SOLE - 0.001], [-0.004, 0.0, low + 0.054]])
    toes = outline[outline[:, 0] > 0.6 * outline[:, 0].max(), 1]
    across = np.linspace(float(toes.min()), float(toes.max()), 11)[1:-1]
    bumper = [Section(y, (0.006, 0.0065), (_front(outline, y) - 0.003, low + 0.018)) for y in across.tolist()]
    return [
        _closed(plate, ends, DARK),
        _closed(np.array(rings), shell_ends, WHITE),
        loft(1, bumper, ACCENT, (0.008, 0.008), 2.6, _MEDIUM),
    ]


def _front(outline: Array, y: float) -> float:
    """The largest x of a convex outline (n, 2) at some y, m."""
    a, b = outline, np.roll(outline, -1, axis=0)
    crosses = (a[:, 1] - y) * (b[:, 1] - y) <= 0.0
    p, q = a[crosses], b[crosses]
    rise = np.where(q[:, 1] == p[:, 1], 1.0, q[:, 1] - p[:, 1])
    return float((p[:, 0] + (y - p[:, 1]) / rise * (q[:, 0] - p[:, 0])).max())


def _ray_lengths(outline: Array, angle: Array) -> Array:
    """Distance from the origin to a convex outline (n, 2) in some directions, rad."""
    own = np.arctan2(outline[:, 1], outline[:, 0])
    order = np.argsort(own)
    a, b = outline[order], np.roll(outline[order], -1, axis=0)
    sector = np.searchsorted(own[order], np.arctan2(np.sin(angle), np.cos(angle)), side="right") - 1
    p, q = a[sector], b[sector]
    way = np.column_stack([np.cos(angle), np.sin(angle)])
    edge = q - p
    distance: Array = (p[:, 0] * edge[:, 1] - p[:, 1] * edge[:, 0]) / (
        way[:, 0] * edge[:, 1] - way[:, 1] * edge[:, 0]
    )
    return distance


def shell(body: Body) -> dict[str, list[ColouredMesh]]:
    """The pieces of each link that has any, by the name of the joint that moves it."""
    neck = [Section(-0.034, (0.022, 0.022)), Section(0.014, (0.020, 0.020))]
    parts = {
        TORSO: _trunk(body),
        "HeadYaw": [loft(2, neck, DARK, (0.004, 0.008), 2.0, _MEDIUM)],
        "HeadPitch": _head(body),
    }
    for side in SIDES:
        parts |= _arm(body, side) | _leg(body, side)
    return parts
