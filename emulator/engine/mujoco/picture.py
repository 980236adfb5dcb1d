"""Pictures of a simulation, drawn without a window."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bridge.errors import ConfigurationError
from emulator.engine.mujoco.client import mujoco
from emulator.engine.values import PinholeCamera


class Painter:
    """Draws one simulation at a time; holds a graphics context until `close`."""

    def __init__(self) -> None:
        self._context: Any = None
        self._size = (0, 0)

    def draw(self, model: Any, data: Any, camera: PinholeCamera) -> NDArray[np.uint8]:
        """A picture, (height, width, 3), RGB.

        Raises:
            ConfigurationError: this machine has no EGL, with which MuJoCo draws.
        """
        size = (camera.width, camera.height)
        if self._size != size:
            self.close()
            self._open(*size)
        model.vis.global_.offwidth, model.vis.global_.offheight = size
        model.vis.global_.fovy = math.degrees(camera.field_of_view)
        eye = mujoco.MjvCamera()
        eye.type = mujoco.mjtCamera.mjCAMERA_FREE
        way = np.subtract(camera.target, camera.eye)
        eye.lookat[:], eye.distance = camera.target, float(np.linalg.norm(way))
        eye.azimuth = math.degrees(math.atan2(way[1], way[0]))
        eye.elevation = math.degrees(math.atan2(way[2], math.hypot(way[0], way[1])))
        scene, picture = mujoco.MjvScene(model, maxgeom=2000), np.zeros((*size[::-1], 3), dtype=np.uint8)
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, eye, everything, scene)
        render = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, render)
        view = mujoco.MjrRect(0, 0, *size)
        mujoco.mjr_render(view, scene, render)
        mujoco.mjr_readPixels(picture, None, view, render)
        render.free()
        return np.ascontiguousarray(picture[::-1])

    def _open(self, width: int, height: int) -> None:
        try:
            from mujoco.egl import GLContext

            self._context = GLContext(width, height)
        except (ImportError, AttributeError, RuntimeError, OSError) as error:
            raise ConfigurationError(
                "MuJoCo cannot draw: this machine has no EGL (libegl1). --engine pybullet draws without."
            ) from error
        self._context.make_current()
        self._size = (width, height)

    def close(self) -> None:
        """Free the graphics context; harmless when called twice."""
        if self._context is not None:
            self._context.free()
        self._context, self._size = None, (0, 0)
