"""The terminal: text stays as it is, a reader holds up nothing, signals reach a command wherever it is."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest
from rich.table import Table

from bridge.adapters.lola.address import parse_address
from bridge.errors import ConfigurationError
from bridge.link.session import split_open
from nao_hil.cli.console import Answer, open_console
from nao_hil.cli.main import run
from nao_hil.cli.progress import CampaignProgress
from nao_hil.cli.signals import on_signals
from tests.loops import TIMEOUT

SAYS_MUCH = """
import logging, os
from nao_hil.cli.console import log_to_stderr
log_to_stderr()
for _ in range(5000):
    logging.getLogger("robot").warning("x" * 100)
print("went on", flush=True)
os._exit(0)
"""


@pytest.mark.parametrize(
    "text",
    [
        "82:93:CD:AB:71",  # `:CD:` and `:AB:` are names of emoji
        "/data/[a]/run",  # `[a]` is no style
        "pip install 'nao-hil[view]'",
    ],
)
def test_text_is_neither_emoji_nor_markup(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    open_console().print(text)
    assert capsys.readouterr().err == text + "\n"


def test_a_reader_that_does_not_read_holds_up_nothing() -> None:
    """A pipe takes 64 KB; 500 KB are said."""
    with subprocess.Popen(
        [sys.executable, "-c", SAYS_MUCH], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        try:
            process.wait(TIMEOUT)
        finally:
            process.kill()
        assert process.stdout.read() == "went on\n"


HELD_UP = 5.0
"""s for which a handler that holds up the thread it waits for is waited for."""


@pytest.fixture
def handlers() -> Iterator[None]:
    """The handlers of this test are gone after it."""
    descriptor = signal.set_wakeup_fd(-1)
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    signal.set_wakeup_fd(descriptor)
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_comes_through_while_the_main_thread_has_the_lock_that_stop_needs(
    number: signal.Signals, handlers: None
) -> None:
    """As `threading.Event.wait` has that of `set` for some microseconds."""
    lock, stopped = threading.Lock(), threading.Event()
    taken = []

    def stop() -> None:
        taken.append(lock.acquire(timeout=HELD_UP))
        stopped.set()

    on_signals(stop)
    with lock:
        signal.raise_signal(number)
    assert stopped.wait(TIMEOUT)
    assert taken == [True]
    assert signal.getsignal(number) == signal.SIG_DFL  # a second one ends the process at once


HOSTILE = "\x1b]0;mine\x07\x1b[2J\x9b31m nao\r"
SHOWS = {
    "text": lambda: open_console().print(HOSTILE),
    "table": lambda: open_console().print(_table()),
    "answer": lambda: Answer(None, HOSTILE).give(as_json=False),
    "json": lambda: Answer({"name": HOSTILE}).give(as_json=True),
    "refusal": lambda: run(["info", HOSTILE]),
}
"""Ways of a text to the terminal."""


def _table() -> Table:
    table = Table(title=HOSTILE)
    table.add_column(HOSTILE)
    table.add_row(HOSTILE)
    return table


@pytest.mark.parametrize("way", SHOWS)
def test_no_text_of_another_program_controls_the_terminal(way: str, capsys: pytest.CaptureFixture[str]) -> None:
    SHOWS[way]()
    out = "".join(capsys.readouterr())
    assert "nao" in out and not set(out) & {"\x1b", "\x07", "\x9b", "\r"}


@pytest.mark.parametrize("address", ["0.0.0.0:10000", "[::]:10000", "192.168.1.7:10000"])
def test_a_server_beyond_loopback_takes_the_word_open(address: str) -> None:
    def host(plain: str) -> str:
        return parse_address(plain).host

    with pytest.raises(ConfigurationError, match="#open"):
        split_open(address, host)
    assert split_open(f"{address}#open", host) == address
    for own in ("127.0.0.1:10000", "/tmp/robocup"):
        assert split_open(own, host) == own


@pytest.mark.parametrize("listen", ["foo", "/tmp/x", "127.0.0.1", "127.0.0.1:0", "[::1]:3838"])
def test_a_gamecontroller_is_heard_at_a_port_of_ipv4(listen: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["serve", "gamecontroller", "--listen", listen]) == 2
    error = capsys.readouterr().err
    assert ("HOST:PORT" in error or "IPv4" in error) and "robocup" not in error


@pytest.mark.parametrize(
    "arguments",
    [("lola", "--socket", "0.0.0.0:10000"), ("naoqi", "--listen", "tcp://0.0.0.0:9559")],
)
def test_serve_beyond_loopback_is_refused(
    arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["serve", *arguments]) == 2
    assert "#open" in capsys.readouterr().err


def test_a_campaign_shows_the_time_left(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter(range(0, 10_000, 100))
    monkeypatch.setattr("nao_hil.cli.progress.time.monotonic", lambda: float(next(clock)))
    with CampaignProgress(open_console()) as progress:
        progress.begin("slopes")
        progress.expect(4)
        progress.done("seed 0", "")
        progress.begin("map", unit="parts", grows=True)
        progress.expect(2)
        progress.done("", "")
    shown = capsys.readouterr().err
    assert re.search(r"1 of 4 runs, 0:\d\d:\d\d left; last seed 0", shown)
    assert re.search(r"1 of 2 parts, at least 0:\d\d:\d\d left$", shown, re.MULTILINE)
