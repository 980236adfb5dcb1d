"""Gaits: each a phase machine that turns time into planned feet, centre of mass and ZMP."""

from walker.gait.catalogue import GAITS, gait_parameters, make_gait
from walker.gait.reference import Foot, Gait, Reference

__all__ = ["GAITS", "Foot", "Gait", "Reference", "gait_parameters", "make_gait"]
