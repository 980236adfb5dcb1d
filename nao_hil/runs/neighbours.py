"""Robots with walkers of their own beside others of the same world, in one process."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import msgspec

from bridge.body import BODIES, Body, load_body
from bridge.errors import ConfigurationError, WalkRefused
from bridge.messages import ActuatorFrame, decode, encode
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.types import Bounded, Vec3
from bridge.validation import unknown_name
from emulator.robot import EmulatedRobot
from emulator.scenarios import Scenario
from emulator.world.world import World
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig
from walker.controller import Controller
from walker.gaits import gait_parameters
from walker.service import WalkService


class LocalWalker:
    """A walker beside its robot, called directly: no link."""

    def __init__(self, robot: EmulatedRobot, service: WalkService) -> None:
        self._robot, self._service = robot, service
        self._controller: Controller
        self._seq = 0
        """Next frame to answer."""
        self.restart()

    @property
    def name(self) -> str:
        """Name of its robot."""
        return self._robot.name

    def restart(self) -> None:
        """Begin again with a robot that has begun again."""
        body, self._seq = self._robot.body, self._robot.frame.seq
        self._controller = self._service.make(body, body.cycle)
        self._service.after(self._controller, self._seq)

    def order(self, command: WalkCommand) -> WalkStatus:
        """Hand a command over; it acts at the next tick."""
        return decode(self._service.answer(encode(command)), WalkStatus)

    def answer(self) -> ActuatorFrame | None:
        """Command of the cycle that begins; None: the DCM stands still, and the last one holds."""
        frame = self._robot.frame
        if frame.seq < self._seq:
            return None
        self._service.before(self._controller, frame.seq)
        command = self._controller.tick(frame)
        self._service.after(self._controller, frame.seq)
        self._seq = frame.seq + 1
        return command


class Neighbour(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Another robot in the world of a walk, which walks or stands and gets up after a fall."""

    at: tuple[Bounded, Bounded]
    """Place of its torso on the floor, m."""
    yaw: Bounded = 0.0
    """Its heading, degrees."""
    robot: str = ""
    """Name of a body that is shipped; empty: that of the walk."""
    wear: Literal["ideal", "nominal", "worn"] = "nominal"
    gait: str = "omni"
    velocity: tuple[Bounded, Bounded, Bounded] | None = None
    """m/s, m/s, rad/s; None: it stands. Beyond its gait's limits it walks as fast as these allow."""

    def __post_init__(self) -> None:
        """Raises ValueError for a body or a gait that is not there."""
        if self.robot and self.robot not in BODIES:
            raise ValueError(unknown_name("body", self.robot, BODIES))
        try:
            gait_parameters(self.gait)
        except ConfigurationError as error:
            raise ValueError(f"gait: {error}") from None


def add_neighbours(
    world: World, neighbours: Sequence[Neighbour], config: RunConfig, scenario: Scenario, body: Body
) -> list[EmulatedRobot]:
    """Put the neighbours of a walk into its world; their seeds follow that of the walk.

    Args:
        world: That has not begun.
        neighbours: Robots `neighbour1`, `neighbour2`, ...
        config: Of the walk.
        scenario: Of the world.
        body: Of neighbours that name none.

    Raises:
        ConfigurationError: another cycle time than the others', or no room there.
    """
    robots = []
    for i, one in enumerate(neighbours, start=1):
        own = msgspec.structs.replace(config, wear=one.wear, seed=config.seed + i, start="")
        sheet = load_body(one.robot) if one.robot else body
        place: Vec3 = (*one.at, math.radians(one.yaw))
        robots.append(build_robot(own, scenario, sheet, name=f"neighbour{i}", at=place, world=world))
    return robots


def walkers_of(robots: Sequence[EmulatedRobot], neighbours: Sequence[Neighbour]) -> list[LocalWalker]:
    """The walkers of the neighbours, under their orders; their world has begun.

    Raises:
        ConfigurationError: a gait that the body cannot walk, or a direction in which it does not walk.
    """
    walkers = []
    for robot, one in zip(robots, neighbours, strict=True):
        walker = LocalWalker(robot, WalkService(one.gait, recover=True))
        if one.velocity is not None:
            try:
                walker.order(WalkCommand(op="walk", velocity=one.velocity))
            except WalkRefused as error:
                raise ConfigurationError(f"{robot.name}: {error}") from None
        walkers.append(walker)
    return walkers
