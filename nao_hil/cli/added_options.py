"""Options that commands share without declaring them: those of a run, `--json`, and `--keys` of an endpoint."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Final, TypeAlias, get_type_hints

import typer

from bridge.link.certificates import with_keys
from nao_hil.cli import options
from nao_hil.cli.console import Answer
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
_JSON: Final = Annotated[
    bool, typer.Option("--json", help="End with one JSON object on the last line of stdout.")
]
_KEYS: Final = Annotated[
    Path | None,
    typer.Option(
        "--keys",
        help="Folder of certificates (`nao-hil keys`) for an endpoint tls/HOST:PORT.",
        metavar="DIR",
        show_default=False,
    ),
]


Command: TypeAlias = "Callable[..., Answer | int]"
_KEYWORD: Final = inspect.Parameter.KEYWORD_ONLY


def takes_run(*names: str) -> Callable[[Command], Command]:
    """Make a function of a `RunConfig` a command with the options that the configuration comes from.

    Args:
        names: of `OPTIONS`, in the order of the help; none: all. `--config` comes with them.

    Returns:
        A decorator. The function's first parameter is the configuration; the others are options of its own.
    """
    chosen = names or tuple(OPTIONS)

    def decorate(function: Command) -> Command:
        """The command with the run's options before its own."""

        def command(**given: Any) -> Any:
            settings = run_config(given.pop("config"), **{name: given.pop(name) for name in chosen})
            return function(settings, **given)

        hints = get_type_hints(function, include_extras=True)
        own = list(inspect.signature(function).parameters.values())[1:]
        shared = {name: OPTIONS[name] for name in chosen} | {"config": options.Config}
        parameters = [_option(name, annotation) for name, annotation in shared.items()]
        parameters += [p.replace(kind=_KEYWORD, annotation=hints[p.name]) for p in own]
        return _seen_as(command, function, parameters, hints["return"])

    return decorate


def with_shared_options(run: Command) -> Callable[..., int]:
    """A command, with `--json` if it gives an `Answer`, and `--keys` if it takes an endpoint."""
    hints = get_type_hints(run, include_extras=True)
    parameters = [p.replace(annotation=hints[p.name]) for p in inspect.signature(run).parameters.values()]
    endpoints = [name for name in ENDPOINTS if name in hints]

    def command(*args: Any, as_json: bool = False, keys: Path | None = None, **given: Any) -> int:
        for name in endpoints:
            if given.get(name) is not None and "://" not in given[name]:  # those are not places of the link
                given[name] = with_keys(given[name], keys)
        answer = run(*args, **given)
        return answer.give(as_json=as_json) if isinstance(answer, Answer) else answer

    if hints["return"] is not int:
        parameters.append(_option("as_json", _JSON, False))
    if endpoints:
        parameters.append(_option("keys", _KEYS))
    return _seen_as(command, run, parameters, int)


def _option(name: str, annotation: Any, default: Any = None) -> inspect.Parameter:
    return inspect.Parameter(name, _KEYWORD, default=default, annotation=annotation)


def _seen_as(
    command: Callable[..., Any], function: Command, parameters: list[inspect.Parameter], gives: Any
) -> Callable[..., Any]:
    """The command with the name and the help of a function, and the parameters that typer is to see."""
    command.__signature__ = inspect.Signature(parameters, return_annotation=gives)  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in parameters} | {"return": gives}
    command.__name__, command.__doc__ = function.__name__, function.__doc__
    return command
