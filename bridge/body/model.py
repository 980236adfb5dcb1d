"""Types of a robot body's data sheet: every number about the robot, once."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from bridge.types import NotNegative, Positive, Vec3

Angle: TypeAlias = Annotated[float, msgspec.Meta(ge=-7.0, le=7.0)]
"""rad; the bounds refuse degrees."""
Length: TypeAlias = Annotated[float, msgspec.Meta(ge=-1.0, le=1.0)]
"""m; the bounds refuse millimetres."""

Tensor = tuple[float, float, float, float, float, float]
"""Inertia tensor elements (ixx, iyy, izz, ixy, ixz, iyz), kg m^2."""


class _Sheet(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base: frozen, and a misspelt key is an error."""


class Lengths(_Sheet, frozen=True):
    """Named lengths of the vendor's drawings, m."""

    NeckOffsetZ: Length
    ShoulderOffsetY: Length
    ShoulderOffsetZ: Length
    UpperArmLength: Length
    ElbowOffsetY: Length
    LowerArmLength: Length
    HandOffsetX: Length
    HandOffsetZ: Length
    HipOffsetY: Length
    HipOffsetZ: Length
    ThighLength: Length
    TibiaLength: Length
    FootHeight: Length


class Motor(_Sheet, frozen=True):
    """A motor type, at the motor shaft."""

    no_load_speed_rpm: Positive
    stall_torque: Positive
    """Torque at standstill, N m."""
    nominal_torque: Positive
    """Torque for continuous operation, N m."""
    source: str


class JointSheet(_Sheet, frozen=True):
    """One joint: its range and its drive."""

    lower: Angle
    """Lower end of the range, rad."""
    upper: Angle
    """Upper end of the range, rad."""
    motor: str
    """Key of `Body.motors`."""
    gear_ratio: Positive


class Link(_Sheet, frozen=True):
    """The rigid body that a joint moves (or the torso)."""

    mass: Annotated[float, msgspec.Meta(gt=0.0, le=20.0)]
    """Mass of the link, kg."""
    com: Vec3
    """Centre of mass relative to the joint's origin, zero-pose aligned frame (x forward, y left, z up), m."""
    inertia: Tensor
    """About the centre of mass, zero-pose aligned axes, kg m^2."""


class CouplingRow(_Sheet, frozen=True):
    """Range of one joint at one position of another; between rows: linear (assumed)."""

    at: float
    """Position of the other joint, rad."""
    lower: float
    upper: float


class Coupling(_Sheet, frozen=True):
    """Anti-collision tables: AnkleRoll by AnklePitch for each leg, HeadPitch by |HeadYaw|."""

    LAnkleRoll: tuple[CouplingRow, ...]
    RAnkleRoll: tuple[CouplingRow, ...]
    HeadPitch: tuple[CouplingRow, ...]


class Fsr(_Sheet, frozen=True):
    """Places of the four force sensors of each foot (FL, FR, RL, RR), AnkleRoll frame, m."""

    L: tuple[Vec3, Vec3, Vec3, Vec3]
    R: tuple[Vec3, Vec3, Vec3, Vec3]
    range: Positive
    """Largest force one cell reports, N."""


class InertialUnit(_Sheet, frozen=True):
    """Places of the inertial sensors in the Torso frame, and their resolution."""

    accelerometer: Vec3
    gyroscope: Vec3
    gyroscope_axes: int
    """2 (X, Y) or 3."""
    accelerometer_range: Positive
    """Largest reading, m/s^2."""
    accelerometer_step: Positive
    """m/s^2 per count"""
    gyroscope_range: Positive
    """Largest reading, rad/s."""
    gyroscope_step: Positive
    """rad/s per count"""
    gyroscope_bias: Positive = 0.01
    """Standard deviation over robots of the rate that a gyroscope at rest reports, rad/s; default: an H25's."""
    angle_step: NotNegative = 0.0
    """Step of the fused angles, rad; 0: none."""


class Foot(_Sheet, frozen=True):
    """Shape of the left foot; the right one mirrors y."""

    sole: tuple[tuple[float, float], ...]
    """Outline of the sole, AnkleRoll frame projected to the ground, counter-clockwise or clockwise, m."""
    centre: tuple[float, float]
    """Middle of the sole (FM of the thesis, after 2.18), AnkleRoll frame projected to the ground, m."""


class Shapes(_Sheet, frozen=True):
    """Sizes of the shell, for contacts; the sole is in `Foot`. All lengths in m, in the link's frame."""

    torso_bottom: float
    """z of the pelvis' underside, Torso frame."""
    torso_top: float
    """z of the shoulders' upper side, Torso frame."""
    torso_depth: Positive
    """Along x, symmetric to the Torso frame."""
    torso_width: Positive
    """Along y, at the top."""
    waist_width: Positive
    """Along y, at the bottom; linear in between."""
    head_height: float
    """z of the head's middle, HeadPitch frame."""
    head_radius: Positive
    upper_arm_radius: Positive
    forearm_radius: Positive
    """Radius of forearm and hand."""
    hip_height: float
    """z of the buttock's middle, HipRoll frame."""
    hip_radius: Positive
    thigh_radius: Positive
    shank_radius: Positive
    shell_friction: Positive
    """Coulomb friction of the plastic shell, as a fraction of the sole's on the same floor."""


class Body(_Sheet, frozen=True):
    """A robot body. Numbers only: the tree of joints, the same for every NAO, is in `joints`."""

    name: str
    title: str
    base: str
    """Shipped body whose cameras, motions, wear and facts of NAOqi this one has."""
    model: Literal["H21", "H25"]
    cycle: Annotated[float, msgspec.Meta(ge=0.001, le=0.1)]
    """DCM cycle, s"""
    lengths: Lengths
    joints: dict[str, JointSheet]
    """By joint name; the mechanical joints of this body (both HipYawPitch; no wrists and hands on an H21)."""
    motors: dict[str, Motor]
    links: dict[str, Link]
    """By the name of the joint that moves it; `Torso` for the trunk. Hands are part of the wrist's (H25) or
    the forearm's (H21) link."""
    coupling: Coupling
    fsr: Fsr
    inertial_unit: InertialUnit
    foot: Foot
    shapes: Shapes
    encoder_steps: int
    """Counts per turn of the joint."""
    battery_energy: Positive
    """Energy of a full battery, W h."""
    sources: dict[str, str]
    """Source of each group of numbers, tagged `confirmed: ...` or `assumed: ...`."""
    repairs: tuple[str, ...]
    """Impossible numbers of a source, and the values that replace them."""
