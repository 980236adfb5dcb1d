"""Gaits: values that turn time into planned feet, centre of mass and ZMP, step by step."""

from __future__ import annotations

from walker.gaits.catalogue import GAITS, gait_parameters, make_gait
from walker.gaits.gait import Gait, GaitCommand, dry_walk, standing_plan
from walker.gaits.plan import Plan, SolePose

__all__ = [
    "GAITS",
    "Gait",
    "GaitCommand",
    "Plan",
    "SolePose",
    "dry_walk",
    "gait_parameters",
    "make_gait",
    "standing_plan",
]
