from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bridge.body
from bridge.body.model import Body
from bridge.config import from_dict, load_toml, parse_toml
from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from tests.processes import python


class _Push(msgspec.Struct, tag="push", forbid_unknown_fields=True):
    impulse: float


class _Tilt(msgspec.Struct, tag="tilt"):
    angle: float = 0.0


class _Servo(msgspec.Struct, rename="kebab"):
    """Does not forbid unknown fields: the loader has to."""

    dry_friction: float
    play: float = 0.0


class _File(msgspec.Struct):
    title: str
    servos: dict[str, _Servo] = {}
    row: tuple[float, ...] = ()
    pair: tuple[int, float] = (0, 0.0)
    events: list[_Push | _Tilt] = []
    level: Literal["ideal", "worn"] = "ideal"
    note: _Servo | None = None
    gains: dict[Literal["p", "d"], float] = {}


def _error(text: str) -> str:
    with pytest.raises(ConfigurationError) as info:
        parse_toml(text, "my.toml", _File)
    message = str(info.value)
    assert message.startswith("my.toml: ")
    assert "\n" not in message
    return message


def test_reads_what_is_right() -> None:
    text = """
        title = "a"
        row = [1, 2.5]
        pair = [3, 4]
        level = "worn"
        note = { dry-friction = 2 }
        servos.knee = { dry-friction = 0.1, play = 0.02 }
        gains = { p = 1 }
        [[events]]
        type = "push"
        impulse = 3
        [[events]]
        type = "tilt"
    """
    assert parse_toml(text, "my.toml", _File) == _File(
        title="a",
        row=(1.0, 2.5),
        pair=(3, 4.0),
        level="worn",
        note=_Servo(2.0),
        servos={"knee": _Servo(0.1, 0.02)},
        gains={"p": 1.0},
        events=[_Push(3.0), _Tilt(0.0)],
    )


@pytest.mark.parametrize(
    ("text", "place", "right"),
    [
        ("titel = 'a'", "unknown key 'titel'", "did you mean 'title'?"),
        ("title = 'a'\nservos.knee.dry-frictoin = 1", "'servos.knee.dry-frictoin'", "mean 'dry-friction'?"),
        ("title = 'a'\nservos.knee = { dry-friction = 1, xyz = 1 }", "'servos.knee.xyz'", "dry-friction, play"),
        ("title = 'a'\nservos.knee.play = 1", "missing key 'servos.knee.dry-friction'", ""),
        ("title = 'a'\nrow = [1.0, 'x']", "row[1]: ", "expected a number, got text"),
        ("title = 'a'\npair = [1.5, 1]", "pair[0]: ", "expected a whole number, got a number"),
        ("title = 'a'\npair = [1]", "pair: ", "length 2"),
        ("title = 'a'\nrow = 1", "row: ", "expected a list, got a whole number"),
        ("title = 1", "title: ", "expected text, got a whole number"),
        (
            "title = 'a'\nlevel = 'wron'",
            "level: unknown value 'wron'",
            "did you mean 'worn'?); known: ideal, worn",
        ),
        ("title = 'a'\nlevel = 1", "level: ", "expected text, got a whole number"),
        ("title = 'a'\nnote = 'loud'", "note: ", "expected a table, got text"),
        ("title = 'a'\nservos.knee = 1", "servos.knee: ", "expected a table, got a whole number"),
        ("title = 'a'\nrow = [nan]", "row[0]: is nan", "finite"),
        ("title = 'a'\nservos.knee.dry-friction = inf", "servos.knee.dry-friction: is inf", "finite"),
        ("title = 'a'\nevents = [{ impulse = 1 }]", "missing key 'events[0].type'", "push, tilt"),
        ("title = 'a'\nevents = [{ type = 'psh' }]", "events[0].type", "did you mean 'push'?"),
        ("title = 'a'\nevents = [{ type = 'push', impulse = '1' }]", "events[0].impulse", "a number"),
        ("title = 'a'\nnote = { dry-friction = 1, plya = 1 }", "'note.plya'", "did you mean 'play'?"),
        ("title = 'a'\ngains.q = 1", "'gains.q'", "known: d, p"),
        ("title = 'a'\ntitle = 'b'", "not valid TOML", ""),
        ("title = ", "not valid TOML", "Invalid value"),
        ("title = 'a'\nrow = [1,,2]", "not valid TOML", "line 2"),
        ("title = 'a'\nrow = [" + "1" * 5000 + "]", "", ""),
        ("title = " + "[" * 100_000, "nested too deeply", ""),
    ],
)
def test_says_where_and_what_would_be_right(text: str, place: str, right: str) -> None:
    message = _error(text)
    assert place in message
    assert right in message


