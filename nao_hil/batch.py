"""Many emulated robots in this process, stepped together: arrays in, arrays out."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from bridge.body.joints import N_JOINTS
from bridge.errors import ConfigurationError, FrameError
from bridge.guard.output import require_numbers
from bridge.messages import ActuatorFrame, SensorFrame, TruthFrame
from bridge.types import Array, Closing
from emulator.engine.catalogue import ENGINES, choose_engine
from nao_hil.arguments import UnreachableAngles, whole_seed
from nao_hil.robot import Robot


class Frames(msgspec.Struct, frozen=True, kw_only=True):
    """The newest sensor frames of N robots; each field as in `SensorFrame`, with a leading axis of N."""

    time: Array
    position: Array
    stiffness: Array
    current: Array
    temperature: Array
    fsr: Array
    accelerometer: Array
    gyroscope: Array
    angle: Array
    touch: Array
    battery: Array
    sonar: Array


class Batch(Closing):
    """N emulated robots, each with its own seed, wear and world.

    The numbers of each robot are those of a single `Robot` with the same arguments, bit for bit, in any number
    of threads.

    Example:
        ```python
        with nao_hil.Batch(range(16), wear=["nominal", "worn"] * 8) as robots:
            stand = robots.frames.position
            for _ in range(100):
                frames = robots.step(stand)
            print(frames.angle[:, 1], [truth.fell for truth in robots.truths])
        ```

    Args:
        seeds: One for each robot.
        body: Name of a body (`nao-hil robots`), or path of a data sheet.
        wear: State of drives and sensors: `ideal`, `nominal`, `worn`, `ensemble:K`, or path of a profile; one
            for all, or one for each.
        scenario: World: a name (`nao-hil scenarios`), or path of a scenario; one for all, or one for each.
        engine: `mujoco`, or `pybullet`, whose robots are stepped one after the other.
        start: Pose to begin in, as for `Robot`.
        threads: That share the robots; None: as many as robots, at most the machine's cores.

    Raises:
        ConfigurationError: no seed; a list of another length; no such body, wear profile, scenario or engine.
    """

    def __init__(
        self,
        seeds: Iterable[int],
        *,
        body: str = "nao-v3",
        wear: str | Sequence[str] = "nominal",
        scenario: str | Sequence[str] = "flat",
        engine: str = "mujoco",
        start: str | None = None,
        threads: int | None = None,
    ) -> None:
        own = _seeds(seeds)
        if not own:
            raise ConfigurationError("A batch needs at least one seed.")
        if threads is not None and (not isinstance(threads, int) or threads < 1):
            raise ConfigurationError(f"threads is {threads!r}; a whole number from 1 on is expected, or None.")
        wears, scenarios = _each("wear", wear, len(own)), _each("scenario", scenario, len(own))
        self._pool = _Pool(threads if ENGINES[choose_engine(engine)].parallel else 1, len(own))
        self._open = True
        self._unreachable = UnreachableAngles()
        made: dict[int, Robot] = {}

        def make(i: int) -> None:
            made[i] = Robot(body, seed=own[i], wear=wears[i], scenario=scenarios[i], engine=engine, start=start)

        try:
            self._pool.map(make)
        except BaseException:
            for robot in made.values():
                robot.close()
            raise
        self._robots = [made[i] for i in range(len(own))]

    def __len__(self) -> int:
        return len(self._robots)

    @property
    def threads(self) -> int:
        """That share the robots."""
        return self._pool.threads

    @property
    def cycle(self) -> float:
        """Time of one step, s."""
        return self._robots[0].cycle

    @property
    def robots(self) -> tuple[Robot, ...]:
        """The single ones; step them by the batch alone."""
        return tuple(self._robots)

    @property
    def frames(self) -> Frames:
        """The newest sensor frames."""
        return _stack([robot.frame for robot in self._robots])

    @property
    def truths(self) -> list[TruthFrame]:
        """Ground truth at the newest sensor frames."""
        return [robot.truth for robot in self._robots]

    def step(self, position: ArrayLike, stiffness: ArrayLike = 1.0, which: ArrayLike | None = None) -> Frames:
        """Run one cycle of every robot with a command.

        Args:
            position: Joint angles, rad, (N, 25), or (25,) for all robots, in the order of `nao_hil.JOINTS`;
                clipped to the joints' ranges.
            stiffness: 0..1, negative, to -1: the motor is off; a number for all joints, (25,) or (N, 25).
            which: Indices of the robots that are stepped, or N truth values; None: all. The others pause.

        Returns:
            The newest sensor frames.

        Raises:
            ConfigurationError: an array of another shape, an index that no robot or another index has, or the
                batch is closed. No robot is stepped then.
            FrameError: a number that is not finite, or a stiffness outside -1..1; likewise.
        """
        chosen = self._indices(which)
        positions, stiffnesses = self._rows("position", position), self._rows("stiffness", stiffness)
        robots = [robot.emulated for robot in self._robots]
        commands = []
        for robot, angles, stiff in zip(robots, positions, stiffnesses, strict=True):
            commands.append(ActuatorFrame(reply_to=robot.frame.seq, position=angles, stiffness=stiff))
        self._check(commands)
        # Only the physics runs in threads: elsewhere they would wait for Python's lock. And the processor has
        # each part's code at hand for all robots.
        for i in chosen:
            robots[i].skip_stalled()
            robots[i].begin_cycle(commands[i])
        self._pool.map(lambda i: robots[i].run_physics() if i in chosen else None)
        for i in chosen:
            robots[i].end_cycle()
        return self.frames

    def _rows(self, name: str, values: ArrayLike) -> list[tuple[float, ...]]:
        shape = (len(self), N_JOINTS)
        try:
            array = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError):
            raise ConfigurationError(f"{name} is no array of numbers; {shape} would be right.") from None
        if array.shape not in ((N_JOINTS,), shape) and (array.shape or name == "position"):
            right = f"{shape} or ({N_JOINTS},) would be right"
            raise ConfigurationError(f"{name} has the shape {array.shape}; {right}.")
        return [tuple(row) for row in np.broadcast_to(array, shape).tolist()]

    def _check(self, commands: list[ActuatorFrame]) -> None:
        """Before any robot is stepped."""
        for i, command in enumerate(commands):
            try:
                require_numbers(command)
            except FrameError as error:
                raise FrameError(f"Robot {i}: {error}") from None
            self._unreachable.warn(command.position)

    def _indices(self, which: ArrayLike | None) -> list[int]:
        """Indices of the robots that are meant, each once, in their order."""
        if not self._open:
            raise ConfigurationError("This batch is closed; make a new one.")
        n = len(self)
        if which is None:
            return list(range(n))
        try:
            given = np.asarray(list(which) if isinstance(which, Iterable) else which)
        except ValueError:
            given = np.zeros(())
        if given.dtype == np.bool_ and given.shape == (n,):
            return [i for i in range(n) if given[i]]
        whole = given.ndim == 1 and (given.size == 0 or given.dtype.kind in "iu")
        if not whole or len(set(given.tolist())) < given.size or not all(0 <= i < n for i in given.tolist()):
            raise ConfigurationError(
                f"which is {which!r}; different indices from 0 to {n - 1} are expected, or {n} truth values."
            )
        return [int(i) for i in given.tolist()]

    def reset(self, seeds: Iterable[int] | None = None, which: ArrayLike | None = None) -> Frames:
        """Restart at time 0.

        Args:
            seeds: One for each robot that restarts; None: the same as before.
            which: Indices of these robots, or N truth values; None: all.

        Returns:
            The first sensor frames of these, the newest of all others.

        Raises:
            ConfigurationError: not one seed for each robot, or as `step`. No robot restarts then.
        """
        chosen = self._indices(which)
        own = None if seeds is None else _seeds(seeds)
        if own is not None and len(own) != len(chosen):
            raise ConfigurationError(f"{len(own)} seeds for {len(chosen)} robots; give one for each.")
        wanted: dict[int, int | None] = dict.fromkeys(chosen)
        if own is not None:
            wanted.update(zip(chosen, own, strict=True))
        self._pool.map(lambda i: self._robots[i].reset(wanted[i]) if i in wanted else None)
        return self.frames

    def close(self) -> None:
        """Free the physics engines; may be called twice."""
        self._open = False
        for robot in self._robots:
            robot.close()
        self._pool.close()


def _seeds(values: Iterable[int]) -> list[int]:
    if not isinstance(values, Iterable):
        raise ConfigurationError(f"seeds is {values!r}; one for each robot is expected, such as range(16).")
    return [whole_seed(value) for value in values]


def _each(name: str, value: str | Sequence[str], n: int) -> list[str]:
    if not isinstance(value, Iterable):
        raise ConfigurationError(f"{name} is {value!r}; a name is expected, or one for each of {n} robots.")
    values = [value] * n if isinstance(value, str) else list(value)
    if len(values) != n:
        raise ConfigurationError(f"{name} has {len(values)} values for {n} seeds; give one, or one for each.")
    return values


def _stack(frames: Sequence[SensorFrame]) -> Frames:
    fields: dict[str, Any] = {
        name: np.array([getattr(frame, name) for frame in frames]) for name in Frames.__struct_fields__
    }
    return Frames(**fields)


class _Pool:
    """Threads that share N tasks, the caller's own among them: each takes the next one when it is free."""

    def __init__(self, threads: int | None, tasks: int) -> None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        self.threads = max(1, min(cores if threads is None else threads, tasks))
        self._tasks = tasks
        self._executor = ThreadPoolExecutor(max(1, self.threads - 1))

    def map(self, work: Callable[[int], Any]) -> list[Any]:
        """`work` of 0 to N - 1."""
        results: list[Any] = [None] * self._tasks
        remaining = iter(range(self._tasks))

        def run() -> None:
            for i in remaining:
                results[i] = work(i)

        others = [self._executor.submit(run) for _ in range(self.threads - 1)]
        try:
            run()
        finally:
            wait(others)
        for other in others:
            other.result()
        return results

    def close(self) -> None:
        self._executor.shutdown()
