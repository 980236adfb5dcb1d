"""Every parameter of every command that takes a file: no file makes it wait, and each bad one is one sentence.

The parameters are those of the command line itself: a new one is classified here, or a test fails.
"""

from __future__ import annotations

import os
import signal
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple

import lz4.frame
import pytest
import typer
import zstandard

from bridge.recording.recorder import Recorder
from nao_hil.cli.main import _application, run
from tests.frames import standing_frame

LONGEST: Final = 300
"""s of the wall clock, far over each reader's bound on a busy machine, too: only a hanging command needs it."""
ONE_ROW: Final = "time,command.HeadYaw,position.HeadYaw\n0,0,0\n0.01,0,0\n0.02,0,0\n"

TOML: Final = ".toml"
MCAP: Final = ".mcap"
FILES: Final = {
    name: suffix
    for suffix, names in {
        TOML: (
            "--config, --robot, --wear, --unseen-wear, --scenario, --columns, --base, --space, --world, "
            "--game, "
            "config check file, campaign file"
        ),
        ".onnx": ("--leg-model"),
        MCAP: (
            "--replay, replay file, info file, plot files, diff runs, export run recordings, export "
            "rosbag recording"
        ),
        ".log": ("--study, identify recording"),
        ".csv": ("motion name, compare recording"),
        ".py": ("run-naoqi program"),
        ".xar": ("run-choregraphe project"),
    }.items()
    for name in names.split(", ")
}
"""Parameter, or command and argument, that names a file to read -> its suffix."""
MORE_SUFFIXES: Final = {
    "motion name": (TOML,),
    "compare recording": (MCAP, ".csv.gz", ".log"),
    "run-choregraphe project": (".pml",),
}
NO_FILES: Final = """
--behavior --body-id --called --cluster --connect --controller --cycle --distro --engine --floor --format
--gait --head-id --home --host --html --install-completion --keys --kind --listen --mode --name --out --role
--router --run --set --show-completion --socket --stabilizer --start --study --torso --url --velocity --video
--what --yaw --to --admittance --gamepad --domain arguments button folder number person query ranges what x y
name robot shape
"""
OTHERS: Final = frozenset(NO_FILES.split())
"""Names, endpoints, numbers, folders and files to write; devices that are polled."""
EMPTY_IS_VALID: Final = frozenset({"--config", "--scenario", "--space", "campaign file", "run-naoqi program"})
BEFORE: Final[dict[str, list[str]]] = {
    "compare": ["{csv}", "--robot", "nao-v6"],
    "identify": ["{csv}", "--robot", "nao-v6", "--out", "{out}.toml"],
    "export run": ["{mcap}", "--html", "{out}.html"],
    "export rosbag": ["{mcap}", "--out", "{out}"],
    "export mjcf": ["--out", "{out}.xml"],
    "export urdf": ["--out", "{out}.urdf"],
    "export folder": ["--out", "{out}"],
    "diff": ["{mcap}", "{mcap}"],
    "motion": ["crouch"],
    "map": ["push.impulse=0:1", "push.direction=0:90"],
    "tune": ["parameters.l_lift=0.01:0.02"],
    "experiment": ["velocity"],
    "run-naoqi": ["{py}"],
    "run-choregraphe": ["{xar}"],
    "view": ["--port", "18931"],
    "bridge naoqi": ["--url", "tcp://127.0.0.1:1"],
    "plot": ["{mcap}"],
    "replay": ["{mcap}"],
}
"""Arguments that a command needs."""


class Case(NamedTuple):
    """A parameter that takes a file."""

    command: str
    parameter: str
    key: str
    """In `FILES`."""


def parameters() -> Iterator[tuple[str, Any]]:
    """Command and parameter, of the whole command line."""
    waiting: list[tuple[str, Any]] = [("", typer.main.get_command(_application([])))]
    for _ in range(1000):
        if not waiting:
            return
        name, command = waiting.pop()
        waiting += [(f"{name} {each}".strip(), one) for each, one in getattr(command, "commands", {}).items()]
        if not getattr(command, "commands", {}):
            yield from ((name, parameter) for parameter in command.params)


def is_text(parameter: Any) -> bool:
    """Neither a number nor a switch."""
    words = str(parameter.type_descriptor.annotation)
    return "str" in words or "Path" in words


def key_of(command: str, parameter: Any) -> str:
    option = parameter.param_type_name == "option"
    return str(parameter.opts[0]) if option else f"{command} {parameter.name}"


CASES: Final = [
    Case(command, str(parameter.opts[0] if key.startswith("--") else parameter.name), key)
    for command, parameter in parameters()
    if is_text(parameter) and (key := key_of(command, parameter)) in FILES
]


def test_every_parameter_is_known_to_take_a_file_or_not() -> None:
    unknown = {
        f"{command}: {key}"
        for command, parameter in parameters()
        if is_text(parameter)
        and (key := key_of(command, parameter)) not in FILES
        and key.rpartition(" ")[2] not in OTHERS
    }
    assert not unknown, f"FILES or OTHERS: {sorted(unknown)}"
    assert len(CASES) > 50


