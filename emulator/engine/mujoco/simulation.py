"""MuJoCo's model and state, compiled anew when something is added to the world or taken away."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from bridge.types import Vec3
from emulator.compiled import compiled
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.native import mj_com_pos, mj_kinematics
from emulator.engine.values import PhysicsSettings

_NO_MIDPHASE: Final = int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)
_FEW: Final = 32
"""Geoms of a body up to which looking at each is faster than a tree of them."""


def _leave(_: Any) -> None:
    """The model stays as the compiler made it."""


@compiled
def _place_bodies(model: int, data: int) -> None:
    """Compute the poses of bodies and geoms; so short that Python's lock is kept.

    Args:
        model: Address of MuJoCo's model.
        data: Address of its state.
    """
    mj_kinematics(model, data)
    mj_com_pos(model, data)


class Simulation:
    """A description of the world, and what MuJoCo makes of it when it is needed.

    Args:
        settings: Of the physics.
    """

    def __init__(self, settings: PhysicsSettings) -> None:
        self.settings = settings
        self.spec = mujoco.MjSpec()
        """The description; call `changed` after a change."""
        self.spec.compiler.degree = False
        option = self.spec.option
        option.timestep = settings.step
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        # a sole's contacts move the joints of one leg: sparse takes two thirds of the time of dense
        option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
        # robot and floor are one island, which need not be searched for
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
        # Newton's own tolerance decides, not that of the search along a line
        option.ls_tolerance = 0.1
        # friction harder than the springs of a soft floor, so that a sole hardly creeps
        option.impratio = 1000.0
        self.tune: Callable[[Any], None] = _leave
        """Called with each model that was compiled anew, for what depends on the compiler's results."""
        self._starts: dict[str, float] = {}
        self._stale, self._moved = True, True
        self._model: Any = None
        self._data: Any = None
        self.set_gravity((0.0, 0.0, -settings.gravity))
        self.version = 0
        """Counts the compilations: addresses in model and data hold for one of them."""

    def changed(self) -> None:
        """The description is another one; the state of what is left stays."""
        self._stale = True

    def start_at(self, joint: str, position: float) -> None:
        """Give a joint that is not compiled yet an angle other than 0.

        Args:
            joint: Name in the description.
            position: rad.
        """
        self._starts[joint] = position
        self.changed()

    def _compile(self) -> None:
        if self._model is None:
            self._model = self.spec.compile()
            self._data = mujoco.MjData(self._model)
        else:
            self._model, self._data = self.spec.recompile(self._model, self._data)
        self._choose_midphase()
        self.tune(self._model)
        for joint, position in self._starts.items():
            self._data.joint(joint).qpos = position
        self._starts.clear()
        self.version += 1
        self._stale, self._moved = False, True

    def _choose_midphase(self) -> None:
        """Use MuJoCo's tree of geoms only for bodies with many, such as a field of tiles."""
        self._model.opt.disableflags &= ~_NO_MIDPHASE
        if self._model.body_geomnum.max() <= _FEW:
            self._model.opt.disableflags |= _NO_MIDPHASE

    @property
    def model(self) -> Any:
        """MuJoCo's model."""
        if self._stale:
            self._compile()
        return self._model

    @property
    def data(self) -> Any:
        """MuJoCo's state; poses and velocities of bodies may be those of a step ago."""
        if self._stale:
            self._compile()
        return self._data

    def bring_up_to_date(self) -> None:
        """Compute the poses of all bodies and geoms as they are now."""
        data = self.data
        if self._moved:
            _place_bodies(self._model._address, data._address)
            self._moved = False

    @property
    def now(self) -> Any:
        """MuJoCo's state with the poses of all bodies and geoms as they are now."""
        self.bring_up_to_date()
        return self._data

    def moved(self) -> None:
        """Something was put elsewhere: poses of bodies must be computed again."""
        self._moved = True

    def step(self) -> None:
        """One time step."""
        mujoco.mj_step(self.model, self.data)
        self._moved = True

    def set_gravity(self, gravity: Vec3) -> None:
        """World frame, m/s^2."""
        self.spec.option.gravity = gravity
        if self._model is not None:
            self._model.opt.gravity[:] = gravity
