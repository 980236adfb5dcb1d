"""The world of an emulated robot (query `world/command`), and its ground truth, hidden from controllers."""

from __future__ import annotations

from typing import Annotated

import msgspec

from bridge.messages.frames import N_LEDS, SCHEMA_VERSION, Joints
from bridge.messages.game import NO_GAME, RobotGame
from bridge.messages.world import SolidShape, ThingKind
from bridge.types import Count, Finite, Quaternion, Vec2, Vec3


class Contact(msgspec.Struct, frozen=True, kw_only=True):
    """Ground reaction on one foot (ground truth)."""

    force: Vec3
    """Sum of the contact forces on the foot, world frame, N."""
    cop: Vec2 | None
    """Centre of pressure in the foot's sole frame (below the AnkleRoll origin), m; None without contact."""


class WorldObject(msgspec.Struct, frozen=True, kw_only=True):
    """An object in the world."""

    name: str
    shape: SolidShape = "box"
    size: Vec3
    """Edges of the box around it, m."""
    position: Vec3
    """Its middle, world frame, m."""
    orientation: Quaternion
    mass: Finite
    """kg; 0: fixed."""


class TruthFrame(msgspec.Struct, frozen=True, kw_only=True):
    """Ground truth of the emulator at one sensor frame (key `world/truth`), hidden from controllers."""

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
    objects: tuple[WorldObject, ...] = ()
    """The movable objects of the world, and fixed ones that were placed after its start."""
    game: RobotGame = NO_GAME
    """The league's game."""


class WorldThing(msgspec.Struct, frozen=True, kw_only=True):
    """A thing that is visible to the cameras and has no contacts."""

    name: str
    kind: ThingKind
    size: Finite
    """Diameter, m."""
    position: Vec3
    """Its middle, world frame, m."""
    facing: Vec3
    """Unit vector out of the front of a landmark or a face, world frame."""


class Tile(msgspec.Struct, frozen=True):
    """A square tile that is fixed on the floor, floor frame."""

    at: Vec2
    """Its middle, m."""
    edge: Finite
    """Edge of a tile, m."""
    height: Finite
    """Height of its top over the floor, m."""


class HeightGrid(msgspec.Struct, frozen=True):
    """Points of the ground with triangles between, floor frame."""

    centre: Vec2
    """Middle of the ground, m."""
    spacing: Finite
    """Between neighbours, m."""
    heights: tuple[tuple[Finite, ...], ...]
    """Rows from right to left (y), each from back to front (x), m."""


class Stripe(msgspec.Struct, frozen=True):
    """A straight white line on the floor, floor frame; its ends are half its width beyond `begin` and `end`."""

    begin: Vec2
    """m"""
    end: Vec2
    """m"""
    width: Finite
    """m"""


class Field(msgspec.Struct, frozen=True):
    """A playing field: a green carpet with lines, in the middle of the floor."""

    size: Vec2
    """Length of the carpet along x and y, m."""
    stripes: tuple[Stripe, ...]
    goals: tuple[str, ...]
    """Names of the objects that are its goals, white posts and bars."""


class Terrain(msgspec.Struct, frozen=True):
    """The ground: uneven by tiles or a height grid, and painted with a field."""

    tiles: tuple[Tile, ...] = ()
    grid: HeightGrid | None = None
    field: Field | None = None


class WorldReply(msgspec.Struct, frozen=True, kw_only=True):
    """The world after a command."""

    version: int = SCHEMA_VERSION
    text: str
    """The action, in one sentence."""
    seq: int
    """Number of the cycle boundary at the end of the action."""
    time: Finite
    """Robot time, s."""
    paused: bool
    floor: Vec2
    """Roll and pitch of the floor, rad."""
    friction: Finite
    objects: tuple[WorldObject, ...]
    things: tuple[WorldThing, ...] = ()
    faults: tuple[str, ...]
    """Names of the faults in force."""
    terrain: Terrain | None = None
    """Tiles, heights and field, for a `status` with `terrain`; otherwise None."""