def mcap(*chunks: tuple[str, bytes, int]) -> bytes:
    """A file of chunks: compression, packed content, declared length."""
    data = b"\x89MCAP0\r\n"
    for name, packed, size in chunks:
        chunk = struct.pack("<QQQII", 0, 0, size, 0, len(name)) + name.encode()
        chunk += struct.pack("<Q", len(packed)) + packed
        data += struct.pack("<BQ", 6, len(chunk)) + chunk
    return data


ZEROS: Final = bytes(1 << 26)
MESSAGES: Final = (struct.pack("<BQ", 5, 222) + bytes(222)) * (1 << 17)
QUOTED: Final = ".".join(['","'] * 60_000)

BAD: Final[dict[str, Callable[[], bytes]]] = {
    "nothing": lambda: b"",
    "random bytes": lambda: bytes((17 * i * i + 3 * i) % 256 for i in range(50_000)),
    "text": lambda: b"this is no file of any kind\n" * 100,
    "quoted keys": lambda: f"{QUOTED} = 1\n".encode(),
    "quoted tables": lambda: f"[{QUOTED}]\n".encode(),
    "many tables": lambda: "".join(f"[a{i}.b.c.d]\n" for i in range(14_000)).encode(),
    "nested tables": lambda: f"a = {'{a=' * 14_000}1{'}' * 14_000}\n".encode(),
    "many columns": lambda: b"a,b,c," * 300_000,
    "LZ4 bomb": lambda: mcap(*[("lz4", lz4.frame.compress(ZEROS * 8), 100)] * 20),
    "chunks of zeros": lambda: mcap(*[("zstd", zstandard.compress(ZEROS), len(ZEROS))] * 200),
    "chunks of messages": lambda: mcap(*[("zstd", zstandard.compress(MESSAGES), len(MESSAGES))] * 50),
}


def make(folder: Path, kind: str, suffix: str) -> Path:
    """A path that is no good file."""
    path = folder / f"{kind.replace(' ', '-')}{suffix}"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    elif kind == "huge":
        with path.open("wb") as file:
            file.truncate(1 << 37)  # of nothing: it takes no place on the disk
    else:
        path.write_bytes(content(kind))
    return path


@cache
def content(kind: str) -> bytes:
    return BAD[kind]()


SLOW: Final = ("LZ4 bomb", "chunks of zeros", "chunks of messages")
FOR_ONE_FORMAT: Final = {
    **dict.fromkeys(("quoted keys", "quoted tables", "many tables", "nested tables"), TOML),
    **dict.fromkeys(SLOW, MCAP),
    "many columns": ".csv",
}
FIRST: Final = {case.key: case for case in reversed(CASES)}
"""The case that gets what takes long to read: all commands with the same option have one reader of its file."""


@contextmanager
def bounded(what: str) -> Iterator[None]:
    """Ends the test where a command hangs."""

    def hangs(*_: object) -> None:
        pytest.fail(f"{what}: hangs", pytrace=False)

    before = signal.signal(signal.SIGALRM, hangs)
    signal.alarm(LONGEST)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("case", CASES, ids=[f"{case.command} {case.parameter}" for case in CASES])
def test_a_bad_file_is_one_sentence_and_exit_code_2(
    case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "good.csv").write_text(ONE_ROW)
    with Recorder(tmp_path / "good.mcap", {"config": '{"robot": "nao-v6"}'}) as recorder:
        for seq in range(50):
            recorder.write(standing_frame(seq))
    (tmp_path / "good.py").write_text("print('hello')\n")
    for suffix in (FILES[case.key], *MORE_SUFFIXES.get(case.key, ())):
        for kind in ("pipe", "device", "folder", "huge", *BAD):
            if FOR_ONE_FORMAT.get(kind, suffix) != suffix or (kind == "nothing" and case.key in EMPTY_IS_VALID):
                continue
            if kind in SLOW and case.key != "info file":  # all commands have one reader of recordings
                continue
            if kind in FOR_ONE_FORMAT and FIRST[case.key] is not case:
                continue
            path = make(tmp_path, kind, suffix)
            arguments = argv(case, path, tmp_path)
            with bounded(f"{kind}: nao-hil {' '.join(arguments)}"):
                code = run(arguments)
            output = capsys.readouterr()
            errors = [line for line in output.err.splitlines() if line.startswith("error: ")]
            assert (code, len(errors)) == (2, 1), (kind, arguments, code, output.err[-2000:], output.out[-500:])
            assert path.name in errors[0] or case.key == "--study", (kind, errors)
            assert len(errors[0]) < 1000


def argv(case: Case, path: Path, folder: Path) -> list[str]:
    words = {kind: folder / f"good.{kind}" for kind in ("csv", "mcap", "py", "xar")} | {"out": folder / "out"}
    needed = [word.format(**words) for word in BEFORE.get(case.command, [])]
    if case.key.startswith("--"):
        name = case.command.split()
        if case.command == "run-naoqi":
            return [*name, case.parameter, str(path), *needed]
        needed = [w for i, w in enumerate(needed) if case.parameter not in (w, needed[i - 1] if i else "")]
        return [*name, *needed, case.parameter, str(path)]
    options = needed[next((i for i, word in enumerate(needed) if word.startswith("--")), len(needed)) :]
    return [*case.command.split(), *[str(path)] * (2 if case.command == "diff" else 1), *options]
