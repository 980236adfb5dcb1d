"""Parameters of the controller: every number that is not the gait's, with its physical bound.

Beyond its bound a number is a slip of unit or digit. The bounds are wide: several times the most that any NAO
can use (52 N of weight, joints of 8 rad/s, legs of 0.2 m). A number within them need not walk.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import msgspec

from bridge.config import from_dict, load_toml, read_toml
from bridge.errors import ConfigurationError
from bridge.types import NotNegative, Positive
from walker.estimation.attitude import AttitudeParameters, LeanParameters
from walker.estimation.contact import ContactParameters, TouchDownParameters
from walker.estimation.fall import FallParameters, FallPredictorParameters
from walker.estimation.ground import GroundParameters
from walker.gaits.catalogue import gait_file
from walker.mechanisms.admittance import AnkleParameters, LegParameters
from walker.mechanisms.capture_step import BackwardStepParameters, CaptureParameters, LandedFootParameters
from walker.mechanisms.compliance import JointComplianceParameters
from walker.mechanisms.foothold_feedback import DeviationParameters
from walker.mechanisms.hold import VelocityHoldParameters
from walker.mechanisms.stance_ankle import DampingParameters, LeanFeedbackParameters
from walker.mechanisms.swing_foot import SwingFootOrientationParameters
from walker.mechanisms.tipping import TippingParameters
from walker.mechanisms.torso_control import TorsoDesigns, TorsoLimits
from walker.switches import Switches

_TABLE: Final = (
    (0.1, "s", "torso_design.thesis.controller.sample_time torso_design.robust.controller.sample_time"),
    (0.5, "s", "latency leg.latency com_smoothing"),
    (1.0, "s", "max_gap damping.roll damping.pitch landed_foot.damping"),
    (5.0, "s", "landed_foot.landing_time landed_foot.contact_time landed_foot.standing_time"),
    (5.0, "s", "touch_down.max_wait capture.min_time_after_step foresight.push_time"),
    (5.0, "s", "tipping.max_hold fall.no_support fall.brace_time"),
    (60.0, "s", "ground.time_constant ground.walking_time_constant ground.tipping_time lean.time_constant"),
    (60.0, "s", "lean.mean_time_constant foresight.acceleration_time compliance.ramp_time"),
    (60.0, "s", "torso_design.thesis.specification.rise_time torso_design.thesis.controller.reset_time"),
    (60.0, "s", "torso_design.robust.controller.reset_time"),
    (600.0, "s", "compliance.adaptation_time"),
    (0.5, "m", "deviation.max_innovation deviation.max_placement deviation.max_placement_change"),
    (0.5, "m", "tipping.hold_deviation"),
    (0.5, "m", "leg.k_a leg.k_b"),
    (0.5, "m", "foresight.ahead foresight.behind foresight.capture_ahead foresight.capture_behind"),
    (0.5, "m", "foresight.outside_stance foresight.outside_swing leg.target_depth leg.max_ankle_z"),
    (0.5, "m", "backward_step.hip_behind backward_step.arm_behind backward_step.max_beside"),
    (0.5, "m", "landed_foot.max_offset touch_down.search_depth"),
    (2.0, "m/s", "leg.max_rate touch_down.search_rate velocity_hold.max_correction"),
    (5.0, "m/s", "foresight.push"),
    (0.2, "rad", "compliance.half_backlash"),
    (math.pi, "rad", "ground.max_tilt fall.angle fall.capture_angle torso_limits.offset damping.max_offset"),
    (math.pi, "rad", "swing_foot_orientation.max_angle swing_foot_orientation.level_angle"),
    (math.pi, "rad", "landed_foot.max_damping backward_step.hip_angle"),
    (2.0 * math.pi, "rad", "backward_step.arm_angle"),
    (20.0, "rad/s", "ground.common_rate ground.max_rate torso_limits.rate damping.max_rate"),
    (20.0, "rad/s", "ankle.max_rate swing_foot_orientation.max_rate swing_foot_orientation.return_rate"),
    (20.0, "rad/s", "swing_foot_orientation.capture_roll_return_rate torso_limits.bleed_rate"),
    (20.0, "rad/s", "swing_foot_orientation.standing_roll_return_rate backward_step.hip_rate"),
    (20.0, "rad/s", "swing_foot_orientation.capture_pitch_return_rate backward_step.hip_return_rate"),
    (20.0, "rad/s", "backward_step.arm_rate backward_step.arm_return_rate"),
    (20.0, "N", "ankle.force_tolerance"),
    (200.0, "N", "contact.on contact.off ground.min_force leg.k_c leg.k_d leg.force_tolerance"),
    (2000.0, "N s/m", "leg.D"),
    (0.5, "kg m^2", "ankle.M_roll ankle.M_pitch"),
    (20.0, "N m s/rad", "ankle.D_roll ankle.D_pitch"),
    (20.0, "N m/rad", "ankle.K_roll ankle.K_pitch"),
    (0.5, "rad/(N m)", "compliance.coefficient"),
    (10.0, "N m", "compliance.backlash_torque"),
    (50.0, "rad/m", "landed_foot.turn"),
    (50.0, "1/s", "attitude.proportional"),
    (5.0, "1/s^2", "attitude.integral"),
    (100.0, "1/s", "torso_design.thesis.controller.integral_gain"),
    (100.0, "1/s", "torso_design.robust.controller.integral_gain"),
    (1.0, "", "velocity_hold.gain backward_step.decision ankle.relative_force_tolerance"),
    (1.0, "", "lean_feedback.roll lean_feedback.pitch lean_feedback.pattern_gain deviation.velocity_gain"),
    (1.0, "", "deviation.position_gain deviation.mean_gain deviation.first_mean_gain deviation.placement_gain"),
    (
        1.0,
        "",
        "fall.brace_stiffness fall.stiffness compliance.gain swing_foot_orientation.gain attitude.max_error",
    ),
    (1.0, "", "torso_design.thesis.specification.overshoot torso_design.robust.specification.overshoot"),
    (1.0, "", "torso_design.robust.specification.spread leg.start ankle.start"),
    (10.0, "", "landed_foot.gain torso_design.robust.specification.noise_gain"),
    (20.0, "", "compliance.max_ratio torso_design.robust.specification.gain_margin"),
    (50.0, "", "torso_design.thesis.specification.notch_factor"),
)
BOUNDS: Final = {name: (bound, unit) for bound, unit, names in _TABLE for name in names.split()}
"""Largest absolute value, and its unit, of each parameter by its path."""
COEFFICIENTS: Final = ("numerator", "denominator", "notch_numerator", "notch_denominator")
"""Coefficients of transfer functions, which a design computes: none of them means anything alone."""


def numbers(table: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, float]]:
    """Path and value of every number of a table of parameters; all items of a list have its path."""
    for key, value in table.items():
        own = f"{path}.{key}" if path else key
        if isinstance(value, Mapping):
            yield from numbers(value, own)
            continue
        for item in value if isinstance(value, list | tuple) else (value,):
            if isinstance(item, int | float) and not isinstance(item, bool) and key not in COEFFICIENTS:
                yield own, item


def check_bounds(parameters: Mapping[str, Any]) -> None:
    """Refuse values that no robot of this size can use.

    Args:
        parameters: the controller's, tables in tables; SI units and rad.

    Raises:
        ConfigurationError: a number beyond its bound; names it, the bound and the unit.
    """
    for path, value in numbers(parameters):
        bound, unit = BOUNDS.get(path, (math.inf, ""))
        if not abs(value) <= bound:
            quantity = f"{value:g} {unit}".strip(), f"{bound:.4g} {unit}".strip()
            raise ConfigurationError(
                f"controller: {path} is {quantity[0]}; a robot of this size takes {quantity[1]} at most."
            )


class ControllerParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the controller that may be switched or tuned, SI units and rad."""

    switches: Switches = Switches()
    """Which mechanisms are on; the tables below are read where theirs is."""
    latency: NotNegative = 0.04
    """From a command to the motion that the sensors report, s."""
    com_smoothing: Positive = 0.03
    """Time constant of the velocity of the centre of mass by the joints' motion, s; the gyroscope gives that by
    the torso's turn."""
    attitude: AttitudeParameters = AttitudeParameters()
    lean: LeanParameters = LeanParameters()
    contact: ContactParameters = ContactParameters()
    ground: GroundParameters = GroundParameters()
    deviation: DeviationParameters = DeviationParameters()
    velocity_hold: VelocityHoldParameters = VelocityHoldParameters()
    tipping: TippingParameters = TippingParameters()
    capture: CaptureParameters = CaptureParameters()
    fall: FallParameters = FallParameters()
    foresight: FallPredictorParameters = FallPredictorParameters()
    torso_design: TorsoDesigns = TorsoDesigns()
    """The designed torso controllers, from `torso.toml` of the gait or from `nao-hil design torso`."""
    torso_limits: TorsoLimits = TorsoLimits()
    damping: DampingParameters = DampingParameters()
    lean_feedback: LeanFeedbackParameters = LeanFeedbackParameters()
    compliance: JointComplianceParameters = JointComplianceParameters()
    leg: LegParameters = LegParameters()
    ankle: AnkleParameters = AnkleParameters()
    swing_foot_orientation: SwingFootOrientationParameters = SwingFootOrientationParameters()
    backward_step: BackwardStepParameters = BackwardStepParameters()
    landed_foot: LandedFootParameters = LandedFootParameters()
    touch_down: TouchDownParameters = TouchDownParameters()
    max_gap: Positive = 0.1
    """Time without an answer at the robot, beyond the usual delay, up to which the walk resumes in
    stride, s; the plan makes up for it at once. After a longer one the walk resumes from a stand."""


def controller_parameters(gait: str, changes: Mapping[str, Any] | None = None) -> ControllerParameters:
    """The controller's parameters for a gait.

    Args:
        gait: name of the gait.
        changes: values that differ from the shipped ones; tables may be given in part.

    Raises:
        ConfigurationError: unknown gait, unknown or ill-typed parameter, or a parameter outside its bounds.
    """
    shipped = msgspec.to_builtins(load_toml(gait_file(gait, "control.toml"), ControllerParameters))
    if (designs := gait_file(gait, "torso.toml")).exists():
        shipped = merged(shipped, read_toml(designs)["controller"])
    parameters = from_dict(merged(shipped, changes or {}), "controller", ControllerParameters)
    check_bounds(msgspec.to_builtins(parameters))
    return parameters


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `changes` merged over it, table by table."""
    result = dict(base)
    for key, value in changes.items():
        below = result.get(key)
        if isinstance(below, Mapping) and isinstance(value, Mapping):
            result[key] = merged(below, value)
        else:
            result[key] = value
    return result
