"""Services of the robot for programs: arguments may be numpy numbers and bytes, pictures return as bytes."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from nao_hil.naoqi_programs.python2 import to_unicode

_PICTURES: Final = ("getImageRemote", "getImageLocal")


class Service:
    """A service whose methods take the arguments of the vendor's SDK.

    Args:
        service: qi's object.
    """

    def __init__(self, service: Any) -> None:
        self._service = service

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._service, name)
        if name.startswith("__") or not callable(attribute) or hasattr(attribute, "connect"):
            return attribute
        return _method(attribute, pictures=name in _PICTURES)


def _method(found: Callable[..., Any], *, pictures: bool) -> Callable[..., Any]:
    def call(*arguments: Any, **options: Any) -> Any:
        """Call with arguments that qi can send; a picture is returned with its bytes."""
        result = found(*map(sendable, arguments), **options)
        return _with_bytes(result) if pictures else result

    return call


def sendable(value: Any) -> Any:
    """An argument that qi can send: numbers and arrays of numpy as Python's, bytes as text."""
    if isinstance(value, str):
        return to_unicode(value)
    if isinstance(value, bool | int | float) and type(value) in (bool, int, float):
        return value
    if hasattr(value, "tolist"):  # of numpy, whose types need not be loaded
        return sendable(value.tolist())
    if isinstance(value, bytes):
        return to_unicode(value.decode("utf-8", "surrogateescape"))
    if isinstance(value, list | tuple | set | frozenset | range):
        return [sendable(part) for part in value]
    if isinstance(value, dict):
        return {sendable(k): sendable(v) for k, v in value.items()}
    return value


def _with_bytes(image: Any) -> Any:
    """A picture with its bytes as a `bytearray`: the server sends text, since qi's package sends no bytes."""
    if hasattr(image, "andThen"):  # a future
        return image.andThen(_with_bytes)
    if image is None:
        return None
    return [bytearray(part, "latin-1") if isinstance(part, str) else part for part in image]


_OWN = {str(Path(__file__).with_name(name)) for name in ("python2.py", "services.py")}
"""Files between a program and its callees."""


def print_error(error: BaseException, program: str) -> None:
    """Print an error's traceback from the program's first line on; all of it where none is the program's."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename not in _OWN]
    first = next((i for i, frame in enumerate(frames) if frame.filename == program), 0)
    lines = [*traceback.format_list(frames[first:]), *traceback.format_exception_only(type(error), error)]
    sys.stderr.write("Traceback (most recent call last):\n" + "".join(lines))
