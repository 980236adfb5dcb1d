"""Inverse kinematics of the legs in closed form (Prenner 2011, 2.3, made general).

Departures from the text. (2.24) to (2.29) are as meant: atan2(sin, cos), the knee's range is on theta_6.
HipRoll, missing there, is atan2(y, -z) of the ankle in frame 3. The sole's normal (third column of R_0^8, not
the first as in 2.30) follows the target, so feet may be tilted.

The three hip axes meet in one point and so do the two of the ankle, hence: whether a target is in reach depends
on the distance of the two alone, and the one ambiguity within the joint limits is the sign of the knee angle.
Written in plain floats: a chain of 4x4 numpy products costs twenty times as much.
"""

from __future__ import annotations

import itertools
import math
from typing import ClassVar, Final, NamedTuple

from bridge.body.kinematics import PSI_K, Transform, hip_rotation, side_sign
from bridge.body.model import Body, JointSheet
from bridge.errors import NaoHilError
from bridge.types import Matrix3, Side, Vec3


class UnreachableError(NaoHilError):
    """A foot target that the leg cannot reach with any angles, limits left aside.

    Attributes:
        side: The leg.
        distance: How far the target is out of reach, m (infinite for a target that is not a number).
    """

    exit_code: ClassVar[int] = 3

    def __init__(self, side: Side, distance: float, sentence: str) -> None:
        super().__init__(sentence)
        self.side = side
        self.distance = distance


LegAngles = tuple[float, float, float, float, float, float]
"""HipYawPitch, HipRoll, HipPitch, KneePitch, AnklePitch, AnkleRoll, rad."""

_H: Final = math.sqrt(0.5)
_ROUNDING: Final = 1e-12
"""Excess distance that counts as rounding of a stretched leg, m."""
_YAW_TOLERANCE: Final = 1e-9
"""Tolerance of the angle between the feet, rad: a millionth of an encoder's step."""
_MAX_ITERATIONS: Final = 60
_SCAN_INTERVALS: Final = 32


class LegPair(NamedTuple):
    """Angles of both legs with their one HipYawPitch."""

    left: LegAngles
    right: LegAngles
    yaw: float
    """Turn of both feet about their own soles' normals away from the targets, rad. Eleven motors cannot satisfy
    twelve conditions: this turn is the free one."""
    spread: float
    """Error of the angle between the feet, rad (left against right): zero to 1e-12 in any stance, not
    always with legs drawn up to the ends of their ranges, or for feet turned further than the hips allow."""


class FootPose(NamedTuple):
    """Pose of a foot (frame 8, AnkleRoll): `solve_legs` takes it in the Torso frame."""

    place: Vec3
    """Place of the ankle, m."""
    axes: Matrix3
    """The foot's axes n, s and a as columns (2.21)."""

    @classmethod
    def of(cls, transform: Transform) -> FootPose:
        """The same from a homogeneous transform, shape (4, 4), m."""
        (n_x, s_x, a_x, p_x), (n_y, s_y, a_y, p_y), (n_z, s_z, a_z, p_z) = transform[:3].tolist()
        return cls((p_x, p_y, p_z), ((n_x, s_x, a_x), (n_y, s_y, a_y), (n_z, s_z, a_z)))


class _Target(NamedTuple):
    """A foot target as the solution needs it."""

    side: Side
    sign: float
    ankle: Vec3
    """Ankle from the hip's centre, Torso axes, m."""
    axes: Matrix3
    """Axes of the foot."""
    knee: float
    """KneePitch, rad."""
    bend_at_hip: float
    """Angle between the thigh and the line from hip to ankle, rad."""
    bend_at_ankle: float
    """Angle between the shank and that line, rad, negative."""


def _half_turn(y: float, x: float) -> float:
    """Angle of the line (not the ray) through (x, y): that within +-90 degrees, as rolls are."""
    return math.atan2(y, x) if x >= 0.0 else math.atan2(-y, -x)


def _wrap(angle: float) -> float:
    return math.remainder(angle, math.tau)


def _knee(body: Body, side: Side, distance: float) -> float:
    """KneePitch from the distance between hip and ankle (2.25, 2.26b, as a half angle, exact near straight)."""
    thigh, tibia = body.lengths.ThighLength, body.lengths.TibiaLength
    far, near = thigh + tibia, abs(thigh - tibia)
    name = "left" if side == "L" else "right"
    if not math.isfinite(distance):
        raise UnreachableError(side, math.inf, f"the target of the {name} foot is not a finite pose")
    out = max(distance - far, near - distance)
    if out > _ROUNDING:
        limit = f"at most {far:.4f}" if distance > far else f"at least {near:.4f}"
        raise UnreachableError(
            side,
            out,
            f"the {name} ankle is {1e3 * out:.3f} mm out of reach: {distance:.4f} m from the hip, "
            f"{limit} m is possible",
        )
    opening = math.sqrt(max((far - distance) * (far + distance), 0.0))
    closing = math.sqrt(max((distance - near) * (distance + near), 0.0))
    return 2.0 * math.atan2(opening, closing)


