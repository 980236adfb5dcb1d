"""Admittance of the swing leg and its ankle (thesis 4.1): the foot yields to the ground it meets."""

from walker.admittance.ankle import AnkleAdmittance, AnkleLimits, AnkleParameters, sole_moment
from walker.admittance.leg import LegAdmittance, LegParameters
from walker.admittance.phases import Role

__all__ = [
    "AnkleAdmittance",
    "AnkleLimits",
    "AnkleParameters",
    "LegAdmittance",
    "LegParameters",
    "Role",
    "sole_moment",
]
