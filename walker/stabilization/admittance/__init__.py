"""Admittance of the swing leg and its ankle (thesis 4.1): the foot yields to the ground it meets."""

from walker.stabilization.admittance.ankle import AnkleAdmittance, AnkleLimits, AnkleParameters, sole_moment
from walker.stabilization.admittance.leg import LegAdmittances, LegParameters

__all__ = [
    "AnkleAdmittance",
    "AnkleLimits",
    "AnkleParameters",
    "LegAdmittances",
    "LegParameters",
    "sole_moment",
]
