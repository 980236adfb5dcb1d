"""The named plots of a recording; their names without matplotlib, so that help and completion stay quick."""

from __future__ import annotations

from typing import Final

PLOTS: Final[dict[str, str]] = {
    "torso": "roll, pitch and heading: fused angle, the walker's, ground truth",
    "zmp": "ZMP over time: planned, from the foot sensors, ground truth",
    "plane": "seen from above: footprints, planned ZMP and centre of mass, measured ZMP",
    "margin": "distance of the ZMP to the edge of the support polygon",
    "com": "centre of mass: planned and ground truth",
    "fsr": "sums of both feet's force sensors, and contacts",
    "cells": "the eight force sensors",
    "admittance": "lift of the feet, and the angles of ankle admittances and swing-foot orientation control",
    "control": "the torso control's angles of the ankles, and the torso's pitch",
    "joints": "leg joints: commanded and measured",
    "error": "leg joints: measured minus commanded",
    "current": "motor currents and temperatures of the legs",
    "imu": "accelerometer and gyroscope",
    "path": "path over ground: the torso's, and the plan's odometry",
    "cycle": "age of the command in force, and cycles missed",
}
"""Name -> content."""
