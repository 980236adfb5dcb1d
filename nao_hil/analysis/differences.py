"""Differences of two recorded runs: values of the configuration in force, figures, events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.errors import ConfigurationError
from emulator.scenarios import load_scenario
from nao_hil.analysis.diagnosis import symptoms_of
from nao_hil.analysis.inspection import inspect
from nao_hil.runs.config import RunConfig
from nao_hil.runs.run import load
from walker.gaits import gait_parameters
from walker.parameters import controller_parameters

SAME_TIME: Final = 0.05
"""Robot time within which two events are one, s."""
NOT_COMPARED: Final = ("file", "config", "messages", "diagnosis")
NAMED: Final = 4
"""Differences of a kind that a title names."""

Event = tuple[float, str]
"""Robot time, s, and text."""


def differences(first: Path, second: Path) -> dict[str, Any]:
    """Differences: `config` and `figures` by name with both values, `events` of one run only.

    Raises:
        ConfigurationError: not a recording.
    """
    contents = [msgspec.to_builtins(inspect(file)) for file in (first, second)]
    figures = [_flat({k: v for k, v in one.items() if k not in NOT_COMPARED}) for one in contents]
    return {
        "config": config_differences(first, second),
        "figures": _unequal(figures, [*figures[0], *figures[1]]),
        "events": event_differences(first, second),
    }


def config_differences(first: Path, second: Path) -> dict[str, list[Any]]:
    """Values in force that differ, by name: where a run sets none, the default that applied to it.

    None: the recording does not tell it, or its gait has no such parameter.

    Raises:
        ConfigurationError: not a recording.
    """
    configs = [load(file).config for file in (first, second)]
    given = [{k: v for k, v in _flat(config).items() if v not in ("", [])} for config in configs]
    whole = [_defaults(config) | one for config, one in zip(configs, given, strict=True)]
    return _unequal(whole, [*given[0], *given[1]])


def _defaults(config: Mapping[str, Any]) -> dict[str, Any]:
    """Values that apply where the configuration of a run sets none, by flat name; none of another recording."""
    if "gait" not in config:
        return {}
    defaults = msgspec.to_builtins(RunConfig()) | dict(config)
    try:
        gait = gait_parameters(defaults["gait"], defaults["parameters"])
        controllers = controller_parameters(defaults["gait"], defaults["controller"])
        defaults |= {"velocity": list(gait.velocity), "parameters": msgspec.to_builtins(gait)}
        defaults["controller"] = msgspec.to_builtins(controllers)
        defaults["start"] = load_scenario(defaults["scenario"]).start.pose
    except ConfigurationError:  # a gait of another version, or a scenario that is elsewhere
        pass
    return _flat(defaults)


def event_differences(first: Path, second: Path) -> list[list[Event]]:
    """Events of the first run only and of the second only; empty where there are none of either.

    Raises:
        ConfigurationError: not a recording.
    """
    runs = [load(file) for file in (first, second)]
    events = [sorted((round(s.time, 3), s.text) for s in symptoms_of(run.cycles(), run.body)) for run in runs]
    alone = [_alone(events[0], events[1]), _alone(events[1], events[0])]
    return alone if any(alone) else []


def titles(config: Mapping[str, Sequence[Any]], events: Sequence[Sequence[Event]]) -> list[str]:
    """Lines for the title of a picture of both: the first differences of each kind, files by their names."""
    texts = {name: [value_text(v).rpartition("/")[2] for v in values] for name, values in config.items()}
    values = [f"{name} ({', '.join(both)})" for name, both in texts.items()]
    lines = [f"they differ in {_first(values, ', ')}"] if values else []
    for which, alone in zip(("first", "second"), events, strict=False):
        if alone:
            named = [f"{text} at {time:.2f} s" for time, text in alone]
            lines.append(f"only in the {which}: {_first(named, '; ')}")
    return lines


def _first(words: Sequence[str], between: str) -> str:
    more = len(words) - NAMED
    return between.join(words[:NAMED]) + (f"{between}and {more} more" if more > 0 else "")


def value_text(value: Any) -> str:
    """A value for a person."""
    if isinstance(value, list):
        return " ".join(map(value_text, value)) or "none"
    return "none" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as one, with dots between the keys."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _unequal(tables: Sequence[Mapping[str, Any]], names: Sequence[str]) -> dict[str, list[Any]]:
    """Values of both tables under the names under which they are not equal."""
    both = {name: [table.get(name) for table in tables] for name in dict.fromkeys(names)}
    return {name: values for name, values in both.items() if values[0] != values[1]}


def _alone(events: Sequence[Event], others: Sequence[Event]) -> list[Event]:
    """Events that the other run does not have at that time."""
    return [
        (time, text)
        for time, text in events
        if not any(words == text and abs(when - time) <= SAME_TIME for when, words in others)
    ]
