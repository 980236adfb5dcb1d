"""Gaits by name, with their parameters: the shipped ones, changed on request, and checked for a body.

To add a gait takes its folder here and its name in `GAITS`; a learned one is named by its sheet, `onnx:SHEET`.
"""

from __future__ import annotations

import functools
import importlib
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.body import Body
from bridge.body.inverse_kinematics import UnreachableError
from bridge.body.joints import LEG_SLOTS
from bridge.body.leg_limits import CLIPPED_EXCESS, limit_violations
from bridge.config import from_dict, load_toml
from bridge.errors import ConfigurationError
from bridge.types import SIDES, Side
from bridge.validation import unknown_name
from walker.gaits.gait import Gait, GaitKind, GaitParameters, dry_walk, standing_plan
from walker.gaits.learned import PREFIX, learned_kind, sheet_path
from walker.gaits.learned.parameters import LearnedParameters
from walker.gaits.plan import Plan
from walker.gaits.pose import PoseMaker

GAITS: Final = ("static", "dynamic", "huang", "omni")
"""Names of the gaits: each is a folder of this package, with the gait's `KIND`."""
_OF_THESIS: Final = ("static", "dynamic")
"""Gaits whose folders are in `thesis`."""


def _folder(name: str) -> tuple[str, ...]:
    """Names of the folders from this one to that of a gait."""
    if name.startswith(PREFIX):
        return ("learned",)
    return ("thesis", name) if name in _OF_THESIS else (name,)


@functools.lru_cache
def gait_kind(name: str) -> GaitKind:
    """The `KIND` in the folder of a gait.

    Raises:
        ConfigurationError: unknown gait.
    """
    if name.startswith(PREFIX):
        return learned_kind(name)
    if name not in GAITS:
        raise ConfigurationError(f"{unknown_name('gait', name, GAITS)}, and {PREFIX}SHEET")
    package = ".".join((__package__, *_folder(name)))
    kind: GaitKind = importlib.import_module(package).KIND
    return kind


def gait_file(name: str, file: str) -> Path:
    """Path of a file in the folder of a gait.

    Args:
        name: of the gait.
        file: its name.

    Raises:
        ConfigurationError: unknown gait.
    """
    gait_kind(name)
    if name.startswith(PREFIX) and file == "gait.toml":
        return sheet_path(name)
    return Path(__file__).parent.joinpath(*_folder(name), file)


def gait_parameters(name: str, changes: Mapping[str, Any] | None = None) -> GaitParameters:
    """The shipped parameters of a gait, with some of them changed.

    Args:
        name: of the gait.
        changes: values that differ from the shipped ones.

    Raises:
        ConfigurationError: unknown gait, unknown or ill-typed parameter.
    """
    kind, file = gait_kind(name).parameters, gait_file(name, "gait.toml")
    shipped = load_toml(file, kind)
    if isinstance(shipped, LearnedParameters):
        shipped = msgspec.structs.replace(shipped, model=str((file.parent / shipped.model).absolute()))
    if not changes:
        return shipped
    return from_dict(msgspec.to_builtins(shipped) | dict(changes), f"gait {name}", kind)


def policy_files(name: str) -> tuple[Path, ...]:
    """The sheet and the network of a learned gait; of other gaits none.

    Raises:
        ConfigurationError: a sheet that cannot be read.
    """
    parameters = gait_parameters(name) if name.startswith(PREFIX) else None
    if not isinstance(parameters, LearnedParameters):
        return ()
    return sheet_path(name), Path(parameters.model)


def make_gait(name: str, parameters: GaitParameters, body: Body) -> Gait[Any]:
    """A gait for a body.

    Args:
        name: of the gait.
        parameters: of its type.
        body: data sheet.

    Raises:
        ConfigurationError: parameters that this body cannot walk; names the violated bound.
    """
    return gait_kind(name).make(parameters, body)


_CHECKED_STEPS = 4
"""Start, two regular steps and the closing one hold every pose of a gait."""
_DT = 0.02
"""Time between two checked poses, s."""
_DT_QUASI_STATIC = 0.1
"""Time step of a gait that takes seconds for a step."""
_SEARCH_PRECISION = 0.1
"""Precision of the fastest walk that a search finds, as a part of it."""
_LEAST_SHARE = 0.005
"""Part of a refused velocity below which the search gives up."""