def test_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="No such file"):
        load_toml(tmp_path / "none.toml", _File)
    with pytest.raises(ConfigurationError, match=str(tmp_path)):
        load_toml(tmp_path, _File)
    latin = tmp_path / "latin.toml"
    latin.write_bytes(b"title = '\xe4'")
    with pytest.raises(ConfigurationError, match="UTF-8"):
        load_toml(latin, _File)
    with pytest.raises(ConfigurationError):
        load_toml("nul\0.toml", _File)


def test_unknown_name_suggests_only_what_is_near() -> None:
    near = unknown_name("gait", "Statc", ["static", "huang"])
    assert near == "unknown gait 'Statc' (did you mean 'static'?); known: huang, static"
    assert unknown_name("gait", "zzz", ["static"]) == "unknown gait 'zzz'; known: static"


_FIELDS = ["title", "servos", "row", "pair", "events", "level", "note", "gains", "type", "dry-friction", "play"]
_LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.datetimes()
_VALUES = st.recursive(
    _LEAVES | st.sampled_from(["push", "tilt", "ideal"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(_FIELDS) | st.text(max_size=4), inner, max_size=4)
    ),
    max_leaves=12,
)


@given(data=st.dictionaries(st.sampled_from(_FIELDS) | st.text(max_size=4), _VALUES, max_size=6))
@settings(max_examples=200)
def test_any_data_is_read_or_refused(data: dict[str, Any]) -> None:
    try:
        assert isinstance(from_dict({"title": "a"} | data, "f", _File), _File)
    except ConfigurationError as error:
        assert str(error).startswith("f: ")


@given(text=st.text(max_size=60))
@settings(max_examples=200)
def test_any_text_is_read_or_refused(text: str) -> None:
    with pytest.raises(ConfigurationError):
        parse_toml(text, "f", Body)


_SHEET = (Path(bridge.body.__file__).parent / "bodies" / "nao-v3.toml").read_text("utf-8")


@given(
    at=st.integers(0, len(_SHEET) - 1),
    cut=st.integers(0, 30),
    put=st.text(alphabet="[]{}=\".,'-#\n0123456789eaxinf_ ", max_size=8) | st.text(max_size=4),
)
@settings(max_examples=150)
def test_a_damaged_data_sheet_is_read_or_refused(at: int, cut: int, put: str) -> None:
    try:
        assert isinstance(parse_toml(_SHEET[:at] + put + _SHEET[at + cut :], "f", Body), Body)
    except ConfigurationError as error:
        assert str(error).startswith("f: ")


SCRIPT = """
import threading, time
from typing import Literal

import msgspec

from bridge.messages.codec import decode, encode
from bridge.messages.frames import SCHEMA_VERSION
from bridge.validation import convert

alias = type(Literal["a"])
quick = alias.__hash__

def slow(self):
    time.sleep(0.01)  # another thread's turn, in the midst of a type
    return quick(self)

alias.__hash__ = slow

class Inner(msgspec.Struct, frozen=True):
    a: Literal["x", "y"] = "x"

class Outer(msgspec.Struct, frozen=True, kw_only=True):
    version: int = SCHEMA_VERSION
    inner: Inner = Inner()
    b: Literal["x", "z"] = "x"

wanted = Outer(inner=Inner("y"), b="z")
payload, table = encode(wanted), msgspec.to_builtins(wanted)
found = []
threads = [threading.Thread(target=lambda: found.append(READ)) for _ in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert found == [wanted] * 4
"""


@pytest.mark.parametrize("read", ["convert(table, Outer)", "decode(payload, Outer)"])
def test_threads_read_a_new_type_at_once(read: str) -> None:
    done = python("-c", SCRIPT.replace("READ", read))
    assert done.returncode == 0, done.stderr
