"""How each named plot is drawn; figures are made without pyplot, so nothing is global."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from matplotlib.figure import Figure

from nao_hil.analysis.plots.balance_figures import com, margin, path, plane, torso, zmp
from nao_hil.analysis.plots.motion_figures import (
    admittance,
    cells,
    control,
    current,
    cycle,
    error,
    fsr,
    imu,
    joints,
)
from nao_hil.analysis.plots.tables import Tables

FIGURES: Final[dict[str, tuple[Callable[[Tables, Figure], None], tuple[float, float], tuple[str, ...]]]] = {
    "torso": (torso, (10.0, 6.0), ("sensors",)),
    "zmp": (zmp, (10.0, 6.0), ("telemetry",)),
    "plane": (plane, (10.0, 5.0), ("telemetry",)),
    "margin": (margin, (10.0, 4.0), ("telemetry",)),
    "com": (com, (10.0, 6.0), ("telemetry",)),
    "fsr": (fsr, (10.0, 5.0), ("sensors",)),
    "cells": (cells, (10.0, 6.0), ("sensors",)),
    "admittance": (admittance, (10.0, 7.0), ("telemetry",)),
    "control": (control, (10.0, 6.0), ("telemetry",)),
    "joints": (joints, (11.0, 9.0), ("sensors",)),
    "error": (error, (11.0, 9.0), ("sensors", "actuators")),
    "current": (current, (10.0, 6.0), ("sensors",)),
    "imu": (imu, (10.0, 6.0), ("sensors",)),
    "path": (path, (10.0, 4.0), ()),
    "cycle": (cycle, (10.0, 5.0), ("sensors",)),
}
"""Name -> how it is drawn, its size in inches, and the messages without which there is nothing to draw."""
