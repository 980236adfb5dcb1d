"""Several emulated robots in one world, stepped in this process, with walkers of this project or without."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, TypeAlias, cast

import msgspec
import numpy as np

from bridge.adapters.gamecontroller.referee import Referee, load_schedule
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, TruthFrame
from bridge.messages.frames import Name
from bridge.messages.game import MAX_PLAYERS, Byte, PlayerNumber
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.messages.world import Pause, Reset, Resume, Status, Step, WorldCommand, require_command
from bridge.messages.world_state import WorldObject
from bridge.types import Closing, Vec3
from bridge.validation import unknown_name
from emulator.engine.settings import SETTINGS
from emulator.queries import carry_out
from emulator.robot import EmulatedRobot, rebuilt
from emulator.scenarios import load_scenario
from emulator.start import build_world
from emulator.world.world import World as EmulatedWorld
from nao_hil.arguments import JointValues, actuator_frame, file_path, require_names, whole_seed
from nao_hil.runs.build import build_robot, with_engine
from nao_hil.runs.config import run_config
from nao_hil.runs.neighbours import LocalWalker
from walker.service import WalkService

_OF_THE_CLOCK: Final = (Status, Pause, Resume, Step)
Command: TypeAlias = "JointValues | tuple[JointValues, JointValues]"
"""Joint angles, rad, 25 in the order of `nao_hil.JOINTS`; or a pair of these and stiffnesses, 25 or one."""


class WorldTruth(msgspec.Struct, frozen=True, kw_only=True):
    """Ground truth of a world."""

    time: float
    """Time of the world, s."""
    robots: dict[str, TruthFrame]
    """By name."""
    objects: dict[str, WorldObject]
    """By name."""


class World(Closing):
    """Robots that share physics, clock, floor and objects; close it, or use it as a context manager.

    Robots are added before the first step, walker or frames, and all of them run in step with it. Their bodies
    have one cycle time: a V6 (12 ms) shares no world with an older robot (10 ms). The same calls give the same
    frames, bit for bit, and a robot alone those of `nao_hil.Robot`.

    Example:
        ```python
        with nao_hil.World(engine="mujoco") as world:
            world.add("nao-v6", name="red", seed=1)
            world.add("nao-v6", name="blue", seed=2, at=(1.0, 0.0, 3.14))
            stand = world.frames["red"].position
            for _ in range(100):
                frames = world.step({"red": stand, "blue": (stand, 0.8)})
            print(world.truth.robots["blue"].torso_position)
        ```

    Args:
        scenario: Floor and objects: a name (`nao-hil scenarios`), or path of a scenario. Its events and faults
            concern the robot that they name, without a name the one that is added first.
        engine: Physics, `pybullet` or `mujoco`; `auto`: PyBullet where it is installed, else MuJoCo.
        seed: Of the world's terrain.
        game: Schedule of a game of the league (TOML) for a referee on the world's time; None: there is no game.

    Raises:
        ConfigurationError: no such scenario or engine, an engine that is not installed, or a wrong schedule.
    """

    def __init__(
        self, scenario: str = "flat", *, engine: str = "auto", seed: int = 0, game: str | Path | None = None
    ) -> None:
        require_names(scenario=scenario, engine=engine)
        self._config = with_engine(run_config(None, seed=whole_seed(seed), scenario=scenario, engine=engine))
        self._scenario = load_scenario(scenario)
        self._world: EmulatedWorld = build_world(
            self._config.engine, SETTINGS, self._scenario, self._config.seed
        )
        if game is not None:
            self._world.referee = Referee(load_schedule(file_path("game", game)), sends=False)
        self._robots: dict[str, EmulatedRobot] = {}
        self._walkers: dict[str, LocalWalker] = {}
        self._running, self._open = False, True

    def add(
        self,
        body: str = "nao-v3",
        *,
        name: str,
        seed: int = 0,
        wear: str = "nominal",
        start: str | None = None,
        at: tuple[float, float, float] | None = None,
        player: tuple[int, int] | None = None,
    ) -> None:
        """Add a robot.

        Args:
            body: Name of a body (`nao-hil robots`), or path of a data sheet.
            name: A new one.
            seed: Of everything random in it.
            wear: State of drives and sensors: `ideal`, `nominal`, `worn`, `ensemble:K`, or path of a profile.
            start: Pose to begin in, as for `nao_hil.Robot`.
            at: Place on the floor, x and y in m, and heading, rad; None: the scenario's.
            player: Number of its team (0 to 255) and its own there (1 to 20), in the league's games.

        Raises:
            ConfigurationError: no such body, wear profile or pose; a name that is taken; another cycle time
                than the others'; no room there; the world has begun.
        """
        require_names(body=body, name=name, wear=wear)
        try:
            msgspec.convert(name, Name)
        except msgspec.ValidationError:
            raise ConfigurationError(
                f"name is {name!r}; 1 to 64 letters, digits, `_` or `-` are expected."
            ) from None
        self._require_open()
        if self._running:
            raise ConfigurationError(
                "The world has begun, with its first step, walker or frames; add all robots before that."
            )
        settings: dict[str, Any] = {"robot": body, "seed": whole_seed(seed), "wear": wear, "start": start}
        config = run_config(None, **settings, scenario=self._config.scenario, engine=self._config.engine)
        place = None if at is None else _place(at)
        try:
            self._robots[name] = build_robot(
                config, self._scenario, name=name, at=place, player=_player(player), world=self._world
            )
        except ConfigurationError:  # it may be in the physics already
            self._world = rebuilt(self._world, list(self._robots.values()))
            raise

    def _start(self) -> None:
        self._require_open()
        if not self._robots:
            raise ConfigurationError("The world has no robot; add one.")
        if not self._running:
            self._world.start()
            self._running = True

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the robots, in the order in which they were added."""
        return tuple(self._robots)

    @property
    def cycle(self) -> float:
        """Time of one step, s."""
        self._start()
        return self._world.robots[0].body.cycle

    @property
    def frames(self) -> dict[str, SensorFrame]:
        """The newest sensor frame of each robot."""
        self._start()
        return {name: robot.frame for name, robot in self._robots.items()}

    @property
    def truth(self) -> WorldTruth:
        """Ground truth at the newest sensor frames."""
        self._start()
        first = next(iter(self._robots.values()))
        return WorldTruth(
            time=first.world_time,
            robots={name: robot.truth() for name, robot in self._robots.items()},
            objects={thing.name: thing for thing in self._world.object_states()},
        )

    def step(self, commands: Mapping[str, Command] | None = None) -> dict[str, SensorFrame]:
        """Run one cycle of all robots.

        Args:
            commands: By the robot's name; without one, its walker answers, or the last one holds.

        Returns:
            The sensor frame of each robot at the end of the cycle; of one whose DCM stands still, the last.

        Raises:
            ConfigurationError: no such robot, or not 25 numbers. No robot is stepped then.
            FrameError: a number that is not finite, or a stiffness outside -1..1; likewise.
        """
        self._start()
        if not isinstance(commands, (Mapping, type(None))):
            raise ConfigurationError(
                f"commands is a {type(commands).__name__}; a dict by the robot's name is expected."
            )
        given = {}
        for name, command in (commands or {}).items():
            pair = isinstance(command, tuple) and len(command) == 2
            position, stiffness = cast("tuple[JointValues, JointValues]", command if pair else (command, 1.0))
            given[name] = actuator_frame(self._robot(name).frame.seq, position, stiffness)
        for name, walker in self._walkers.items():
            if name not in given and (answer := walker.answer()) is not None:
                given[name] = answer
        self._world.advance(given)
        return self.frames

    def add_walker(self, name: str, gait: str = "omni", *, recover: bool = True) -> None:
        """Give a robot the walker of this project, which stands until `order`.

        Args:
            name: Of the robot.
            gait: To begin with: a name of `nao-hil gaits`, or `onnx:SHEET`.
            recover: It gets up after a fall.

        Raises:
            ConfigurationError: no such robot or gait, a gait that this body cannot walk, or a robot that has a
                walker.
        """
        self._start()
        require_names(gait=gait)
        if name in self._walkers:
            raise ConfigurationError(
                f"Robot `{name}` has a walker already; `order` tells it to walk by a gait."
            )
        self._walkers[name] = LocalWalker(self._robot(name), WalkService(gait, recover=recover))

    def order(self, name: str, command: WalkCommand) -> WalkStatus:
        """Order a robot's walker to walk, stop or play a motion, in force from the next cycle.

        Args:
            name: Of the robot.
            command: As `nao_hil.WalkClient.send` takes it.

        Returns:
            State of the walker.

        Raises:
            ConfigurationError: no such robot, or one without a walker.
            WalkRefused: its own sentence, which names the bound.
        """
        robot = self._robot(name)
        if name not in self._walkers:
            raise ConfigurationError(f"Robot `{robot.name}` has no walker; give it one by `add_walker`.")
        return self._walkers[name].order(command)

    def send(self, command: WorldCommand, name: str | None = None) -> str:
        """Carry out a command to the world, as `WorldClient` sends it, between two steps.

        Args:
            command: Of `bridge.messages.world`, but for those of the clock and the reset of the world.
            name: Robot that it concerns; None: the first.

        Returns:
            The act, in one sentence.

        Raises:
            ConfigurationError: no such robot, or a command of the clock.
            FrameError: no command, or not possible in this world, which then is as before.
        """
        self._start()
        require_command(command)
        if isinstance(command, _OF_THE_CLOCK) or (isinstance(command, Reset) and command.scope == "world"):
            raise ConfigurationError(
                f"{type(command).__name__} is for a robot on the link; here `step`, `reset` and `truth` serve."
            )
        return carry_out(self._robot(name or self.names[0]), command)

    def _robot(self, name: str) -> EmulatedRobot:
        if not isinstance(name, str) or name not in self._robots:
            raise ConfigurationError(unknown_name("robot", name, self._robots))
        return self._robots[name]

    def reset(self, name: str | None = None) -> dict[str, SensorFrame]:
        """Restart the world with the same robots and seeds, or one robot alone.

        Args:
            name: Robot that begins again at its start, with `seq` 0, its seed and no faults, while the others,
                the time of the world and its objects go on; None: all robots, and objects that came later are
                gone.

        Returns:
            The newest sensor frames, of robots that begin again the first.

        Raises:
            ConfigurationError: no such robot.
            FrameError: something fixed or another robot is in its place.
        """
        self._start()
        if name is not None:
            self._robot(name).restart()
        else:
            self._world = rebuilt(self._world, list(self._robots.values()))
            self._world.start()
        for each, walker in self._walkers.items():
            if name in (each, None):
                walker.restart()
        return self.frames

    def _require_open(self) -> None:
        if not self._open:
            raise ConfigurationError("This world is closed; make a new one.")

    def close(self) -> None:
        """Free the physics engine; may be called twice."""
        self._open = False
        self._world.engine.close()


def _player(player: tuple[int, int] | None) -> tuple[int, int] | None:
    try:
        return msgspec.convert(player, tuple[Byte, PlayerNumber] | None)
    except msgspec.ValidationError:
        raise ConfigurationError(
            f"player is {player!r}; a team's number of 0 to 255 and the player's of 1 to {MAX_PLAYERS} in it "
            "are expected."
        ) from None


def _place(at: tuple[float, float, float]) -> Vec3:
    try:
        place = np.asarray(at, dtype=np.float64)
    except (TypeError, ValueError):
        place = np.empty(0)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ConfigurationError(f"at is {at!r}; x and y in m and a heading in rad are expected.")
    x, y, heading = place.tolist()
    return x, y, heading
