"""Check plain data against msgspec types, and name the first fault's place and the expected value.

Words the faults of files, options, frames and commands.
"""

from __future__ import annotations

import difflib
import math
import re
import threading
import types
from collections.abc import Iterable
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin

import msgspec

READING_TYPES: Final = threading.RLock()
"""Held while msgspec reads a type: two threads that do so at once for the first time crash it (0.22)."""
_MAX_TEXT: Final = 600
"""Letters of a path or a reason in an error."""


class Invalid(ValueError):
    """Data that do not fit a type.

    Args:
        path: where in the data, for example `joints.LKneePitch.lower` or `position[3]`; empty: the whole.
        reason: the fault and the expected value, without a full stop.
    """

    def __init__(self, path: str, reason: str) -> None:
        path, reason = _shortened(path), _shortened(reason)
        super().__init__(f"{path}: {reason}" if path else reason)
        self.path, self.reason = path, reason


def _shortened(text: str) -> str:
    """Beginning and end of a text that is too long for a sentence."""
    return text if len(text) <= _MAX_TEXT else f"{text[: _MAX_TEXT // 2]}...{text[-_MAX_TEXT // 2 :]}"


def convert(data: Any, kind: Any, *, ignore_unknown: bool = False) -> Any:
    """Plain data as a msgspec type.

    Args:
        data: dicts, lists, numbers, text.
        kind: msgspec struct, union of tagged structs, or any type that msgspec knows.
        ignore_unknown: pass over keys that a struct does not have; otherwise each is an error with the nearest
            key as a suggestion, even where the struct itself would ignore it.

    Raises:
        Invalid: the first fault.
    """
    _check(data, kind, "", ignore_unknown)
    return _convert(data, kind, "")


def unknown_name(kind: str, name: str, known: Iterable[str]) -> str:
    """Clause for a name that is not in a list.

    Args:
        kind: of the named thing, for example `gait`.
        name: as given.
        known: all names that exist; the nearest one is suggested.
    """
    known = sorted(map(str, known))
    return f"unknown {kind} {name!r}{suggestion(name, known)}; known: {', '.join(known) or 'none'}"


def suggestion(name: str, known: Iterable[str]) -> str:
    """Clause that names the nearest of some names; empty: none is near."""
    folded = {k.casefold(): k for k in known}
    near = difflib.get_close_matches(str(name).casefold(), folded, n=1, cutoff=0.6)
    return f" (did you mean {folded[near[0]]!r}?)" if near else ""


_WORDS: Final = (
    # A bound of this size only keeps infinities out.
    (re.compile(r"`float` [<>]= -?(?:\d{20,}\.0|\d[.\d]*e\+?\d+)"), "a finite number"),
    (re.compile(r"`str` matching regex .*0-9a-f.*", re.DOTALL), "64 hexadecimal digits in lower case"),
    (re.compile(r"`str` matching regex .*", re.DOTALL), "1 to 64 letters, digits, `_` or `-`"),
)
"""Plain words for msgspec's bounds. The only patterns of the product are those of keys and of names."""
_TYPES: Final = {
    "int": "a whole number",
    "float": "a number",
    "str": "text",
    "bool": "true or false",
    "array": "a list",
    "object": "a table",
    "null": "nothing",
}
_UNION: Final = re.compile(rf"`((?:{'|'.join(_TYPES)})(?: \| (?:{'|'.join(_TYPES)}))*)`")


def _type_words(union: re.Match[str]) -> str:
    """Plain words for msgspec's types; that a file may leave a value out is said by none."""
    names = union[1].split(" | ")
    return " or ".join(_TYPES[name] for name in names if name != "null" or len(names) == 1)


