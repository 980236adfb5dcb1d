"""Robots that share a world: a file that lists them, or a number of like ones."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Final, NamedTuple

import msgspec

from bridge.config import load_toml
from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ROBOT
from bridge.messages.frames import Name
from bridge.messages.game import Byte, PlayerNumber
from bridge.types import Bounded, Count, Vec3
from nao_hil.runs.config import RunConfig, run_config

SPACING = 0.8
"""Between the torsos of like robots in a row, m: out of reach of each other's arms."""


class WorldRobot(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A robot of a world file."""

    name: Name
    """Its id on the link."""
    robot: str = "nao-v3"
    wear: str = "nominal"
    seed: Count = 0
    start: str = ""
    at: tuple[Bounded, Bounded] = (0.0, 0.0)
    """Place of its torso on the floor, m."""
    yaw: Bounded = 0.0
    """Its heading, degrees."""
    team: Byte | None = None
    """Number of its team in the league's games."""
    player: PlayerNumber | None = None
    """Its number in the team."""

    def __post_init__(self) -> None:
        """Raises ValueError for one of the two numbers alone."""
        if (self.team is None) != (self.player is None):
            raise ValueError(f"robot `{self.name}` needs both `team` and `player`, or neither")


class WorldFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The robots of a world."""

    robots: Annotated[tuple[WorldRobot, ...], msgspec.Meta(min_length=1)]

    def __post_init__(self) -> None:
        """Raises ValueError for two robots of one name."""
        names = [robot.name for robot in self.robots]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"two robots are called `{twice[0]}`; give each a name of its own")


class Member(NamedTuple):
    """A robot to be built into a world."""

    name: str
    config: RunConfig
    at: Vec3 | None
    """x and y in m, and heading, rad; None: the scenario's."""
    player: tuple[int, int] | None = None
    """Team and player number in the league's games."""


OF_A_ROBOT: Final = ("robot", "wear", "start")
"""Fields of `RunConfig` that a robot of a file has of its own."""


def members(settings: RunConfig, name: str, number: int, file: Path | None) -> list[Member]:
    """The robots of a world.

    Args:
        settings: Of each robot; a file's robots have body, wear, start and seed of their own.
        name: Of one robot; of several NAME1, NAME2, ..., with seeds one after the other.
        number: Of like robots, in a row from right to left, the first one at the origin.
        file: Lists the robots; None: `number` like ones.

    Raises:
        ConfigurationError: no such file, an unknown key or a wrong value in it; a file and a number.
    """
    if file is not None:
        if number != 1:
            raise ConfigurationError("The file of --world lists its robots; leave out --robots.")
        given = {"name": name != DEFAULT_ROBOT}
        given |= {field: getattr(settings, field) != getattr(RunConfig(), field) for field in OF_A_ROBOT}
        if named := [field for field, differs in given.items() if differs]:
            raise ConfigurationError(
                f"The file of --world gives each robot its {' and '.join(named)}; write "
                f"{'it' if len(named) == 1 else 'them'} there."
            )
        return [_member(settings, robot) for robot in load_toml(file, WorldFile).robots]
    if number == 1:
        return [Member(name, settings, None)]
    return [
        Member(
            f"{name}{i + 1}",
            msgspec.structs.replace(settings, seed=settings.seed + i),
            (0.0, SPACING * i, 0.0),
        )
        for i in range(number)
    ]


def _member(settings: RunConfig, robot: WorldRobot) -> Member:
    own = run_config(
        None,
        robot=robot.robot,
        wear=robot.wear,
        seed=robot.seed,
        start=robot.start or None,
        engine=settings.engine,
        scenario=settings.scenario,
        mode=settings.mode,
    )
    own = msgspec.structs.replace(own, guard=settings.guard)
    player = None if robot.team is None or robot.player is None else (robot.team, robot.player)
    return Member(robot.name, own, (*robot.at, math.radians(robot.yaw)), player)
