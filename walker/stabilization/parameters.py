"""Parameters of the controller: which mechanisms are on, and every number that is not the gait's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from bridge.config import from_dict, load_toml, read_toml
from bridge.types import Positive
from walker.estimation.estimator import EstimatorParameters
from walker.estimation.support_state import TouchDownParameters
from walker.planning.catalogue import gait_file
from walker.stabilization.admittance import AnkleParameters, LegParameters
from walker.stabilization.arm_counterweight import ArmCounterweightParameters
from walker.stabilization.bounds import check_bounds
from walker.stabilization.hip_bend import HipBendParameters
from walker.stabilization.joint_compliance import JointComplianceParameters
from walker.stabilization.landed_foot import LandedFootParameters
from walker.stabilization.swing_foot import SwingFootOrientationParameters
from walker.stabilization.switches import Switches
from walker.stabilization.torso.designs import TorsoDesigns
from walker.stabilization.torso.filter import TorsoLimits
from walker.stabilization.torso.stance_ankle import DampingParameters, LeanFeedbackParameters


class ControllerParameters(EstimatorParameters, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything of the controller that may be switched or tuned, SI units and rad."""

    switches: Switches = Switches()
    """Which mechanisms are on; the tables below are read where theirs is."""
    torso_design: TorsoDesigns = TorsoDesigns()
    """The designed torso controllers, from `torso.toml` of the gait or from `nao-hil design torso`."""
    torso_limits: TorsoLimits = TorsoLimits()
    damping: DampingParameters = DampingParameters()
    lean_feedback: LeanFeedbackParameters = LeanFeedbackParameters()
    compliance: JointComplianceParameters = JointComplianceParameters()
    leg: LegParameters = LegParameters()
    ankle: AnkleParameters = AnkleParameters()
    swing_foot_orientation: SwingFootOrientationParameters = SwingFootOrientationParameters()
    hip_bend: HipBendParameters = HipBendParameters()
    landed_foot: LandedFootParameters = LandedFootParameters()
    arm_counterweight: ArmCounterweightParameters = ArmCounterweightParameters()
    touch_down: TouchDownParameters = TouchDownParameters()
    max_gap: Positive = 0.1
    """Time without an answer that reached the robot, beyond the usual delay, after which the walk goes
    on in stride, s; the plan makes up for it at once. After a longer one the walk goes on from a stand."""


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
    """`base` with `changes` laid over it, table by table."""
    result = dict(base)
    for key, value in changes.items():
        below = result.get(key)
        if isinstance(below, Mapping) and isinstance(value, Mapping):
            result[key] = merged(below, value)
        else:
            result[key] = value
    return result
