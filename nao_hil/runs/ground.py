"""Known ground of a scenario for a planner: the floor's slope and the boxes on it."""

from __future__ import annotations

import math
from typing import Any, Final

import msgspec

from bridge.body import Body
from bridge.body.joints import LEG_SLOTS
from bridge.body.kinematics import foot_in_torso
from bridge.errors import ConfigurationError
from bridge.ground import KnownGround, Patch
from emulator.scenarios import PlacedBox, Scenario, load_scenario
from nao_hil.runs.config import RunConfig

STEP_UP: Final = 0.03
"""m; a box higher than this is an obstacle, no ground."""
_TOUCH_GAP: Final = 1e-3
"""m; a gap below a box that is none."""


def ground_parameters(settings: RunConfig, body: Body) -> dict[str, Any]:
    """The gait's parameters of a run, with the ground of its scenario for a gait that plans for it.

    A ground among the parameters overrides the scenario's: `parameters.ground = {}` walks as on a flat floor.

    Raises:
        ConfigurationError: no such scenario, or ground that no straight walk can be planned over.
    """
    if settings.gait != "huang" or "ground" in settings.parameters:
        return settings.parameters
    ground = known_ground(load_scenario(settings.scenario), body)
    return settings.parameters if ground.flat else settings.parameters | {"ground": msgspec.to_builtins(ground)}


def known_ground(scenario: Scenario, body: Body) -> KnownGround:
    """The ground of a scenario, in the walk frame of a robot that starts where the scenario puts it.

    Level boxes that cannot be moved count as ground; random ground and later events are unknown.

    Raises:
        ConfigurationError: ground that no straight walk can be planned over: a floor that leans sideways, a
            robot that starts turned, a box that is turned, or one too high to step on.
    """
    if scenario.floor.roll != 0.0 or scenario.start.yaw != 0.0:
        raise ConfigurationError(
            f"gait huang: with floor.roll = {scenario.floor.roll:g} deg and start.yaw = "
            f"{scenario.start.yaw:g} deg no straight walk can be planned; both must be 0, or give "
            "`parameters.ground = {}` to walk as on a flat floor."
        )
    ahead = scenario.start.x + _ankles(scenario.start.posture, body)
    ground = KnownGround(slope=math.radians(scenario.floor.pitch))
    for box in scenario.boxes:
        if box.mass == 0.0:
            patch = _patch(box, (box.at[0] - ahead, box.at[1] - scenario.start.y), ground)
            ground = msgspec.structs.replace(ground, patches=(*ground.patches, patch))
    return ground


def _ankles(posture: str, body: Body) -> float:
    """Place of the ankles ahead of the torso in a posture whose soles are level, m."""
    # Imported late: the walker's machine has no PyBullet, and a walk on unknown ground needs none.
    from emulator.start import start_posture

    angles = start_posture(posture)
    pose = foot_in_torso(body, "L", [angles[slot] for slot in LEG_SLOTS["L"]])
    # The torso's place seen from the sole: its axes are the level ones.
    return float(pose[:3, 3] @ pose[:3, 0])


def _patch(box: PlacedBox, at: tuple[float, float], below: KnownGround) -> Patch:
    """The top of a box on earlier boxes."""
    if box.yaw % 90.0 != 0.0:
        raise ConfigurationError(
            f"gait huang: the box `{box.name}` is turned by {box.yaw:g} deg; edges across the walk can be "
            "planned for, oblique ones cannot."
        )
    length, width, thick = box.size if box.yaw % 180.0 == 0.0 else (box.size[1], box.size[0], box.size[2])
    (x, y), half = at, (0.5 * length, 0.5 * width)
    # as the world puts it down: on the highest below its middle and its corners, these a little inside
    lies_on = max(
        below.height(x + a * length, [y + b * width])
        for a, b in ((0.0, 0.0), *((a, b) for a in (-0.499, 0.499) for b in (-0.499, 0.499)))
    )
    bottom = lies_on if box.height is None else box.height
    if bottom > lies_on + _TOUCH_GAP:
        raise ConfigurationError(
            f"gait huang: the box `{box.name}` hangs {1e3 * (bottom - lies_on):.0f} mm above the ground; "
            "ground can be planned for, ceilings cannot."
        )
    if (step := bottom + thick - lies_on) > STEP_UP:
        raise ConfigurationError(
            f"gait huang: the box `{box.name}` is {1e3 * step:.0f} mm high; steps of up to "
            f"{1e3 * STEP_UP:.0f} mm can be planned for."
        )
    return Patch(x=(x - half[0], x + half[0]), y=(y - half[1], y + half[1]), height=bottom + thick)
