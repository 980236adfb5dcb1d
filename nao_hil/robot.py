"""The emulated robot in this process: a command in, a sensor frame out; and a whole walk with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.body import load_body
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, TruthFrame
from bridge.recording.recorder import Recorder
from bridge.types import Closing
from emulator.engine.values import PinholeCamera
from emulator.robot import EmulatedRobot
from nao_hil.arguments import (
    JointValues,
    UnreachableAngles,
    actuator_frame,
    file_path,
    require_names,
    whole_seed,
)
from nao_hil.runs.build import build_robot, check_run, with_engine
from nao_hil.runs.config import run_config
from nao_hil.runs.folder import robot_scene
from nao_hil.runs.in_process import walk_in_process
from nao_hil.runs.summary import Summary

MAX_PIXELS: Final = 4096
"""Most pixels of a picture's width and height."""


class Robot(Closing):
    """An emulated robot that this process steps; close it, or use it as a context manager.

    It starts in its standing posture with full stiffness. The same seed gives the same frames, bit for bit.

    Example:
        ```python
        with nao_hil.Robot("nao-v6", seed=1) as robot:
            stand = robot.frame.position
            for _ in range(100):
                frame = robot.step(stand, 0.8)
            print(frame.time, robot.truth.com)
        ```

    Args:
        body: Name of a body (`nao-hil robots`), or path of a data sheet.
        seed: Of everything random.
        wear: State of drives and sensors: `ideal`, `nominal`, `worn`, `ensemble:K`, or path of a profile.
        scenario: World: a name (`nao-hil scenarios`), or path of a scenario.
        engine: Physics, `pybullet` or `mujoco`; `auto`: PyBullet where it is installed, else MuJoCo.
        start: Pose to begin in: `stand`, `sit`, `crouch`, `lie-back`, `lie-front`, `lie-side`, `hang`; None:
            the scenario's.

    Raises:
        ConfigurationError: no such body, wear profile, scenario, engine or pose, or an engine that is not
        installed.
    """

    def __init__(
        self,
        body: str = "nao-v3",
        *,
        seed: int = 0,
        wear: str = "nominal",
        scenario: str = "flat",
        engine: str = "auto",
        start: str | None = None,
    ) -> None:
        require_names(body=body, wear=wear, scenario=scenario, engine=engine)
        settings = run_config(
            None, robot=body, seed=whole_seed(seed), wear=wear, scenario=scenario, engine=engine, start=start
        )
        self._config = with_engine(settings)
        self._robot = build_robot(self._config)
        self._open = True
        self._unreachable = UnreachableAngles()

    @property
    def emulated(self) -> EmulatedRobot:
        """The robot with all its parts; another one after a reset."""
        return self._robot

    @property
    def body(self) -> str:
        """Name of the body."""
        return self._robot.body.name

    @property
    def engine(self) -> str:
        """Name of the physics engine."""
        return self._config.engine

    @property
    def cycle(self) -> float:
        """Time of one step, s."""
        return self._robot.body.cycle

    @property
    def frame(self) -> SensorFrame:
        """The newest sensor frame."""
        return self._robot.frame

    @property
    def truth(self) -> TruthFrame:
        """Ground truth at the newest sensor frame."""
        return self._robot.truth()

    def picture(self, width: int = 320, height: int = 240) -> NDArray[np.uint8]:
        """The robot from ahead and its left, (height, width, 3), RGB.

        Args:
            width: Pixels, 1 to 4096.
            height: Likewise.

        Raises:
            ConfigurationError: the engine cannot draw on this machine; another size; the robot is closed.
        """
        self._require_open()
        for name, size in (("width", width), ("height", height)):
            if not isinstance(size, int) or not 1 <= size <= MAX_PIXELS:
                raise ConfigurationError(
                    f"{name} is {size!r}; whole pixels from 1 to {MAX_PIXELS} are expected."
                )
        x, y, z = self._robot.multibody.state().position
        return self._robot.engine.picture(
            PinholeCamera((x + 1.0, y + 0.7, z + 0.3), (x, y, z), width, height, 0.8)
        )

    def reset(self, seed: int | None = None) -> SensorFrame:
        """Restart at time 0.

        Args:
            seed: Of everything random; None: the same as before.

        Returns:
            The first sensor frame.

        Raises:
            ConfigurationError: a seed that is no whole number from 0 on; the robot is closed.
        """
        self._require_open()
        if seed is not None:
            self._config = msgspec.structs.replace(self._config, seed=whole_seed(seed))
        self._robot.close()
        self._robot = build_robot(self._config)
        return self.frame

    def step(self, position: JointValues | None = None, stiffness: JointValues = 1.0) -> SensorFrame:
        """Run one cycle with a command.

        Args:
            position: Joint angles, rad, 25 in the order of `nao_hil.JOINTS`, clipped to the joints' ranges;
                None: the last command holds.
            stiffness: 0..1, 25 or one for all joints; negative, to -1: the motor is off.

        Returns:
            The sensor frame at the end of the cycle.

        Raises:
            ConfigurationError: not 25 numbers; the robot is closed.
            FrameError: a number that is not finite, or a stiffness outside -1..1.
        """
        self._require_open()
        command = None if position is None else actuator_frame(self.frame.seq, position, stiffness)
        if command is not None:
            self._unreachable.warn(command.position)
        return self._robot.advance(command)

    def _require_open(self) -> None:
        if not self._open:
            raise ConfigurationError("This robot is closed; make a new one.")

    def close(self) -> None:
        """Free the physics engine; may be called twice."""
        self._open = False
        self._robot.close()


