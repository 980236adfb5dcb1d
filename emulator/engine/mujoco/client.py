"""Import of MuJoCo, for the modules of this package alone."""

from __future__ import annotations

import mujoco
from mujoco.introspect import ast_nodes, structs

__all__ = ["ast_nodes", "mujoco", "structs"]
