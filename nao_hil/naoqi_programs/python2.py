"""Meaning of Python 2 in a converted program: one type for text and bytes, its division, its orders and names.

A `str` of Python 2 is a `str` of Python 3 whose bytes from 128 on are surrogates (PEP 383): it compares, joins
and matches as text and turns back into the same bytes. `source` puts calls of these functions into a program.
"""

from __future__ import annotations

import base64
import codecs
import csv
import io
import math
import operator
import os
import re
import string
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from email.message import Message
from functools import cmp_to_key
from importlib import import_module
from types import ModuleType
from typing import Any, Final

ROBOT: Final = ("naoqi", "nao_hil.naoqi_programs.services")
"""Modules whose functions give texts of the robot, which are UTF-8 there."""
_WANTS_BYTES: Final = re.compile("bytes|must be encoded|without an encoding|buffer|surrogates not allowed")
_ESCAPED: Final = ("unicode_escape", "raw_unicode_escape", "string_escape")
_OF_CODECS: Final = ("hex", "base64", "zlib", "bz2", "uu", "quopri")
_Bytes = bytes | bytearray | memoryview


def to_bytes(text: str) -> bytes:
    """Bytes of a text of Python 2, or of a unicode one in UTF-8."""
    return text.encode("utf-8", "surrogateescape")


def to_str(data: _Bytes) -> str:
    """Bytes as a text of Python 2."""
    return bytes(data).decode("ascii", "surrogateescape")


def to_unicode(text: str) -> str:
    """A text of Python 2 as a unicode one: from UTF-8, or else from Latin-1."""
    if text.isascii():
        return text
    try:
        return to_bytes(text).decode("utf-8")
    except UnicodeError:
        return to_bytes(text).decode("latin-1")


def _results(value: Any) -> Any:
    """A result with bytes as texts, one level deep."""
    if isinstance(value, bytes):
        return to_str(value)
    if type(value) in (tuple, list) and any(isinstance(part, bytes) for part in value):
        return type(value)(map(_results, value))
    return value


def of_robot(value: Any) -> Any:
    """Texts and pictures of the robot as Python 2's SDK gives them: bytes."""
    if isinstance(value, str):
        return value if value.isascii() else to_str(to_bytes(value))
    if isinstance(value, bytes | bytearray):
        return to_str(value)
    if isinstance(value, list | tuple):
        return type(value)(map(of_robot, value))
    return {of_robot(k): of_robot(v) for k, v in value.items()} if isinstance(value, dict) else value


def _texts(value: Any, change: Callable[[str], Any]) -> Any:
    """An argument with each of its texts changed."""
    if isinstance(value, str):
        return change(value)
    if type(value) in (tuple, list):
        return type(value)(_texts(part, change) for part in value)
    if type(value) is dict:
        return {_texts(name, change): _texts(part, change) for name, part in value.items()}
    return value


def _encodings(arguments: tuple[Any, ...], named: dict[str, Any]) -> Iterator[tuple[list[Any], dict[str, Any]]]:
    """Arguments with texts as bytes: all of them, then one alone, the last first."""
    encoded = [_texts(a, to_bytes) for a in arguments]
    options = {name: _texts(a, to_bytes) for name, a in named.items()}
    if (encoded, options) != ([*arguments], named):
        yield encoded, options
    for i in reversed(range(len(arguments))):
        if isinstance(arguments[i], str) and len(arguments) > 1:
            yield [*arguments[:i], encoded[i], *arguments[i + 1 :]], named


def is_converted(function: Any) -> bool:
    """Whether a function or class is of a converted program."""
    function = getattr(function, "__func__", function)
    names = getattr(function, "__globals__", None) or vars(sys.modules.get(_module(function), sys))
    return "_python2" in names


def _module(function: Any) -> str:
    name = getattr(function, "__module__", None)
    return name if isinstance(name, str) else ""


