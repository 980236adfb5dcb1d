"""Parameters of the controller: what of it is on, and every number that it does not take from the gait."""

from walker.parameters.catalogue import controller_parameters
from walker.parameters.model import (
    ContactParameters,
    ControllerParameters,
    FallParameters,
    TorsoDesignParameters,
    TorsoMethod,
    TouchDownParameters,
)

__all__ = [
    "ContactParameters",
    "ControllerParameters",
    "FallParameters",
    "TorsoDesignParameters",
    "TorsoMethod",
    "TouchDownParameters",
    "controller_parameters",
]
