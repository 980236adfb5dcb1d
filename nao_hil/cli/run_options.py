"""The options of a run, declared once for the commands that take them."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, Final, get_type_hints

from nao_hil.cli import options
from nao_hil.runs.config import run_config

OPTIONS: Final[dict[str, Any]] = {
    "robot": options.Body,
    "wear": options.Wear,
    "engine": options.Engine,
    "scenario": options.Scenario,
    "start": options.Start,
    "gait": options.Gait,
    "velocity": options.Velocity,
    "target": options.Target,
    "stabilizer": options.Stabilizer,
    "torso": options.Torso,
    "admittance": options.Admittance,
    "mode": options.Mode,
    "steps": options.Steps,
    "duration": options.Duration,
    "seed": options.Seed,
}
"""Argument of `run_config`: how it is given on the command line."""


def takes_run(*names: str) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Make a function of a `RunConfig` a command with the options that the configuration comes from.

    Args:
        names: of `OPTIONS`, in the order of the help; none: all. `--config` comes with them.

    Returns:
        A decorator. The function's first parameter is the configuration; the others are options of its own.
    """
    chosen = names or tuple(OPTIONS)

    def decorate(function: Callable[..., int]) -> Callable[..., int]:
        """The command with the run's options before its own."""

        def command(**given: Any) -> int:
            settings = run_config(given.pop("config"), **{name: given.pop(name) for name in chosen})
            return function(settings, **given)

        keyword = inspect.Parameter.KEYWORD_ONLY
        hints = get_type_hints(function, include_extras=True)
        own = list(inspect.signature(function).parameters.values())[1:]
        shared = {name: OPTIONS[name] for name in chosen} | {"config": options.Config}
        parameters = [inspect.Parameter(n, keyword, default=None, annotation=a) for n, a in shared.items()]
        parameters += [p.replace(kind=keyword, annotation=hints[p.name]) for p in own]
        command.__signature__ = inspect.Signature(parameters, return_annotation=int)  # type: ignore[attr-defined]
        command.__annotations__ = {p.name: p.annotation for p in parameters}
        command.__name__, command.__doc__ = function.__name__, function.__doc__
        return command

    return decorate
