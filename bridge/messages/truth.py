"""Ground truth of an emulated robot; no controller sees it."""

from __future__ import annotations

from typing import Annotated

import msgspec

from bridge.messages.frames import N_LEDS, Joints
from bridge.messages.schema import SCHEMA_VERSION
from bridge.types import Count, Finite, Quaternion, Vec2, Vec3


class Contact(msgspec.Struct, frozen=True, kw_only=True):
    """Ground reaction on one foot (ground truth)."""

    force: Vec3
    """Sum of the contact forces on the foot, world frame, N."""
    cop: Vec2 | None
    """Centre of pressure in the foot's sole frame (below the AnkleRoll origin), m; None without contact."""


class TruthFrame(msgspec.Struct, frozen=True, kw_only=True):
    """Ground truth of the emulator at one sensor frame (key `world/truth`); never seen by a controller."""

    version: int = SCHEMA_VERSION
    seq: Count
    time: Finite
    torso_position: Vec3
    """Torso frame origin, world frame, m."""
    torso_orientation: Quaternion
    torso_velocity: Vec3
    """Velocity of the Torso frame origin, world frame, m/s."""
    torso_angular_velocity: Vec3
    """World frame, rad/s."""
    joints: Joints
    """True joint angles, rad."""
    com: Vec3
    """Centre of mass, world frame, m."""
    zmp: Vec2 | None
    """Centre of pressure of both feet together on the ground, world frame x and y, m; None in flight."""
    left: Contact
    right: Contact
    fell: bool
    """Torso tilt over 45 deg, or torso below half its start height, or anything but a foot on the ground."""
    leds: Annotated[tuple[int, ...], msgspec.Meta(max_length=N_LEDS)] = ()
    """Brightness of each LED, as `LedFrame`; empty while all are dark."""
