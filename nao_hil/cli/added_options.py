"""Options that a decorator adds to commands: those of a run, and `--keys` of an endpoint."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, Final, get_type_hints

import typer

from bridge.link.certificates import with_keys
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
ENDPOINTS: Final = ("connect", "listen")
"""Parameters of commands that are endpoints."""
_KEYS: Final = Annotated[
    Path | None,
    typer.Option(
        "--keys",
        help="Folder of certificates (`nao-hil keys`) for an endpoint tls/HOST:PORT.",
        metavar="DIR",
        show_default=False,
    ),
]


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


def with_keys_option(run: Callable[..., Any]) -> Callable[..., Any]:
    """The function of a command, with the option `--keys` if it takes an endpoint."""
    signature = inspect.signature(run)
    endpoints = [name for name in ENDPOINTS if name in signature.parameters]
    if not endpoints:
        return run

    @wraps(run)
    def command(*args: Any, keys: Path | None = None, **kwargs: Any) -> Any:
        for name in endpoints:
            if kwargs.get(name) is not None and "://" not in kwargs[name]:  # those are not places of the link
                kwargs[name] = with_keys(kwargs[name], keys)
        return run(*args, **kwargs)

    hints = get_type_hints(run, include_extras=True)
    parameters = [p.replace(annotation=hints[p.name]) for p in signature.parameters.values()]
    parameters.append(inspect.Parameter("keys", inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_KEYS))
    del command.__wrapped__  # typer is to see this signature, not the one inside
    command.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    command.__annotations__ = hints | {"keys": _KEYS}
    return command
