"""Declared methods: binding, argument checks, error sentences, help and documentation by one decorator.

`@offers("ALMotion.setAngles", kind="joints")` offers a method of a class under its NAOqi name; its parameters'
annotations are the checks. A name that begins with a dot belongs to the service `self.service`. The vendor's
methods that are not offered are in `refused.toml`.
"""

from __future__ import annotations

import inspect
import logging
import math
import re
import types
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import (
    Annotated,
    Any,
    Final,
    Literal,
    NamedTuple,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import msgspec

from bridge.config import read_toml
from bridge.errors import NaoqiRefused
from bridge.validation import convert, unknown_name

logger = logging.getLogger(__name__)

F = TypeVar("F", bound=Callable[..., Any])
Kind = Literal["read", "joints", "posture", "walk"]
"""`read` needs nothing; `joints` commands them, and is refused during a walk; `posture` ends a walk; `walk` is
for the walker."""
Check = Callable[[Any, str], Any]
"""`(value, name of the argument) -> the checked value`; raises `NaoqiRefused`."""

MAX_DURATION: Final = 3600.0
"""s that one interpolation may take."""
MIN_SPEED_FRACTION: Final = 1e-4
"""Fraction of the maximum speed: a joint's whole range takes about an hour."""
INERT: Final = "remembered and read back, without effect"
"""Omissions of a setting."""


class Range(NamedTuple):
    """Range of a number."""

    lower: float = -math.inf
    upper: float = math.inf
    unit: str = ""

    def __call__(self, value: Any, label: str) -> float:
        """Check a number."""
        number(value, label, self.lower, self.upper)
        return value  # type: ignore[no-any-return]

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return f"a number from {self.lower:g} to {self.upper:g}{unit}"


@dataclass(frozen=True, eq=False)
class OneOf:
    """A name of a list."""

    noun: str
    known: Collection[str] = field(repr=False)

    def __call__(self, value: Any, label: str) -> str:
        """Check a name."""
        if text(value, label) not in self.known:
            raise NaoqiRefused(f"{label.partition(':')[0]}: {unknown_name(self.noun, value, self.known)}.")
        return str(value)

    def __str__(self) -> str:
        return f"one of {', '.join(map(str, self.known))}"


@dataclass(frozen=True)
class Vector:
    """A list of numbers with names."""

    names: str
    """For example `x, y, z`."""
    lower: float = -math.inf
    upper: float = math.inf
    unit: str = ""

    def __call__(self, value: Any, label: str) -> list[float]:
        """Check a list."""
        if not isinstance(value, list) or len(value) != len(self.names.split(",")):
            raise NaoqiRefused(f"{label} is {value!r:.60}; {self} is expected.")
        return [number(one, f"{label}[{i}]", self.lower, self.upper) for i, one in enumerate(value)]

    def __str__(self) -> str:
        return f"[{self.names}]{f' in {self.unit}' if self.unit else ''}"


class Choice:
    """A number of a list.

    Args:
        values: the list.
    """

    def __init__(self, *values: int) -> None:
        self._values = values

    def __call__(self, value: Any, label: str) -> int:
        """Check a number."""
        if isinstance(value, bool) or value not in self._values:
            raise NaoqiRefused(f"{label} is {value!r:.40}; {self} is expected.")
        return int(value)

    def __str__(self) -> str:
        return f"one of {', '.join(map(str, self._values))}"


class Own(NamedTuple):
    """A check by a method `(value) -> value` of the service's object, or of one of its parts."""

    path: str

    def of(self, owner: object) -> Check:
        """The check of one object."""
        for part in self.path.split("."):
            owner = getattr(owner, part)
        check: Any = owner
        return lambda value, _: check(value)

    def __str__(self) -> str:
        return self.path.rpartition(".")[2].strip("_").replace("_", " ")


@dataclass(frozen=True)
class _Offer:
    names: tuple[str, ...]
    kind: Kind
    partly: str
    begins_walk: bool


def offers(*names: str, kind: Kind = "read", partly: str = "", begins_walk: bool = False) -> Callable[[F], F]:
    """Offer a method under NAOqi names, for example `ALMotion.setAngles`.

    Args:
        names: service and method; `.method` belongs to the object's own `service`.
        kind: its need of the robot.
        partly: omissions and assumptions; empty: none.
        begins_walk: the conditions of a walk apply.
    """

    def mark(function: F) -> F:
        offer = _Offer(names, kind, partly, begins_walk)
        function.__dict__.setdefault("offers", []).append(offer)
        return function

    return mark


class Setting:
    """A value that programs set and read, a descriptor of its class that offers both methods.

    Args:
        name: of the methods, for example `ALTextToSpeech.Volume` for `setVolume` and `getVolume`.
        default: initial value.
        kind: its type with its range, as an annotation.
        partly: of the setter.
        reader: `get`, or `is`.
        returns: result of the setter.
        of_part: a part's name is the first argument; each part has its own value.
        also: further names of the setter.
    """

    def __init__(
        self,
        name: str,
        default: Any,
        kind: Any,
        partly: str = "",
        *,
        reader: str = "get",
        returns: Any = None,
        of_part: bool = False,
        also: str = "",
    ) -> None:
        service, _, setting = name.rpartition(".")
        self._default, warned = default, f"set{setting} was called; it is remembered and has no effect"

        def put(owner: Any, *arguments: Any) -> Any:
            """Store the last argument; the one before it names the part."""
            given = arguments[-1]
            if partly == INERT and given not in (False, None) and self._attribute not in owner.__dict__:
                logger.warning("%s.%s", service or owner.service, warned)
                self.__set__(owner, default)
            parts = self._parts(owner)
            if not of_part:
                self.__set__(owner, given)
            elif arguments[0] in parts or len(parts) < _MAX_PARTS:
                parts[arguments[0]] = given
            return returns

        def get(owner: Any, *part: Any) -> Any:
            return self._parts(owner).get(part[0], default) if part else self.__get__(owner)

        of: dict[str, Any] = {"name": str} if of_part else {}
        put.__signature__ = _signature(put, of | {"value": kind})  # type: ignore[attr-defined]
        get.__signature__ = _signature(get, of)  # type: ignore[attr-defined]
        names = (f"{service}.{method}" for method in (f"set{setting}", *also.split()))
        self.functions = offers(*names, partly=partly)(put), offers(f"{service}.{reader}{setting}")(get)

    def __set_name__(self, _: type, attribute: str) -> None:
        self._attribute = attribute

    def _parts(self, owner: Any) -> dict[str, Any]:
        parts: dict[str, Any] = owner.__dict__.setdefault(f"{self._attribute} of parts", {})
        return parts

    def __get__(self, owner: Any, _: Any = None) -> Any:
        return self if owner is None else owner.__dict__.get(self._attribute, self._default)

    def __set__(self, owner: Any, value: Any) -> None:
        owner.__dict__[self._attribute] = value


def _signature(function: Callable[..., Any], of: Mapping[str, Any]) -> inspect.Signature:
    """Declare the parameters of a function of an object with `*arguments`; their signature."""
    function.__annotations__ = dict(of)
    kind = inspect.Parameter.POSITIONAL_ONLY
    return inspect.Signature([inspect.Parameter(name, kind) for name in ("owner", *of)])


_MAX_PARTS: Final = 1000


@dataclass(frozen=True)
class Method:
    """One method of a service."""

    service: str
    name: str
    call: Callable[..., Any]
    kind: Kind = "read"
    partly: str = ""
    begins_walk: bool = False
    refuses: bool = False

    @cached_property
    def signature(self) -> inspect.Signature:
        """Its parameters."""
        return inspect.signature(self.call)

    @cached_property
    def _counts(self) -> tuple[int, float]:
        """Fewest and most arguments."""
        kinds = [p for p in self.signature.parameters.values() if p.kind is not p.KEYWORD_ONLY]
        single = [p for p in kinds if p.kind is not _VARIABLE]
        return sum(p.default is p.empty for p in single), math.inf if len(single) < len(kinds) else len(single)

    def require_count(self, arguments: Sequence[Any]) -> None:
        """Check the number of arguments.

        Raises:
            NaoqiRefused: too few or too many.
        """
        fewest, most = self._counts
        if fewest <= len(arguments) <= most:
            return
        try:
            self.signature.bind(*arguments)
        except TypeError as error:
            raise NaoqiRefused(
                f"{self.service}.{self.name}: {len(arguments)} arguments do not fit ({as_vendor(str(error))})."
            ) from None

    @cached_property
    def types(self) -> Mapping[str, Any]:
        """Annotation of each parameter."""
        function = inspect.unwrap(getattr(self.call, "__func__", self.call))
        hints = get_type_hints(function, include_extras=True)
        return {name: hints.get(name, Any) for name in self.signature.parameters}

    @cached_property
    def _checks(self) -> list[tuple[str, Check, bool]]:
        owner = getattr(self.call, "__self__", None)
        return [
            (
                f"{self.service}.{self.name}: {as_vendor(name)}",
                _check(kind, owner),
                self.signature.parameters[name].kind is _VARIABLE,
            )
            for name, kind in self.types.items()
            if self.signature.parameters[name].kind is not inspect.Parameter.KEYWORD_ONLY
        ]

    def __call__(self, arguments: Sequence[Any]) -> Any:
        """Check the arguments and carry the call out.

        Raises:
            NaoHilError: one sentence.
        """
        checked: list[Any] = []
        for label, check, rest in self._checks:
            for value in arguments[len(checked) :] if rest else arguments[len(checked) : len(checked) + 1]:
                checked.append(check(value, label))
        return self.call(*checked)

    @property
    def help(self) -> list[Any]:
        """`[name, [[parameter, description], ...], ...]`, as `getMethodHelp`."""
        first = (inspect.getdoc(self.call) or "").partition("\n")[0]
        return [self.name, [[as_vendor(name), describe(kind)] for name, kind in self.types.items()], first, ""]


_VARIABLE: Final = inspect.Parameter.VAR_POSITIONAL


def declared(*owners: object) -> dict[str, dict[str, Method]]:
    """Methods declared by the classes of some objects: service -> name -> method."""
    table: dict[str, dict[str, Method]] = {}
    for owner in owners:
        for method in _methods(owner):
            table.setdefault(method.service, {})[method.name] = method
    return table


def _methods(owner: Any) -> Iterator[Method]:
    for kind in reversed(type(owner).__mro__):
        for value in vars(kind).values():
            for function in getattr(value, "functions", (value,)):
                for offer in getattr(function, "offers", ()):
                    bound = types.MethodType(function, owner)
                    for service, _, method in (name.rpartition(".") for name in offer.names):
                        partly = offer.partly or getattr(owner, "left_out", {}).get(method, "")
                        declaration = (service or owner.service, method, bound, offer.kind, partly)
                        yield Method(*declaration, offer.begins_walk)


def as_vendor(words: str) -> str:
    """Names of arguments in the vendor's style: `useSensors` for `use_sensors`."""
    return re.sub(r"(?<=[a-z])_([a-z])", lambda letter: letter[1].upper(), words)


def describe(kind: Any) -> str:
    """Description of an annotation, for the help."""
    if get_origin(kind) is Annotated:
        return ", ".join(
            str(part) if not inspect.isfunction(part) else part.__name__ for part in get_args(kind)[1:]
        )
    names = {float: "a number", int: "a whole number", bool: "True or False", str: "a name"}
    if get_origin(kind) is list:
        return f"a list, each {describe(get_args(kind)[0])}" if get_args(kind) else "a list"
    return names.get(kind, "")


def _check(kind: Any, owner: object) -> Check:
    """The check of an annotation."""
    origin, args = get_origin(kind), get_args(kind)
    if origin is Annotated:
        steps = [step.of(owner) if isinstance(step, Own) else step for step in args[1:]]
        if all(isinstance(step, Range | OneOf) for step in args[1:]):  # refinements of the type's own check
            steps.insert(0, _check(args[0], owner))

        def all_steps(value: Any, label: str) -> Any:
            for step in steps:
                value = step(value, label)
            return value

        return all_steps
    if origin in (Union, types.UnionType) and type(None) in args:
        inner = _check(next(arg for arg in args if arg is not type(None)), owner)
        return lambda value, label: None if value is None else inner(value, label)
    if origin is list:
        item = _check(args[0], owner)

        def of_list(value: Any, label: str) -> list[Any]:
            if not isinstance(value, list):
                raise NaoqiRefused(f"{label} is {value!r:.60}; a list{_OF.get(args[0], '')} is expected.")
            return [item(one, f"{label}[{i}]") for i, one in enumerate(value)]

        return of_list
    if kind is int:
        return lambda value, label: round(number(value, label))
    simple: dict[Any, Check] = {float: number, bool: flag, str: text}
    return simple.get(kind, lambda value, _: value)


_OF: Final = {str: " of names", float: " of numbers"}


class Refused(msgspec.Struct, frozen=True):
    """Methods of the vendor's service that are not offered."""

    methods: list[str] = []
    no: dict[str, str] = {}
    """Method -> reason; `*`: all others."""


REFUSED: Final = convert(read_toml(Path(__file__).with_name("refused.toml")), dict[str, Refused])
"""By service."""


def refusals(service: str, offered: Collection[str]) -> dict[str, Method]:
    """The vendor's methods of a service that this one refuses.

    Args:
        service: name of the service.
        offered: its offered methods.
    """
    entry = REFUSED.get(service, Refused())
    default = f"{service} offers {', '.join(sorted(offered)) or 'nothing'}"
    return {
        name: _refusal(service, name, entry.no.get(name, entry.no.get("*", default))) for name in entry.methods
    }


def _refusal(service: str, method: str, reason: str) -> Method:
    def refuse(*_: Any) -> None:
        raise NaoqiRefused(f"{service}.{method} is not offered by nao-hil: {reason}.")

    return Method(service, method, refuse, refuses=True)


def number(value: Any, label: str, lower: float = -math.inf, upper: float = math.inf) -> float:
    """A finite number within a range.

    Raises:
        NaoqiRefused: anything else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise NaoqiRefused(f"{label} is {value!r:.60}; a finite number is expected.")
    if not lower <= value <= upper:
        raise NaoqiRefused(f"{label} is {value:g}; a number from {lower:g} to {upper:g} is expected.")
    return float(value)


def clipped(value: Any, label: str, lower: float, upper: float) -> float:
    """A finite number, clipped to its limits with a warning, as robots do: programs give speeds in per cent.

    Raises:
        NaoqiRefused: no number.
    """
    given = number(value, label)
    limit = max(lower, min(upper, given))
    if given != limit:
        logger.warning("%s is %g; it is clipped to %g", label, given, limit)
    return limit


def fraction(value: Any, label: str) -> float:
    """A fraction of the maximum speed, above 0 and up to 1, clipped to it.

    Raises:
        NaoqiRefused: anything else, or less than `MIN_SPEED_FRACTION`.
    """
    speed = clipped(value, label, -math.inf, 1.0)
    if speed < MIN_SPEED_FRACTION:
        raise NaoqiRefused(
            f"{label} is {speed:g}; a fraction above 0 ({MIN_SPEED_FRACTION:g} at least) "
            "and up to 1 is expected."
        )
    return speed


def flag(value: Any, label: str) -> bool:
    """True or False, also as 1 or 0.

    Raises:
        NaoqiRefused: anything else.
    """
    if value not in (True, False):
        raise NaoqiRefused(f"{label} is {value!r:.60}; True or False is expected.")
    return bool(value)


def text(value: Any, label: str) -> str:
    """A name.

    Raises:
        NaoqiRefused: anything else.
    """
    if not isinstance(value, str):
        raise NaoqiRefused(f"{label} is {value!r:.60}; a name is expected.")
    return value


def pairs(value: Any, label: str) -> list[list[Any]]:
    """A list of names, each with its value.

    Raises:
        NaoqiRefused: anything else.
    """
    if not isinstance(value, list) or not all(isinstance(row, list) and len(row) == 2 for row in value):
        raise NaoqiRefused(f"{label}: {value!r:.60} was given; [[name, value], ...] is expected.")
    return value


def one_each(value: Any, count: int, label: str) -> list[float]:
    """A number for each joint: one for all, or a list of as many.

    Raises:
        NaoqiRefused: anything else.
    """
    if not isinstance(value, list):
        return [number(value, label)] * count
    if len(value) != count:
        raise NaoqiRefused(f"{label} has {len(value)} entries for {count} joints; one for each is expected.")
    return [number(entry, f"{label}[{i}]") for i, entry in enumerate(value)]


def lists_each(value: Any, count: int, label: str) -> list[list[float]]:
    """A list of numbers for each joint, out of one number, one list, or a list of numbers or lists.

    Raises:
        NaoqiRefused: anything else.
    """
    if not isinstance(value, list):
        return [[number(value, label)] for _ in range(count)]
    if count == 1 and not any(isinstance(entry, list) for entry in value):
        return [[number(entry, f"{label}[{i}]") for i, entry in enumerate(value)]]
    if len(value) != count:
        raise NaoqiRefused(f"{label} has {len(value)} entries for {count} joints; one for each is expected.")
    return [
        [number(item, f"{label}[{i}][{j}]") for j, item in enumerate(entry)]
        if isinstance(entry, list)
        else [number(entry, f"{label}[{i}]")]
        for i, entry in enumerate(value)
    ]


def require_times(times: Sequence[Sequence[float]], values: Sequence[Sequence[float]], method: str) -> None:
    """Check that each joint has as many times as values, above 0 and increasing.

    Raises:
        NaoqiRefused: names the joint's place in the list.
    """
    for i, (moments, targets) in enumerate(zip(times, values, strict=True)):
        if len(moments) != len(targets) or not moments:
            raise NaoqiRefused(
                f"{method}: entry {i} has {len(targets)} values and {len(moments)} times; one time for each "
                "value is expected."
            )
        if any(a >= b for a, b in zip([0.0, *moments], moments, strict=False)) or moments[-1] > MAX_DURATION:
            raise NaoqiRefused(
                f"{method}: times of entry {i} are {moments!r:.60}; increasing ones above 0 and up to "
                f"{MAX_DURATION:g} s are expected."
            )


Fraction = Annotated[float, fraction]
"""Fraction of the maximum speed, above 0 and up to 1."""
Duration = Annotated[float, Range(0.0, MAX_DURATION, "s")]
Pairs = Annotated[list[list[Any]], pairs]
"""`[[name, value], ...]`"""
