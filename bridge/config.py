"""Configuration files: TOML in, a checked msgspec struct out, or one sentence that says what is wrong where.

Used for every file a person may write: bodies, gaits, wear profiles, scenarios. A key nobody knows is an
error with a suggestion, whether or not the struct forbids unknown fields: a silently ignored misspelling
would be a wrong number in an experiment.
"""

from __future__ import annotations

import difflib
import math
import sys
import types
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeVar, Union, get_args, get_origin

import msgspec

from bridge.errors import ConfigurationError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

T = TypeVar("T", bound=msgspec.Struct)


def load_toml(path: str | Path, kind: type[T]) -> T:
    """Read one TOML file as a struct.

    Args:
        path: the file.
        kind: msgspec struct that names every allowed key and its type.

    Raises:
        ConfigurationError: unreadable, not TOML, or not a `kind`; names the file and the key.
    """
    return from_dict(read_toml(path), str(path), kind)


def read_toml(path: str | Path) -> dict[str, Any]:
    """Read one TOML file of whatever kind.

    Raises:
        ConfigurationError: unreadable, or not TOML.
    """
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise ConfigurationError(
            f"{path}: cannot be read ({error.strerror}); give a readable TOML file"
        ) from error
    except ValueError as error:
        raise ConfigurationError(f"{path}: is not a UTF-8 text file ({error}); TOML is UTF-8") from error
    return _parsed(text, str(path))


def parse_toml(text: str, where: str, kind: type[T]) -> T:
    """TOML text as a struct; `where` (a file name) begins every error message.

    Raises:
        ConfigurationError: not TOML, or not a `kind`.
    """
    return from_dict(_parsed(text, where), where, kind)


def _parsed(text: str, where: str) -> dict[str, Any]:
    try:
        data: dict[str, Any] = tomllib.loads(text)
    except RecursionError as error:
        raise ConfigurationError(f"{where}: is nested too deeply to be read") from error
    except ValueError as error:  # TOMLDecodeError, and numbers Python refuses to read
        raise ConfigurationError(f"{where}: is not valid TOML: {error}") from error
    return data


def from_dict(data: dict[str, Any], where: str, kind: type[T]) -> T:
    """As `parse_toml`, for data already read (a table of a larger file, command-line options)."""
    _check(data, kind, "", where)
    config: T = _convert(data, kind, "", where)
    return config


def unknown_name(what: str, name: str, known: Iterable[str]) -> str:
    """Sentence for a name that is not in a list: the name, the nearest known one, and the list."""
    known = sorted(map(str, known))
    return f"unknown {what} {name!r}{_did_you_mean(name, known)}; known: {', '.join(known) or 'none'}"


def _did_you_mean(name: str, known: Iterable[str]) -> str:
    folded = {k.casefold(): k for k in known}
    near = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=0.5)
    return f", did you mean {folded[near[0]]!r}?" if near else ""


_IN_WORDS: Final = {
    "int": "a whole number",
    "float": "a number",
    "str": "text",
    "bool": "true or false",
    "array": "a list",
    "object": "a table",
    "null": "nothing",
}
"""What a person who writes a file calls msgspec's types."""


def _convert(value: Any, kind: Any, path: str, where: str) -> Any:
    try:
        return msgspec.convert(value, kind, strict=True)
    except (msgspec.ValidationError, OverflowError) as error:
        # A check of the struct itself may name a place below this one; our path is the more exact.
        reason = str(error).split(" - at `$")[0]
        for name, words in _IN_WORDS.items():
            reason = reason.replace(f"`{name}`", words)
        raise ConfigurationError(f"{where}: {path or 'the file'}: {reason[:1].lower()}{reason[1:]}") from error


def _check(value: Any, kind: Any, path: str, where: str) -> None:
    """Walk value and type together, so that the message can name the exact place."""
    while get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    origin = get_origin(kind)
    if isinstance(value, float) and not math.isfinite(value):
        raise ConfigurationError(f"{where}: {path}: is {value}, but must be a finite number")
    if origin in (Union, types.UnionType):
        kind = _member(value, kind, path, where)
        origin = get_origin(kind)
    if origin is Literal and isinstance(value, str) and value not in get_args(kind):
        raise ConfigurationError(f"{where}: {path}: {unknown_name('value', value, get_args(kind))}")
    if isinstance(value, dict) and isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        _check_struct(value, kind, path, where)
    elif isinstance(value, dict) and origin is dict:
        key_kind, value_kind = get_args(kind)
        for key, item in value.items():
            _check_key(key, key_kind, path, where)
            _check_item(item, value_kind, _join(path, key), where)
    elif isinstance(value, list) and origin in (list, tuple):
        for i, (item, item_kind) in enumerate(zip(value, _item_kinds(kind, len(value)), strict=False)):
            _check_item(item, item_kind, f"{path}[{i}]", where)


def _check_struct(value: dict[str, Any], kind: type[msgspec.Struct], path: str, where: str) -> None:
    fields = {field.encode_name: field for field in msgspec.structs.fields(kind)}
    config = kind.__struct_config__
    tag = {config.tag_field} if config.tag_field else set()
    for key in value:
        if key not in fields and key not in tag:
            missing = [k for k in fields if k not in value] or list(fields)
            hint = _did_you_mean(key, missing) or f"; known keys: {', '.join(fields)}"
            raise ConfigurationError(f"{where}: unknown key {_join(path, key)!r}{hint}")
    for key, field in fields.items():
        if key in value:
            _check_item(value[key], field.type, _join(path, key), where)
        elif field.required:
            raise ConfigurationError(f"{where}: missing key {_join(path, key)!r}")


def _check_item(value: Any, kind: Any, path: str, where: str) -> None:
    _check(value, kind, path, where)
    _convert(value, kind, path, where)


def _check_key(key: str, kind: Any, path: str, where: str) -> None:
    if get_origin(kind) is Literal and key not in get_args(kind):
        raise ConfigurationError(f"{where}: {unknown_name('key', _join(path, key), get_args(kind))}")


def _member(value: Any, kind: Any, path: str, where: str) -> Any:
    """The member of a union that a table claims to be by its tag; the union itself if nothing tells."""
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
        raise ConfigurationError(
            f"{where}: missing key {_join(path, field)!r}; one of {', '.join(sorted(tags))}"
        )
    if str(value[field]) not in tags:
        place = f"{_join(path, field)} is an "
        raise ConfigurationError(f"{where}: {place}{unknown_name('kind', str(value[field]), tags)}")
    return tags[str(value[field])]


def _item_kinds(kind: Any, count: int) -> Iterable[Any]:
    kinds = get_args(kind)
    if get_origin(kind) is list or (len(kinds) == 2 and kinds[1] is Ellipsis):
        return (kinds[0],) * count
    return kinds


def _join(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key