def walk(
    gait: str = "omni",
    *,
    body: str = "nao-v3",
    seed: int = 0,
    wear: str = "nominal",
    scenario: str = "flat",
    engine: str = "auto",
    steps: int | None = None,
    duration: float | None = None,
    torso: str | None = None,
    parameters: dict[str, Any] | None = None,
    record: str | Path | None = None,
) -> Summary:
    """Walk an emulated robot in this process, as fast as it computes.

    Example:
        ```python
        summary = nao_hil.walk("dynamic", seed=3, steps=20, record="walk.mcap")
        print(summary.fell, summary.distance)
        ```

    Args:
        gait: A name of `nao-hil gaits`.
        body: Name of a body (`nao-hil robots`), or path of a data sheet.
        seed: Of everything random.
        wear: State of drives and sensors: `ideal`, `nominal`, `worn`, `ensemble:K`, or path of a profile.
        scenario: World: a name (`nao-hil scenarios`), or path of a scenario.
        engine: Physics, `pybullet` or `mujoco`; `auto`: PyBullet where it is installed, else MuJoCo.
        steps: Steps to walk, the closing one included; None: 10, or no bound with a duration.
        duration: Time to walk, s; None: no bound.
        torso: Torso control: `none`, `thesis` or `robust`; None: the gait's own.
        parameters: Parameters of the gait that differ from the shipped ones.
        record: File to record the run in (.mcap); None: no recording.

    Raises:
        ConfigurationError: a wrong option, a walk without a bound, or parameters that cannot be walked.
    """
    options: dict[str, Any] = {"steps": steps, "duration": duration, "torso": torso, "parameters": parameters}
    options |= {"wear": wear, "scenario": scenario, "engine": engine}
    require_names(gait=gait, body=body, wear=wear, scenario=scenario, engine=engine)
    file = None if record is None else file_path("record", record)
    settings = with_engine(run_config(None, robot=body, gait=gait, seed=whole_seed(seed), **options))
    if not settings.steps and not settings.duration:
        raise ConfigurationError("A walk in this process needs an end; give steps or duration.")
    if file is None:
        return walk_in_process(settings)
    check_run(settings)  # before an existing file is overwritten
    with Recorder(file, settings, robot_scene(load_body(settings.robot))) as recorder:
        return walk_in_process(settings, [recorder])
