"""Import of MuJoCo, for the modules of this package alone."""

from __future__ import annotations

import mujoco

__all__ = ["mujoco"]
