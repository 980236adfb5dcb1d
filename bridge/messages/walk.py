"""Commands to a walker that serves (query `walk/command`), and its replies.

A walker started as a service stands and waits for commands. A command is a msgpack map; omitted fields change
nothing. Lengths in m, velocities in m/s and rad/s, in the heading of the walk: x forward, y left.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from bridge.body.joints import UPPER_JOINTS
from bridge.messages.frames import SCHEMA_VERSION
from bridge.types import Count, Finite, Pose, Vec2, Vec3

WALK_COMMAND = "walk/command"
"""Key suffix of the query."""

TorsoName = Literal["none", "thesis", "robust"]
"""Torso control: off, designed as in thesis 4.2.2, or robust against uncertainty of the plant."""


class WalkCommand(msgspec.Struct, frozen=True, kw_only=True):
    """Order to the walker; None: unchanged."""

    version: int = SCHEMA_VERSION
    op: Literal["walk", "stop", "motion", "set", "status", "take", "release"]
    """`walk`: begin, or continue with these values; `stop`: close the feet and stand; `motion`: likewise,
    then play `motion`; `set`: change without beginning; `status`: change nothing; `take`: acquire the lease,
    and stand; `release`: give it back."""
    velocity: Vec3 | None = None
    """vx, vy, omega in m/s, m/s, rad/s: mean over a step, reached by the length of the steps; zeros stop."""
    steps: Count | None = None
    """Steps of the walk to begin, the closing one included; 0 or left out: no bound."""
    distance: Annotated[float, msgspec.Meta(gt=0.0, le=1e4)] | None = None
    """Way of the walk to begin, m; left out: no bound. Exact by the plan, or by the odometry for a gait that
    walks in any direction."""
    target: Vec3 | None = None
    """Goal of the walk from the robot's present pose: forward and to the left, m, and turn, rad. For gaits that
    walk in any direction."""
    gait: Annotated[str, msgspec.Meta(max_length=4096)] | None = None
    """Name of one of the walker's gaits, in force from the next stand on; with `walk` the walker stops for it,
    then walks on."""
    torso: TorsoName | None = None
    """Torso control, in force at once; None: unchanged, or the default of a new gait."""
    admittance: bool | None = None
    """Leg and ankle admittance, as `torso`."""
    hold: Annotated[float, msgspec.Meta(gt=0.0, le=3600.0)] | None = None
    """Robot time after which the walk stops unless `walk` or `set` gives it again, s; left out: none. For
    manual control, whose link may fail: `set` with `hold` alone keeps a walk going, and begins none."""
    motion: Annotated[str, msgspec.Meta(max_length=64)] | None = None
    """`get-up`, or the name of a motion of the package; `sit-down` is the body's own."""
    at: Count | None = None
    """First sensor frame (`seq`) to act on; left out: the next. In lockstep one `at` gives one run."""


class UpperBody(msgspec.Struct, frozen=True, kw_only=True):
    """Command of another program to head and arms of a robot that a walker holds (key `walk/upper-body`).

    The newest one is in force. The joints that it leaves out are the walker's.
    """

    version: int = SCHEMA_VERSION
    joints: tuple[str, ...]
    position: tuple[Finite, ...]
    """Wanted angle of each, rad; hands 0 to 1."""
    stiffness: tuple[Annotated[float, msgspec.Meta(ge=-1.0, le=1.0)], ...]
    """Wanted stiffness of each; negative: free."""

    def __post_init__(self) -> None:
        for joint in self.joints:
            if joint not in UPPER_JOINTS:
                raise ValueError(f"`{joint}` is no joint of the head or the arms")
        if not len(self.joints) == len(self.position) == len(self.stiffness):
            raise ValueError("each joint has one position and one stiffness")


class WalkStatus(msgspec.Struct, frozen=True, kw_only=True):
    """State of the walker."""

    version: int = SCHEMA_VERSION
    text: str
    """Effect of the command, in one sentence."""
    seq: Count
    """Newest sensor frame that the walker answered."""
    state: str
    """As in `WalkTelemetry`: `approach`, `walk`, `stopping`, `stand`, `fallen`, `motion` or `rest`."""
    gait: str
    torso: str
    admittance: bool
    velocity: Vec3
    """Velocity of the planned steps; zeros at rest."""
    steps: Count
    """Steps of this walk, or of the last one."""
    distance: Finite
    """Way of this walk, or the last one, by the plan, m."""
    position: Vec3
    """Middle between the feet by the odometry since the walker began: x, y and yaw, m, m, rad."""
    failure: str = ""
    """Why the last walk ended before its order was carried out; empty: it did not."""


class WalkTelemetry(msgspec.Struct, frozen=True, kw_only=True):
    """Plan, estimates and corrections of a cycle, for display and recordings (key `walk/telemetry`)."""

    version: int = SCHEMA_VERSION
    seq: Count
    """`seq` of the sensor frame it belongs to."""
    state: str
    """`approach`, `walk`, `stopping`, `stand`, `fallen`, `motion` (key frames) or `rest` (after them)."""
    phase: str
    """`DSL`, `SSL`, `DSR`, `SSR`, `start`, `stop` or `stand`."""
    step: Count
    """Steps completed."""
    steps: Count
    """Steps asked for; 0: without end."""
    place: Vec3 = (0.0, 0.0, 0.0)
    """Middle between the feet by the odometry since the walker began: x, y, m, and yaw, rad."""
    zmp: Vec2
    """Planned ZMP in the walk frame (x forward, y left, origin between the feet at the start), m."""
    com: Vec2
    """Planned centre of mass in the walk frame, m."""
    left: Pose
    """Planned left sole in the walk frame: x, y, z, m, and roll, pitch, yaw, rad."""
    right: Pose
    angle: Vec2 = (0.0, 0.0)
    """The walker's estimate of torso roll and pitch, rad."""
    zmp_measured: Vec2 | None = None
    """ZMP from the force sensors in the walk frame, with the soles as planned, m; None unloaded."""
    contact: tuple[bool, bool] = (False, False)
    """Whether the left and the right foot touch the ground, by their force sensors."""
    foot_lift: Vec2 = (0.0, 0.0)
    """Height of the left and the right sole over the plan (leg admittance), m."""
    ankle_roll: Vec2 = (0.0, 0.0)
    """Added to LAnkleRoll and RAnkleRoll by the ankle admittance and the swing foot's orientation, rad."""
    ankle_pitch: Vec2 = (0.0, 0.0)
    """Added to LAnklePitch and RAnklePitch, likewise."""
    torso_control: Vec2 = (0.0, 0.0)
    """Added to LAnklePitch and RAnklePitch by torso control, damping and lean feedback, rad."""
    fall_cause: str = ""
    """Why the robot was taken for falling, the last time; empty: never."""
    failure: str = ""
    """Why the last walk ended before its order was carried out; empty: it did not."""
    tick: Finite = 0.0
    """Duration of the controller's tick, s (0 in recordings without wall-clock values)."""
