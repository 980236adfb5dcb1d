"""Commands to a walker that serves (query `walk/command`), and what it answers.

A walker started as a service stands, waits, and walks when it is told to. A command is a msgpack map; what it
leaves out stays as it is. Lengths in m, velocities in m/s and rad/s, in the heading of the walk: x forward, y
left.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from bridge.messages import SCHEMA_VERSION, Count, Finite, Vec3

COMMAND = "walk/command"
"""Key suffix of the query."""

GaitName = Literal["static", "dynamic", "huang"]
TorsoName = Literal["none", "thesis", "robust"]


class WalkCommand(msgspec.Struct, frozen=True, kw_only=True):
    """What the walker is to do; None: leave as it is."""

    version: int = SCHEMA_VERSION
    op: Literal["walk", "stop", "set", "status"]
    """`walk`: begin, or go on as said here; `stop`: close the feet and stand; `set`: change without beginning;
    `status`: only tell."""
    velocity: Vec3 | None = None
    """vx, vy, omega in m/s, m/s, rad/s: mean over a step, reached by the length of the steps; zeros stop."""
    steps: Count | None = None
    """Steps of the walk to begin, the closing one included; 0 or left out: no bound."""
    distance: Annotated[float, msgspec.Meta(gt=0.0, le=1e4)] | None = None
    """Way of the walk to begin, m, met exactly by the plan; left out: no bound."""
    gait: GaitName | None = None
    """Takes effect at the next stand; with `walk` the walker stands for it, then walks on."""
    torso: TorsoName | None = None
    """Torso control, in force at once; None: as it is, and of another gait its own choice."""
    admittance: bool | None = None
    """Leg and ankle admittance, as `torso`."""
    hold: Annotated[float, msgspec.Meta(gt=0.0, le=3600.0)] | None = None
    """Robot time after which the walk stops unless a `walk` came again, s; left out: it does not. For people at
    a key or a stick, whose line may break."""
    at: Count | None = None
    """First sensor frame (`seq`) to act on; left out: the next. In lockstep one `at` gives one run."""


class WalkStatus(msgspec.Struct, frozen=True, kw_only=True):
    """What the walker does."""

    version: int = SCHEMA_VERSION
    text: str
    """What the command led to, in one sentence."""
    seq: Count
    """Newest sensor frame that the walker answered."""
    state: str
    """As in `WalkTelemetry`: `approach`, `walk`, `stopping`, `stand` or `fallen`."""
    gait: str
    torso: str
    admittance: bool
    velocity: Vec3
    """Of the steps that are planned now; zeros at rest."""
    steps: Count
    """Walked in this walk, or in the last one."""
    distance: Finite
    """Way of this walk, or the last one, by the plan, m."""
    position: Vec3
    """x, y and yaw by the plan since the walker began, m, m, rad: odometry that knows nothing of slip."""
