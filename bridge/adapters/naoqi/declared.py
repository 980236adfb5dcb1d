"""Declared methods: binding, argument checks, error sentences, help and documentation by one decorator.

`@offers("ALMotion.setAngles", kind="joints")` offers a method of a class under its NAOqi name; its parameters'
annotations are the checks. A name that begins with a dot belongs to the service `self.service`. `methods.toml`
has refusals, omissions, and the methods that are data: constant answers, settings, and checks without effect.
"""

from __future__ import annotations

import inspect
import logging
import math
import re
import types
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
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
    """A name or a number of a list."""

    noun: str
    known: Collection[Any] = field(repr=False)

    def __call__(self, value: Any, label: str) -> Any:
        """Check a name or a number."""
        names = all(isinstance(one, str) for one in self.known)
        if (text(value, label) if names else number(value, label)) not in self.known:
            known = [str(one) for one in self.known]
            raise NaoqiRefused(f"{label.partition(':')[0]}: {unknown_name(self.noun, str(value), known)}.")
        return value

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


class _Offer(NamedTuple):
    names: tuple[str, ...]
    kind: Kind
    begins_walk: bool
    preset: dict[str, Any]


def offers(*names: str, kind: Kind = "read", begins_walk: bool = False, **preset: Any) -> Callable[[F], F]:
    """Offer a method under NAOqi names, for example `ALMotion.setAngles`.

    `.method` belongs to the object's own `service`; for one that begins a walk the conditions of a walk apply.
    `preset` has the keyword arguments by which one function serves several methods.
    """

    def mark(function: F) -> F:
        function.__dict__.setdefault("offers", []).append(_Offer(names, kind, begins_walk, preset))
        return function

    return mark