def walkable_gait(
    name: str, parameters: GaitParameters, body: Body, rest: Callable[[], None] = lambda: None
) -> Gait[Any]:
    """A gait that a body can walk.

    Args:
        name: of the gait.
        parameters: of the gait.
        body: data sheet.
        rest: see `check_walkable`.

    Raises:
        ConfigurationError: the body cannot walk it; where it can at a lower velocity, that one is named.
    """
    try:
        return _checked_gait(name, parameters, body, rest)
    except ConfigurationError as error:
        refused = parameters.periodic_step.velocity
        fastest = refused * _walkable_part(name, parameters, body, rest)
        if not fastest:
            raise
        raise ConfigurationError(
            f"{refused:.3g} m/s are too fast for the {name} gait on a {body.name}, {fastest:.3f} m/s would do: "
            f"{error}"
        ) from None


def _checked_gait(name: str, parameters: GaitParameters, body: Body, rest: Callable[[], None]) -> Gait[Any]:
    gait = make_gait(name, parameters, body)
    check_walkable(body, gait, rest)
    return gait


def _walkable_part(name: str, parameters: GaitParameters, body: Body, rest: Callable[[], None]) -> float:
    """The largest part of a refused velocity that the body can walk; 0: none of it."""
    refused = parameters.periodic_step.velocity
    low, high = 0.0, 1.0
    while high - low > _SEARCH_PRECISION * high and high > _LEAST_SHARE:
        middle = 0.5 * (low + high)
        try:
            _checked_gait(name, parameters.with_velocity((middle * refused, 0.0, 0.0)), body, rest)
        except ConfigurationError:
            high = middle
        else:
            low = middle
    return low


def check_walkable(body: Body, gait: Gait[Any], rest: Callable[[], None] = lambda: None) -> None:
    """Walk a gait dry, through the inverse kinematics; takes some 25 ms.

    Args:
        body: data sheet.
        gait: to be walked.
        rest: called after each pose, for other threads.

    Raises:
        ConfigurationError: a pose that the legs cannot reach or the joint limits forbid; names the phase, the
            leg or joint, and by how much.
    """
    plan = standing_plan(gait)
    if plan.policy is not None:  # its network gives joint angles, which its stabilizer keeps within the ranges
        return
    try:
        pose = PoseMaker(body, plan, by_pose=gait.quasi_static)
        for plan, _ in dry_walk(gait, _DT_QUASI_STATIC if gait.quasi_static else _DT, _CHECKED_STEPS):
            _check_limits(body, pose.unlimited_angles(plan), plan, _where(gait, plan))
            rest()
    except UnreachableError as error:
        raise ConfigurationError(
            f"{_where(gait, plan)}: {error}; shorten the step, narrow the feet or lower the gait height."
        ) from None


def _where(gait: Gait[Any], plan: Plan) -> str:
    return f"gait {gait.name}, phase {plan.phase} of step {plan.step + 1}"


def _check_limits(body: Body, angles: tuple[float, ...], plan: Plan, where: str) -> None:
    for side in SIDES:
        for joint, excess in limit_violations(body, side, [angles[slot] for slot in LEG_SLOTS[side]]):
            hangs = joint == f"{side}AnkleRoll" and _clears_ground(body, side, plan, excess)
            if hangs or abs(excess) < CLIPPED_EXCESS:
                continue
            bound = "above" if excess > 0.0 else "below"
            raise ConfigurationError(
                f"{where}: {joint} would stand {math.degrees(abs(excess)):.1f} deg {bound} its range on a "
                f"{body.name}; change the step, the feet's distance or the gait height."
            )


def _clears_ground(body: Body, side: Side, plan: Plan, tilt: float) -> bool:
    """Whether a swing foot that its AnkleRoll cannot keep level stays off the ground all the same.

    AnkleRoll's range narrows as AnklePitch bends: with the 35 mm of lift of figure 3.4 a level foot is out of
    it at mid-swing, and hangs tilted instead.
    """
    if plan.support in (side, "both"):
        return False
    foot = plan.foot(side)
    widest = max(abs(y) for _, y in body.foot.sole)
    return foot.z > widest * math.sin(abs(tilt))