def _target(body: Body, side: Side, foot: FootPose) -> _Target:
    length, sign = body.lengths, side_sign(side)
    thigh, tibia = length.ThighLength, length.TibiaLength
    p_x, p_y, p_z = foot.place
    ankle = (p_x, p_y - sign * length.HipOffsetY, p_z + length.HipOffsetZ)
    # A sum with the rotation's elements carries any value that is not finite into the check of the distance.
    poison = 0.0 * sum(map(sum, foot.axes))
    knee = _knee(body, side, math.hypot(*ankle) + poison)
    s6, c6 = math.sin(knee), math.cos(knee)
    at_hip, at_ankle = math.atan2(tibia * s6, thigh + tibia * c6), math.atan2(-thigh * s6, tibia + thigh * c6)
    return _Target(side, sign, ankle, foot.axes, knee, at_hip, at_ankle)


def _six_angles(target: _Target) -> LegAngles:
    """All six angles of a leg from the full pose of its foot."""
    knee, sign = target.knee, target.sign
    (n_x, s_x, a_x), (n_y, s_y, a_y), (n_z, s_z, a_z) = target.axes
    v_x, v_y, v_z = target.ankle
    # The hip seen from the foot: R_roll(-psi_8) R_pitch(-theta_7) applied to the bent leg standing up.
    q_x = -(n_x * v_x + n_y * v_y + n_z * v_z)
    q_y = -(s_x * v_x + s_y * v_y + s_z * v_z)
    q_z = -(a_x * v_x + a_y * v_y + a_z * v_z)
    psi_8 = _half_turn(q_y, q_z)
    s8, c8 = math.sin(psi_8), math.cos(psi_8)
    theta_7 = _wrap(target.bend_at_ankle - math.atan2(q_x, q_y * s8 + q_z * c8))
    s7, c7 = math.sin(knee + theta_7), math.cos(knee + theta_7)
    # Columns of R_0^5 = R_0^8 R_roll(-psi_8) R_pitch(-theta_7 - theta_6).
    u_x, u_y, u_z = s8 * s_x + c8 * a_x, s8 * s_y + c8 * a_y, s8 * s_z + c8 * a_z
    x_x, x_y, x_z = c7 * n_x + s7 * u_x, c7 * n_y + s7 * u_y, c7 * n_z + s7 * u_z
    z_x, z_y, z_z = c7 * u_x - s7 * n_x, c7 * u_y - s7 * n_y, c7 * u_z - s7 * n_z
    y_y, y_z = c8 * s_y - s8 * a_y, c8 * s_z - s8 * a_z
    # Seen along the slanted axis (frame 1) it is R_yaw(-+phi_2) R_roll(psi_4 -+ 45 deg) R_pitch(theta_5).
    x_1, z_1 = _H * (x_z - sign * x_y), _H * (z_z - sign * z_y)
    psi_4 = math.atan2(_H * (y_z - sign * y_y), math.hypot(x_1, z_1)) - sign * PSI_K
    theta_5 = math.atan2(-x_1, z_1)
    # From the column that theta_5 leaves to phi_2: where the axes of the two fall together (leg spread beyond
    # its range), theta_5 is arbitrary and phi_2 makes up for it.
    s5, c5 = math.sin(theta_5), math.cos(theta_5)
    yaw_y = _H * (c5 * (x_y + sign * x_z) + s5 * (z_y + sign * z_z))
    phi_2 = -sign * math.atan2(yaw_y, c5 * x_x + s5 * z_x)
    return phi_2, psi_4, theta_5, knee, theta_7, psi_8