class Setting:
    """A value that programs set and read, a descriptor of its class that offers both methods.

    Args:
        name: of the methods, for example `ALTextToSpeech.Volume` for `setVolume` and `getVolume`.
        inert: without effect here, which the log says once.
        reader: `get`, or `is`.
        of_part: a part's name is the first argument; each part has its own value.
    """

    def __init__(
        self,
        name: str,
        default: Any,
        kind: Any,
        *,
        inert: bool = False,
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
            if inert and given not in (False, None) and self._attribute not in owner.__dict__:
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
        _declare(put, of | {"value": kind})
        _declare(get, of)
        names = (f"{service}.{method}" for method in (f"set{setting}", *also.split()))
        self.functions = offers(*names)(put), offers(f"{service}.{reader}{setting}")(get)

    def __set_name__(self, _: type, attribute: str) -> None:
        self._attribute = attribute

    def _parts(self, owner: Any) -> dict[str, Any]:
        parts: dict[str, Any] = owner.__dict__.setdefault(f"{self._attribute} of parts", {})
        return parts

    def __get__(self, owner: Any, _: Any = None) -> Any:
        return self if owner is None else owner.__dict__.get(self._attribute, self._default)

    def __set__(self, owner: Any, value: Any) -> None:
        owner.__dict__[self._attribute] = value


def _declare(function: Any, parameters: Mapping[str, Any], optional: Collection[str] = ()) -> None:
    """Declare the parameters of a function of an object with `*arguments`: name -> type."""
    function.__annotations__ = dict(parameters)
    kind, empty = inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.empty
    function.__signature__ = inspect.Signature(
        [inspect.Parameter(n, kind, default=None if n in optional else empty) for n in ("owner", *parameters)]
    )


class Parameters:
    """Numbers that programs set and read by their names, as `Setting`.

    Args:
        service: of the methods.
        table: name -> smallest, largest and initial value.
    """

    def __init__(self, service: str, table: Mapping[str, tuple[float, float, float]]) -> None:
        self._initial = {name: start for name, (_, _, start) in table.items()}

        def put(owner: Any, name: Any, value: Any) -> None:
            self.__get__(owner)[name] = number(value, f"{service}.setParameter: {name}", *table[name][:2])

        def get(owner: Any, name: Any) -> float:
            return self.__get__(owner)[name]  # type: ignore[no-any-return]

        of: dict[str, Any] = {"parameter": Annotated[str, OneOf("parameter", table)]}
        _declare(put, of | {"value": float})
        _declare(get, of)
        self.functions = offers(f"{service}.setParameter")(put), offers(f"{service}.getParameter")(get)

    def __get__(self, owner: Any, _: Any = None) -> Any:
        return self if owner is None else owner.__dict__.setdefault("parameters", dict(self._initial))


_MAX_PARTS: Final = 1000


@dataclass(frozen=True)
class Method:
    """One method of a service."""

    service: str
    name: str
    call: Callable[..., Any]
    kind: Kind = "read"
    begins_walk: bool = False
    refuses: bool = False

    @property
    def partly(self) -> str:
        """Omissions and assumptions; empty: none."""
        known = [VENDOR_METHODS[service] for service in (self.service, MODULE) if service in VENDOR_METHODS]
        rows = (row for of in known for row in of.partly.items())
        return next((why for why, methods in rows if self.name in methods), "")

    @cached_property
    def signature(self) -> inspect.Signature:
        """Its parameters."""
        return inspect.signature(self.call)

    def require_count(self, arguments: Sequence[Any]) -> None:
        """Check the number of arguments."""
        try:
            self.signature.bind(*arguments)
        except TypeError as error:
            raise NaoqiRefused(
                f"{self.service}.{self.name}: {len(arguments)} arguments do not fit ({as_vendor(str(error))})."
            ) from None

    @cached_property
    def types(self) -> Mapping[str, Any]:
        """Annotation of each parameter that a program gives."""
        bound = getattr(self.call, "func", self.call)
        function = inspect.unwrap(getattr(bound, "__func__", bound))
        hints = get_type_hints(function, include_extras=True)
        return {
            name: hints.get(name, Any)
            for name, p in self.signature.parameters.items()
            if p.kind is not p.KEYWORD_ONLY
        }

    @cached_property
    def _checks(self) -> list[tuple[str, Check, bool]]:
        owner = getattr(getattr(self.call, "func", self.call), "__self__", None)
        return [
            (
                f"{self.service}.{self.name}: {as_vendor(name)}",
                _check(kind, owner),
                self.signature.parameters[name].kind is _VARIABLE,
            )
            for name, kind in self.types.items()
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
        first = (inspect.getdoc(getattr(self.call, "func", self.call)) or "").partition("\n")[0]
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
                    bound: Any = types.MethodType(function, owner)
                    bound = partial(bound, **offer.preset) if offer.preset else bound
                    for service, _, method in (name.rpartition(".") for name in offer.names):
                        yield Method(service or owner.service, method, bound, offer.kind, offer.begins_walk)


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
    simple: dict[Any, Check] = {float: number, bool: flag, str: text, dict: _mapping}
    return simple.get(kind, lambda value, _: value)


_OF: Final = {str: " of names", float: " of numbers"}


class VendorMethods(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Methods of one service of the vendor's, as far as they are data; see `methods.toml`."""

    refused: list[str] = []
    no: dict[str, str] = {}
    partly: dict[str, list[str]] = {}
    settings: dict[str, Any] = {}
    events: dict[str, Any] = {}
    answers: dict[str, Any] = {}
    idle: list[str] = []


VENDOR_METHODS: Final = convert(read_toml(Path(__file__).with_name("methods.toml")), dict[str, VendorMethods])
"""By service."""
MODULE: Final = "ALModule"
"""Stands for every service."""
_TYPES: Final = {"bool": bool, "str": str, "number": float, "dict": dict, "any": Any}


def rows() -> object:
    """An object that offers the settings, constant answers and methods without effect of all services."""
    found: dict[str, Any] = {}
    for service, of in VENDOR_METHODS.items():
        for row, default in of.settings.items():
            reader, name, part = re.fullmatch(r"(get|is)(\w+?)(\(name\))?", row).groups()  # type: ignore[union-attr]
            initial = None if default == {} else default
            kind = {bool: bool, str: str}.get(type(default), Any if initial is None else float)
            more: Any = {"reader": reader, "of_part": bool(part), "returns": True}
            found[f"{service}.{row}"] = Setting(f"{service}.{name}", initial, kind, inert=True, **more)
        for row, answer in {**of.answers, **dict.fromkeys(of.idle)}.items():
            found[f"{service}.{row}"] = _constant(service, row, answer)
    return type("Rows", (), found)()


def _constant(service: str, row: str, answer: Any) -> Callable[..., Any]:
    """A method `name(parameter: type, ...)` that always returns the same."""
    name, _, rest = row.removesuffix(")").partition("(")
    pieces = [piece.replace(":", " ").split() for piece in rest.split(", ") if piece]
    kinds = {n: OneOf(n, kind.split("|")) if "|" in kind else _TYPES[kind] for n, kind, *_ in pieces}

    def method(*_: Any) -> Any:
        return answer

    parameters = {n: Annotated[str, kind] if isinstance(kind, OneOf) else kind for n, kind in kinds.items()}
    _declare(method, parameters, [piece[0] for piece in pieces if "=" in piece])
    return offers(f"{service}.{name}")(method)


def refusals(service: str, offered: Collection[str]) -> dict[str, Method]:
    """The vendor's methods of a service that this one refuses."""
    known = VENDOR_METHODS.get(service, VendorMethods())
    default = f"{service} offers {', '.join(sorted(offered)) or 'nothing'}"
    return {
        name: _refusal(service, name, known.no.get(name, known.no.get("*", default))) for name in known.refused
    }


def _refusal(service: str, method: str, reason: str) -> Method:
    def refuse(*_: Any) -> None:
        raise NaoqiRefused(f"{service}.{method} is not offered by nao-hil: {reason}.")

    return Method(service, method, refuse, refuses=True)


def number(value: Any, label: str, lower: float = -math.inf, upper: float = math.inf) -> float:
    """A finite number within a range."""
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
    """True or False, also as 1 or 0."""
    if value not in (True, False):
        raise NaoqiRefused(f"{label} is {value!r:.60}; True or False is expected.")
    return bool(value)


def text(value: Any, label: str) -> str:
    """A name."""
    if not isinstance(value, str):
        raise NaoqiRefused(f"{label} is {value!r:.60}; a name is expected.")
    return value


def _mapping(value: Any, label: str) -> dict[Any, Any]:
    if not isinstance(value, dict):
        raise NaoqiRefused(f"{label} is {value!r:.60}; {{name: value, ...}} is expected.")
    return value


def pairs(value: Any, label: str) -> list[list[Any]]:
    """A list of names, each with its value."""
    if not isinstance(value, list) or not all(isinstance(row, list) and len(row) == 2 for row in value):
        raise NaoqiRefused(f"{label}: {value!r:.60} was given; [[name, value], ...] is expected.")
    return value


def one_each(value: Any, count: int, label: str) -> list[float]:
    """A number for each joint: one for all, or a list of as many."""
    if not isinstance(value, list):
        return [number(value, label)] * count
    if len(value) != count:
        raise NaoqiRefused(f"{label} has {len(value)} entries for {count} joints; one for each is expected.")
    return [number(entry, f"{label}[{i}]") for i, entry in enumerate(value)]


def lists_each(value: Any, count: int, label: str) -> list[list[float]]:
    """A list of numbers for each joint, out of one number, one list, or a list of numbers or lists."""
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
