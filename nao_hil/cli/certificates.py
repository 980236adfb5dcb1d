"""`--keys DIR` of every command that meets a robot: it goes into the endpoint, and wherever that goes."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, Final, get_type_hints

import typer

from bridge.link.certificates import with_keys

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
