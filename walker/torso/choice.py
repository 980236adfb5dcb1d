"""The torso controller that a configuration asks for; each design is made once per process."""

from __future__ import annotations

import functools
import logging
from typing import Literal

import control

from walker.parameters.model import TorsoDesignParameters
from walker.torso.controller import TorsoController
from walker.torso.design import Specification, TorsoDesign, thesis_design
from walker.torso.robust import robust_design

logger = logging.getLogger(__name__)


@functools.lru_cache(maxsize=8)
def torso_design(
    method: Literal["thesis", "robust"], parameters: TorsoDesignParameters, cycle: float
) -> TorsoDesign:
    """Design the torso controller.

    Args:
        method: of the design.
        parameters: plant and specification.
        cycle: sample time, s.

    Raises:
        ConfigurationError: the plant or the specification cannot be met; says why.
    """
    logger.info("designing the torso controller (%s)", method)
    plant = control.tf(list(parameters.plant_numerator), list(parameters.plant_denominator))
    if method == "robust":
        return robust_design(plant, sample_time=cycle)
    specification = Specification(parameters.rise_time, parameters.overshoot, parameters.notch_factor)
    return thesis_design(plant, specification, cycle)


def torso_controller(
    method: Literal["thesis", "robust"], parameters: TorsoDesignParameters, cycle: float
) -> TorsoController:
    """As `torso_design`, the numbers for the run-time filter only."""
    return torso_design(method, parameters, cycle).controller
