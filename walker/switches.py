"""Which mechanisms of the stabiliser are on: one switch each, and two named sets of them."""

from __future__ import annotations

from typing import Any, Final, Literal, get_args

import msgspec

from bridge.errors import ConfigurationError
from bridge.messages.walk import TorsoName
from bridge.validation import unknown_name


class Switches(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One switch per mechanism; each acts alone. As constructed all are off: the bare plan."""

    leg_admittance: bool = False
    """Thesis 4.1.1: the swing leg yields to the ground along z at touch-down."""
    ankle_admittance: bool = False
    """Thesis 4.1.2: the swing foot turns until its sole is flat on the ground."""
    torso: TorsoName = "none"
    """Torso control, thesis 4.2: notch and PI from the torso's pitch to the stance ankle."""
    gyroscope_damping: bool = False
    """The stance ankle turns against the torso's rate."""
    lean_feedback: bool = False
    """The stance ankle turns against the torso's lean."""
    joint_compliance: bool = False
    """Compensation of the drives' deflection under the planned load."""
    swing_foot_orientation: bool = False
    """The swing foot is turned about the stance foot against the torso's measured tilt."""
    ground_tilt: bool = False
    """The plan is aligned to the ground by the stance soles."""
    common_ankle_tilt: bool = False
    """The common turn of both ankle admittances becomes the ground's tilt."""
    late_touch_down: bool = False
    """A foot that is late stays a swing foot; it is lowered further, and the plan waits for it."""
    attitude_correction: bool = False
    """The fused angle is corrected by the mean of the accelerometer."""
    gyroscope_lean: bool = False
    """Swing foot and stance ankle turn against the integral of the gyroscope instead of the fused angle."""
    foothold_feedback: bool = False
    """Footholds follow the measured capture point, in gaits that can move them."""
    foot_placement: bool = False
    """The target of the swing foot is its foothold less the learnt miss."""
    capture_step: bool = False
    """A standing robot answers a push by a capture step, with gaits that can."""
    heading_hold: bool = False
    """Footholds turn back by the angle by which the robot turned off its plan, in gaits that can."""
    velocity_hold: bool = False
    """Footholds make up for the velocity by which the robot is off its command, in gaits that can."""
    step_hold: bool = False
    """A step ends later while the robot tips over the outer edge of its stance foot, in gaits that can."""


StabilizerName = Literal["own", "thesis", "none"]
"""The gait's own switches; the thesis' admittances and torso control and nothing else; all off."""
NAMED: Final[dict[str, Switches]] = {
    "thesis": Switches(leg_admittance=True, ankle_admittance=True, torso="thesis"),
    "none": Switches(),
}


def differing(one: Switches, other: Switches) -> list[str]:
    """Names of the switches in which two sets differ."""
    return [name for name in Switches.__struct_fields__ if getattr(one, name) != getattr(other, name)]


def switch_changes(
    stabilizer: str | None = None, torso: str | None = None, admittance: bool | None = None
) -> dict[str, Any]:
    """Changes to a controller's parameters by the options that people and walk commands have.

    Args:
        stabilizer: A `StabilizerName`; None: as `own`.
        torso: Torso control; None: as it is.
        admittance: Of legs and ankles together; None: as it is.

    Raises:
        ConfigurationError: no such stabilizer.
    """
    if stabilizer not in (None, *get_args(StabilizerName)):
        raise ConfigurationError(unknown_name("stabilizer", str(stabilizer), get_args(StabilizerName)))
    table: dict[str, Any] = msgspec.to_builtins(NAMED[stabilizer]) if stabilizer in NAMED else {}
    if torso is not None:
        table["torso"] = torso
    if admittance is not None:
        table |= {"leg_admittance": admittance, "ankle_admittance": admittance}
    return {"switches": table} if table else {}