def _convert(value: Any, kind: Any, path: str) -> Any:
    try:
        with READING_TYPES:
            return msgspec.convert(value, kind, strict=True)
    except (msgspec.ValidationError, OverflowError) as error:
        # A check of the struct itself may name a place below this one; our path is the more exact.
        reason = str(error).split(" - at `$")[0]
        for pattern, words in _WORDS:
            reason = pattern.sub(words, reason)
        reason = _UNION.sub(_type_words, reason)
        if reason.startswith("Expected") and ", got " not in reason and isinstance(value, (int, float)):
            reason = f"{reason}, got {value}"
        raise Invalid(path, reason[:1].lower() + reason[1:]) from error


def _check(value: Any, kind: Any, path: str, ignore: bool) -> None:
    """Traverse value and type together, so that the error names the exact place."""
    while get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    if isinstance(value, float) and not math.isfinite(value):
        raise Invalid(path, f"is {value}, but must be a finite number")
    if get_origin(kind) in (Union, types.UnionType):
        kind = _member(value, kind, path)
    origin = get_origin(kind)
    if origin is Literal and isinstance(value, str) and value not in get_args(kind):
        raise Invalid(path, unknown_name("value", value, get_args(kind)))
    if isinstance(value, dict) and isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        _check_struct(value, kind, path, ignore)
    elif isinstance(value, dict) and origin is dict:
        key_kind, value_kind = get_args(kind)
        for key, item in value.items():
            if get_origin(key_kind) is Literal and key not in get_args(key_kind):
                raise Invalid("", unknown_name("key", _join(path, key), get_args(key_kind)))
            _check_item(item, value_kind, _join(path, key), ignore)
    elif isinstance(value, list) and origin in (list, tuple):
        for i, (item, item_kind) in enumerate(zip(value, _item_kinds(kind, len(value)), strict=False)):
            _check_item(item, item_kind, f"{path}[{i}]", ignore)


def _check_struct(value: dict[str, Any], kind: type[msgspec.Struct], path: str, ignore: bool) -> None:
    fields = {field.encode_name: field for field in msgspec.structs.fields(kind)}
    config = kind.__struct_config__
    known = {*fields, config.tag_field}
    for key in () if ignore else value:
        if key not in known:
            missing = [k for k in fields if k not in value] or list(fields)
            hint = suggestion(str(key), missing) or f"; known keys: {', '.join(fields) or 'none'}"
            raise Invalid("", f"unknown key {_join(path, key)!r}{hint}")
    for key, field in fields.items():
        if key in value:
            _check_item(value[key], field.type, _join(path, key), ignore)
        elif field.required:
            raise Invalid("", f"missing key {_join(path, key)!r}")


def _check_item(value: Any, kind: Any, path: str, ignore: bool) -> None:
    _check(value, kind, path, ignore)
    _convert(value, kind, path)


def _member(value: Any, kind: Any, path: str) -> Any:
    """Member of a union by the table's tag; the union itself without a usable tag."""
    others = [k for k in get_args(kind) if k is not types.NoneType]
    if len(others) == 1 and value is not None:
        return others[0]
    structs = [k for k in others if isinstance(k, type) and issubclass(k, msgspec.Struct)]
    if not isinstance(value, dict) or not structs:
        return kind
    if len(structs) == 1 and structs[0].__struct_config__.tag_field is None:
        return structs[0]
    tags = {str(k.__struct_config__.tag): k for k in structs}
    field = structs[0].__struct_config__.tag_field or "type"
    if field not in value:
        raise Invalid("", f"missing key {_join(path, field)!r}; one of {', '.join(sorted(tags))}")
    if str(value[field]) not in tags:
        raise Invalid(_join(path, field), unknown_name("value", str(value[field]), tags))
    return tags[str(value[field])]


def _item_kinds(kind: Any, count: int) -> Iterable[Any]:
    kinds = get_args(kind)
    if get_origin(kind) is list or (len(kinds) == 2 and kinds[1] is Ellipsis):
        return (kinds[0],) * count
    return kinds


def _join(path: str, key: str) -> str:
    return f"{path}.{key}" if path else str(key)