def call(function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
    """Call a function for a program that has one type for text and bytes.

    Bytes in the result are a text. A function of Python 3 that refuses a text for bytes gets bytes.
    """
    if is_converted(function):
        return function(*arguments, **named)
    if function in _CSV and arguments and isinstance(arguments[0], _Binary):
        arguments = (io.TextIOWrapper(arguments[0], "utf-8", newline=""), *arguments[1:])
    if getattr(function, "__name__", "") == "sort" and isinstance(getattr(function, "__self__", None), list):
        arguments, named = (), _sort_options(*arguments, **named)
    if getattr(function, "__name__", "") == "Request" and _module(function) == "urllib.request":
        named = dict(zip(("url", "data", "headers"), arguments, strict=False)) | named
        arguments, named["data"] = (), _texts(named.get("data"), to_bytes)
    if _module(function) == "json":
        arguments = _texts(arguments, to_unicode)
    try:
        result = function(*arguments, **named)
    except (TypeError, ValueError, struct.error) as error:
        if not _WANTS_BYTES.search(str(error)):
            raise
        result = _with_bytes(function, arguments, named, error)
    return of_robot(result) if _module(function) in ROBOT else _results(result)


def _with_bytes(
    function: Callable[..., Any], arguments: tuple[Any, ...], named: dict[str, Any], error: Exception
) -> Any:
    """The result with bytes for texts, where the function takes them; otherwise its first error."""
    for encoded, options in _encodings(arguments, named):
        try:
            return function(*encoded, **options)
        except (TypeError, AttributeError):
            continue
    raise error


def decode(text: Any, *how: Any, **named: Any) -> Any:
    """`text.decode(encoding, errors)`: a unicode text."""
    if not isinstance(text, str):
        return text.decode(*how, **named)
    encoding, errors = _encoding(*how, **named)
    if encoding in _ESCAPED:
        return to_unicode(text).encode("latin-1", "backslashreplace").decode("unicode_escape")
    if encoding.removesuffix("_codec") in _OF_CODECS:
        return to_str(codecs.lookup(encoding).decode(to_bytes(text))[0])  # type: ignore[arg-type]
    return to_bytes(text).decode(encoding, errors)


def encode(text: Any, *how: Any, **named: Any) -> Any:
    """`text.encode(encoding, errors)`: a text of Python 2."""
    if not isinstance(text, str):
        return text.encode(*how, **named)
    encoding, errors = _encoding(*how, **named)
    if encoding in _ESCAPED:
        return to_str(to_unicode(text).encode("unicode_escape"))
    if encoding.removesuffix("_codec") in _OF_CODECS:
        return to_str(codecs.lookup(encoding).encode(to_bytes(text))[0])  # type: ignore[arg-type]
    return to_str(to_unicode(text).encode(encoding, errors))


def _encoding(encoding: Any = "utf-8", errors: Any = "strict") -> tuple[str, str]:
    return str(encoding).lower().replace("-", "_"), errors


class _TextType(type):
    def __instancecheck__(cls, value: Any) -> bool:
        return isinstance(value, str)


class Unicode(metaclass=_TextType):
    """`unicode(text, encoding)`, which gives Python 3's `str`."""

    def __new__(cls, value: Any = "", *how: Any) -> Any:
        """The text."""
        return decode(value, *how) if how else to_unicode(str(value))


def import_all(module: str, names: dict[str, Any]) -> None:
    """`from module import *` within a function; its names go to the module around it."""
    found = import_module(module, names.get("__package__"))
    public = getattr(found, "__all__", None) or [name for name in vars(found) if name[:1] != "_"]
    names.update({name: getattr(found, name) for name in public})


unichr = chr


def chr_(number: int) -> str:
    """The byte of a number."""
    return to_str(bytes([number]))


def ord_(letter: Any) -> int:
    """The number of a letter or a byte."""
    if isinstance(letter, int):
        return letter
    number = ord(letter)
    return number - 0xDC00 if 0xDC80 <= number <= 0xDCFF else number


def repr_(value: Any) -> str:
    """The source of a value, with the bytes of a text in hexadecimal."""
    return re.sub(r"\\udc([89a-f][0-9a-f])", r"\\x\1", repr(value))


def cmp_(a: Any, b: Any) -> int:
    """-1, 0 or 1."""
    return bool(a > b) - bool(a < b)


def _sort_options(
    compare: Any = None, key: Any = None, reverse: Any = False, cmp: Any = None
) -> dict[str, Any]:
    """Options of Python 3's sort from those of Python 2's, which takes a comparison."""
    compare = compare or cmp
    if compare is not None:
        ordered = cmp_to_key(compare)
        key = ordered if key is None else (lambda value, key=key: ordered(key(value)))
    return {"key": key, "reverse": reverse}


def sorted_(values: Any, *how: Any, **named: Any) -> list[Any]:
    """`sorted(values, cmp, key, reverse)`."""
    return sorted(values, **_sort_options(*how, **named))


def round_(value: float, digits: int = 0) -> float:
    """A float, halves away from zero."""
    scaled = abs(value) * 10**digits
    return math.copysign(math.floor(scaled + 0.5) / 10**digits, value)


def divide(a: Any, b: Any) -> Any:
    """A quotient as Python 2 gives it: of two integers the integer below."""
    return a // b if isinstance(a, int) and isinstance(b, int) else a / b


def less(order: str, a: Any, b: Any) -> Any:
    """`a < b` and the other orders; None is less than anything, a number less than a text."""
    function = getattr(operator, order)
    try:
        return function(a, b)
    except TypeError:
        return function(_rank(a), _rank(b))


def ordered(kind: type) -> type:
    """A class whose `__cmp__` gives its order and its equality."""
    for name in ("lt", "le", "gt", "ge", "eq", "ne"):
        if f"__{name}__" not in vars(kind):
            compare = getattr(operator, name)
            setattr(kind, f"__{name}__", lambda self, other, of=compare: of(self.__cmp__(other), 0))
    return kind


def _rank(value: Any) -> tuple[int, str]:
    if value is None:
        return 0, ""
    return (1, "") if isinstance(value, int | float) else (2, type(value).__name__)


def message(error: Any) -> Any:
    """`error.message`."""
    found = getattr(error, "message", None)
    return found if found is not None else (error.args[0] if error.args else "")


class _Binary:
    """A file opened with `b`; its lines are texts, and texts can be written."""

    def __next__(self) -> Any:
        return to_str(super().__next__())  # type: ignore[misc]

    def write(self, data: Any) -> int:
        """Write a text or bytes."""
        return int(super().write(_texts(data, to_bytes)))  # type: ignore[misc]


class _Reader(_Binary, io.BufferedReader):
    """For reading."""


class _Writer(_Binary, io.BufferedWriter):
    """For writing."""


class _Both(_Binary, io.BufferedRandom):
    """For both."""


def open_(name: Any, mode: str = "r", *_: Any, **named: Any) -> Any:
    """A file; with a path of Windows where there is none of that name."""
    if isinstance(name, str):
        name = host_path(to_unicode(name))
    if "b" in mode and not named:
        raw: Any = io.FileIO(name, mode.replace("b", "").replace("U", ""))
        return (_Both if "+" in mode else _Reader if "r" in mode else _Writer)(raw)
    reads = "ascii" if mode.startswith("r") and "+" not in mode else "utf-8"
    options = {"encoding": reads, "errors": "surrogateescape", "newline": "\n"} | named
    if "U" in mode:
        mode, options["newline"] = mode.replace("U", "") or "r", None
    return open(name, mode if "r" in mode or set(mode) & set("wax") else f"r{mode}", **options)


def host_path(name: str) -> str:
    r"""A path that is there, read as one of Windows if it is not: `data\moves.txt`."""
    other = name.replace("\\", "/")
    return (
        other
        if other != name and not os.path.exists(name) and os.path.isdir(os.path.dirname(other) or ".")
        else name
    )


NAMES: Final = {
    "chr": "chr_",
    "cmp": "cmp_",
    "file": "open_",
    "open": "open_",
    "ord": "ord_",
    "repr": "repr_",
    "round": "round_",
    "sorted": "sorted_",
    "unichr": "unichr",
    "unicode": "Unicode",
}
"""Built-in name of Python 2 -> name of its meaning in this module."""
_CSV: Final = (csv.reader, csv.writer, csv.DictReader, csv.DictWriter)


def _letters(name: str) -> Callable[..., Any]:
    return lambda text, *arguments: getattr(text, name)(*arguments)


def _join(words: Any, between: str = " ") -> str:
    return between.join(words)


_METHODS: Final = (
    *("split", "replace", "strip", "lstrip", "rstrip", "lower", "upper", "find", "rfind", "count", "zfill"),
    *("ljust", "rjust", "center", "splitlines", "index", "capitalize", "swapcase", "expandtabs"),
)
_GONE: Final[tuple[tuple[ModuleType | type, dict[str, Any]], ...]] = (
    (string, {name: _letters(name) for name in _METHODS}),
    (
        string,
        {
            "letters": string.ascii_letters,
            "lowercase": string.ascii_lowercase,
            "uppercase": string.ascii_uppercase,
        },
    ),
    (string, {"join": _join, "joinfields": _join, "atoi": int, "atof": float, "maketrans": str.maketrans}),
    (sys, {"setdefaultencoding": lambda _: None, "maxint": sys.maxsize, "exc_clear": lambda: None}),
    (os, {"getcwdu": os.getcwd, "errno": __import__("errno")}),
    (time, {"clock": time.perf_counter}),
    (threading, {"_sleep": time.sleep}),
    (threading.Thread, {"isAlive": threading.Thread.is_alive}),
    (Message, {"getheader": Message.get, "getheaders": Message.get_all}),
    (base64, {"encodestring": base64.encodebytes, "decodestring": base64.decodebytes}),
)


def put_back() -> None:
    """Give modules of Python 3 the names that Python 2 has and converted programs use."""
    for owner, names in _GONE:
        for name, value in names.items():
            if not hasattr(owner, name):
                setattr(owner, name, value)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="surrogateescape")
