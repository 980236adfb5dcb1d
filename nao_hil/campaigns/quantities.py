"""Quantities of a campaign, by name: any number of configuration, world, wear profile or body."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final

import msgspec

from bridge.body import Body, load_body
from bridge.body.load import check_body
from bridge.config import from_dict
from bridge.errors import ConfigurationError
from bridge.validation import Invalid, convert, unknown_name
from emulator.scenarios import Scenario, load_scenario
from emulator.scenarios.events import PushEvent
from emulator.wear import WearProfile, load_wear
from nao_hil.runs.config import RunConfig
from nao_hil.runs.neighbours import Neighbour
from nao_hil.runs.walk import Walk
from walker.gaits import gait_parameters
from walker.parameters import controller_parameters

PUSH_TIME: Final = 4.0
"""s of robot time at which the quantity `push` pushes."""
_Duration = Annotated[float, msgspec.Meta(gt=0.0)]


def changed(task: Walk, name: str, value: Any) -> Walk:
    """A walk with one quantity changed.

    Args:
        task: The walk.
        name: One of `QUANTITIES`; `duration`; `neighbours`; or a path: a field of the configuration such as
            `gait`, `wear`, `parameters.S_a0`, `controller.switches.torso`; `scenario` or
            `scenario.floor.friction`; `wear.servo.delay`; `body.lengths.TibiaLength`.
        value: Of it, in the unit of its table.

    Raises:
        ConfigurationError: no such quantity, or an impossible value.
    """
    if name in QUANTITIES:
        return QUANTITIES[name](task, _checked(name, value, float))
    head, _, rest = name.partition(".")
    if name == "duration":
        return msgspec.structs.replace(task, duration=_checked(name, value, _Duration))
    if name == "neighbours":
        return msgspec.structs.replace(task, neighbours=_checked(name, value, tuple[Neighbour, ...]))
    if head == "scenario":
        if not rest:
            return msgspec.structs.replace(task, scenario=load_scenario(_checked(name, value, str)))
        world = _set(task.scenario, head, rest, value, Scenario)
        return msgspec.structs.replace(task, scenario=world)
    if head == "wear" and rest:
        profile = task.wear or load_wear(task.config.wear, task.body or load_body(task.config.robot))
        return msgspec.structs.replace(task, wear=_set(profile, head, rest, value, WearProfile))
    if head == "body" and rest:
        body = _set(task.body or load_body(task.config.robot), head, rest, value, Body)
        check_body(body)
        return msgspec.structs.replace(task, body=body)
    if head not in RunConfig.__struct_fields__:
        known = (*RunConfig.__struct_fields__, "body", "neighbours", *QUANTITIES)
        raise ConfigurationError(unknown_name("quantity", head, known))
    config = _set(task.config, "configuration", name, value, RunConfig)
    if head in ("gait", "parameters", "controller"):
        gait_parameters(config.gait, config.parameters)
        controller_parameters(config.gait, config.controller)
    return msgspec.structs.replace(task, config=config)


def changed_all(task: Walk, point: Mapping[str, Any]) -> Walk:
    """A walk with several quantities changed, by name; arguments and errors as of `changed`."""
    for name, value in point.items():
        task = changed(task, name, value)
    return task


def _checked(name: str, value: Any, kind: Any) -> Any:
    try:
        return convert(value, kind)
    except Invalid as error:
        raise ConfigurationError(f"{name}: {error}") from None


def _set(struct: Any, what: str, path: str, value: Any, kind: type[Any]) -> Any:
    """The struct with the value at a path of keys; `what` names it in errors."""
    table = msgspec.to_builtins(struct)
    *tables, last = path.split(".")
    at = table
    for part in tables:
        at = at.setdefault(part, {})
        if not isinstance(at, dict):
            raise ConfigurationError(f"{what}: {path}: {part} is no table.")
    at[last] = value
    return from_dict(table, what, kind)


def _push(task: Walk, impulse: float) -> Walk:
    pushes = (PushEvent(time=PUSH_TIME, impulse=impulse),) if impulse > 0.0 else ()
    return msgspec.structs.replace(task, scenario=msgspec.structs.replace(task.scenario, pushes=pushes))


def _backlash(task: Walk, factor: float) -> Walk:
    profile = task.wear or load_wear(task.config.wear, task.body or load_body(task.config.robot))
    table = {name: factor * width for name, width in msgspec.to_builtins(profile.servo.backlash).items()}
    return changed(task, "wear.servo.backlash", table)


QUANTITIES: Final[dict[str, Callable[[Walk, Any], Walk]]] = {
    "push": _push,
    "slope": lambda task, degrees: changed(task, "scenario.floor.pitch", -degrees),
    "friction": lambda task, friction: changed(task, "scenario.floor.friction", friction),
    "delay": lambda task, seconds: changed(task, "wear.servo.delay", seconds),
    "backlash": _backlash,
}
"""Short names. `push`: impulse forward at 4 s, N s; `slope`: uphill, degrees; `friction`: of the floor;
`delay`: of the drives, s; `backlash`: factor on that of the wear profile."""
UNITS: Final = {
    "push": "N s",
    "slope": "deg uphill",
    "delay": "s",
    "duration": "s",
    "scenario.floor.roll": "deg",
    "scenario.floor.pitch": "deg",
}
"""Units of quantities, for the axes of a map; others have none, or that of their table."""
