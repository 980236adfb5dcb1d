"""Builds the robot and the controller that a configuration describes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import msgspec

from bridge.body import Body, load_body
from bridge.errors import ConfigurationError
from bridge.types import Vec3
from nao_hil.runs.config import RunConfig
from nao_hil.runs.ground import ground_parameters
from walker.controller import Controller, WalkOrder
from walker.gaits import gait_parameters
from walker.gaits.catalogue import walkable_gait
from walker.gaits.gait import GaitParameters, clipped_in_words
from walker.gaits.order import target_order
from walker.parameters import controller_parameters
from walker.process import MakeController

if TYPE_CHECKING:
    from emulator.robot import EmulatedRobot
    from emulator.scenarios import Scenario
    from emulator.wear import WearProfile
    from emulator.world.world import World


def with_engine(settings: RunConfig) -> RunConfig:
    """The configuration with the name of the engine that it means on this machine."""
    from emulator.engine.catalogue import choose_engine

    return msgspec.structs.replace(settings, engine=choose_engine(settings.engine))


def build_robot(
    settings: RunConfig,
    scenario: Scenario | None = None,
    body: Body | None = None,
    wear: WearProfile | None = None,
    *,
    name: str = "nao",
    at: Vec3 | None = None,
    player: tuple[int, int] | None = None,
    world: World | None = None,
) -> EmulatedRobot:
    """The emulated robot of a run, at cycle 0; the caller closes it.

    Args:
        settings: Configuration; `robot`, `wear`, `scenario`, `engine` and `seed` are read.
        scenario: Replaces the scenario that the configuration names.
        body: Replaces the body that it names.
        wear: Replaces the wear profile that it names.
        name: As for `EmulatedRobot`; `at`, `player` and `world` too.
        at: Likewise.
        player: Likewise.
        world: Likewise.

    Raises:
        ConfigurationError: no such body, wear profile or scenario, or a box of the scenario inside the robot.
    """
    # imported here: the walker's machine builds controllers and has no physics engine
    from emulator.robot import EmulatedRobot
    from emulator.scenarios import load_scenario
    from emulator.wear import load_wear

    body = load_body(settings.robot) if body is None else body
    return EmulatedRobot(
        body,
        seed=settings.seed,
        engine=settings.engine,
        wear=load_wear(settings.wear, body) if wear is None else wear,
        scenario=load_scenario(settings.scenario) if scenario is None else scenario,
        start=settings.start or None,
        name=name,
        at=at,
        player=player,
        world=world,
    )


def require_upright(robot: EmulatedRobot) -> None:
    """Refuse a robot placed upright that fell before its first cycle.

    Raises:
        ConfigurationError: it did.
    """
    if robot.fell_over:
        lean = math.degrees(robot.tilt)
        raise ConfigurationError(
            f"{robot.body.name} falls before the run begins: its torso leans by {lean:.0f} degrees. A flatter "
            "floor, more friction or more room around it would do; `--start lie-back` begins lying."
        )


def check_run(settings: RunConfig, *, waits: bool = True) -> None:
    """Refuse a configuration that robot or walker would refuse before the first cycle.

    Args:
        settings: Configuration.
        waits: The walker waits for orders at a stand.

    Raises:
        ConfigurationError: as `check_robot`, a gait or controller that this body cannot walk with, or a walk
            of a robot that hangs.
    """
    body = check_robot(settings)
    controller_maker(settings, waits=waits)(body, body.cycle)


def check_robot(settings: RunConfig) -> Body:
    """The body of a run whose robot can begin: everything of it is there and fits.

    Raises:
        ConfigurationError: no such body, wear profile or scenario, a wrong one, a box inside the robot,
            a robot that falls before its first cycle, or a cycle that the physics cannot fill.
    """
    # imported here: as in `build_robot`
    from emulator.engine.settings import SETTINGS
    from emulator.scenarios import load_scenario
    from emulator.wear import load_wear

    body = load_body(settings.robot)
    SETTINGS.steps(body)
    wear = load_wear(settings.wear, body)
    scenario = load_scenario(settings.scenario)
    if settings.scenario != "flat":  # only an engine knows whether the robot has room and stands there
        # its events may be those of other robots
        still = msgspec.structs.replace(
            scenario, pushes=(), plates=(), tilts=(), frictions=(), pendulums=(), faults=()
        )
        with build_robot(settings, still, body, wear) as robot:
            require_upright(robot)
    return body


def controller_maker(settings: RunConfig, *, waits: bool = False) -> MakeController:
    """A function that makes the controller of a run, given the robot's body and cycle time (s).

    Args:
        settings: Configuration; gait, velocity, target, parameters, controller, steps and duration are read.
        waits: It waits for orders at a stand.

    Raises:
        ConfigurationError: a wrong parameter of the gait or the controller, or a walk of a robot that hangs.
    """
    if settings.start == "hang" and not waits:
        raise ConfigurationError(
            "start hang: a robot that hangs has no ground to walk on; `stand` would do, or to wait for orders "
            "(`nao-hil up --serve`)."
        )
    controllers = controller_parameters(settings.gait, settings.controller)
    moving = _moving(settings, settings.parameters)  # refuses a wrong parameter before a robot is there
    order = WalkOrder(steps=settings.steps, duration=settings.duration or float("inf"))
    if settings.target:
        x, y, turn = settings.target
        order = target_order(order, (x, y, turn), moving)

    def make(body: Body, cycle: float) -> Controller:
        parameters = _moving(settings, ground_parameters(settings, body))
        gait = walkable_gait(settings.gait, parameters, body)
        wanted = None if waits else order
        return Controller(body, gait, wanted, cycle, controllers, recover=settings.recover)

    return make


def _moving(settings: RunConfig, changes: dict[str, Any]) -> GaitParameters:
    """Parameters of the gait at the velocity of the run."""
    parameters = gait_parameters(settings.gait, changes)
    if not settings.velocity:
        return parameters
    x, y, turn = settings.velocity
    return parameters.with_velocity((x, y, turn))


def configuration_warnings(settings: RunConfig) -> list[str]:
    """Sentences on a run that goes otherwise than a user may expect.

    Its velocity may be beyond the gait's limits, or its admittances disturb a gait whose footholds follow the
    measured capture point.
    """
    said = []
    if settings.velocity:
        wanted, walked = settings.velocity, _moving(settings, settings.parameters).velocity
        words = clipped_in_words((wanted[0], wanted[1], wanted[2]), walked)
        x, y, turn = walked
        said += [f"{words}: {x:.3g} m/s, {y:.3g} m/s and {turn:.3g} rad/s."] if words else []
    own, switches = (controller_parameters(settings.gait, c).switches for c in ({}, settings.controller))
    if own.foothold_feedback and (switches.leg_admittance or switches.ankle_admittance):
        said.append(
            f"The gait {settings.gait} falls with the admittances on (docs/walking.md); with `--stabilizer "
            "own` and no `--admittance` it walks."
        )
    return said