def _five_angles(target: _Target, phi_2: float) -> tuple[LegAngles, float]:
    """The angles with HipYawPitch given, and the yaw of the foot about its normal away from the target."""
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = hip_rotation(target.side, phi_2)
    v_x, v_y, v_z = target.ankle
    # The ankle in frame 3, then in frame 4, where its y is zero.
    x = r00 * v_x + r10 * v_y + r20 * v_z
    y = r01 * v_x + r11 * v_y + r21 * v_z
    z = r02 * v_x + r12 * v_y + r22 * v_z
    psi_4 = _half_turn(y, -z)
    s4, c4 = math.sin(psi_4), math.cos(psi_4)
    theta_5 = _wrap(math.atan2(-x, s4 * y - c4 * z) - target.bend_at_hip)
    s6, c6 = math.sin(theta_5 + target.knee), math.cos(theta_5 + target.knee)
    # Axes of frame 6, R_0^3 R_roll(psi_4) R_pitch(theta_5 + theta_6); u is the z axis of frame 4.
    u_x, u_y, u_z = c4 * r02 - s4 * r01, c4 * r12 - s4 * r11, c4 * r22 - s4 * r21
    x_x, x_y, x_z = c6 * r00 - s6 * u_x, c6 * r10 - s6 * u_y, c6 * r20 - s6 * u_z
    y_x, y_y, y_z = c4 * r01 + s4 * r02, c4 * r11 + s4 * r12, c4 * r21 + s4 * r22
    z_x, z_y, z_z = s6 * r00 + c6 * u_x, s6 * r10 + c6 * u_y, s6 * r20 + c6 * u_z
    # The foot's wanted normal in frame 6, which R_pitch(theta_7) R_roll(psi_8) has to meet.
    (n_x, s_x, a_x), (n_y, s_y, a_y), (n_z, s_z, a_z) = target.axes
    normal_x = x_x * a_x + x_y * a_y + x_z * a_z
    normal_y = y_x * a_x + y_y * a_y + y_z * a_z
    normal_z = z_x * a_x + z_y * a_y + z_z * a_z
    psi_8 = math.atan2(-normal_y, math.hypot(normal_x, normal_z))
    theta_7 = math.atan2(normal_x, normal_z)
    # The foot's own x axis then lies along the t axis, and its wanted ones n and s have these parts along t.
    t_x = normal_z * x_x - normal_x * z_x
    t_y = normal_z * x_y - normal_x * z_y
    t_z = normal_z * x_z - normal_x * z_z
    yaw = math.atan2(t_x * s_x + t_y * s_y + t_z * s_z, t_x * n_x + t_y * n_y + t_z * n_z)
    return (phi_2, psi_4, theta_5, target.knee, theta_7, psi_8), yaw


def solve_legs(body: Body, left: FootPose, right: FootPose) -> LegPair:
    """Angles of both legs with their one HipYawPitch, from the poses of both feet.

    The positions and the soles' normals are met exactly, the angle between the feet to 1e-9 rad (else see
    `LegPair.spread`). A yaw common to both feet is left (`LegPair.yaw`), zero where both point along the
    torso's x axis, as in straight walking.

    Args:
        body: The data sheet.
        left: Target of the left foot.
        right: Target of the right foot.

    Raises:
        UnreachableError: An ankle is too far from its hip or too near, or a pose is not finite.
    """
    targets = _target(body, "L", left), _target(body, "R", right)
    # Each leg's own solution is a zero of its own yaw, which falls for the left and rises for the right: where
    # legs stand as in walking, the two bracket the shared angle.
    low = _shared(*targets, _six_angles(targets[0])[0])
    if abs(low.spread) <= _YAW_TOLERANCE:
        return low
    high = _shared(*targets, _six_angles(targets[1])[0])
    if low.spread * high.spread < 0.0:
        pair = _zero_between(*targets, low, high)
        if abs(pair.spread) <= _YAW_TOLERANCE:
            return pair
    return _search(*targets, body.joints["LHipYawPitch"])


def _shared(left: _Target, right: _Target, phi_2: float) -> LegPair:
    """Both legs at one HipYawPitch."""
    left_angles, left_yaw = _five_angles(left, phi_2)
    right_angles, right_yaw = _five_angles(right, phi_2)
    return LegPair(left_angles, right_angles, 0.5 * (left_yaw + right_yaw), _wrap(left_yaw - right_yaw))


def _search(left: _Target, right: _Target, hip_yaw_pitch: JointSheet) -> LegPair:
    """The zero of the spread in HipYawPitch's range that turns the feet least; if none is found, the least one.

    Needed only for legs drawn up far in front of the body or to its side, where the spread is not monotonic.
    """
    step = (hip_yaw_pitch.upper - hip_yaw_pitch.lower) / _SCAN_INTERVALS
    scan = [_shared(left, right, hip_yaw_pitch.lower + i * step) for i in range(_SCAN_INTERVALS + 1)]
    changes = [(a, b) for a, b in itertools.pairwise(scan) if a.spread * b.spread <= 0.0]
    pairs = [_zero_between(left, right, a, b) for a, b in changes]
    # Where a roll jumps by half a turn the spread changes sign without a zero.
    zeros = [pair for pair in pairs if abs(pair.spread) <= _YAW_TOLERANCE]
    if zeros:
        return min(zeros, key=lambda pair: abs(pair.yaw))
    return min(scan, key=lambda pair: abs(pair.spread))


def _zero_between(left: _Target, right: _Target, low: LegPair, high: LegPair) -> LegPair:
    """Zero of the spread between two ends: secant steps that halve a stale end (Illinois)."""
    f_low, f_high = low.spread, high.spread
    for _ in range(_MAX_ITERATIONS):
        if abs(high.spread) <= _YAW_TOLERANCE or f_high == f_low:
            break
        a, b = low.left[0], high.left[0]
        pair = _shared(left, right, b - f_high * (b - a) / (f_high - f_low))
        if pair.spread * f_high < 0.0:
            low, f_low = high, f_high
        else:
            f_low *= 0.5
        high, f_high = pair, pair.spread
    return high
