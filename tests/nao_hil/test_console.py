"""Text on the terminal stays as it is, and its reader holds up nothing."""

from __future__ import annotations

import subprocess
import sys

import pytest

from nao_hil.cli.console import open_console
from tests.processes import python

SAYS_MUCH = """
import logging, os
from nao_hil.cli.console import log_to_stderr
log_to_stderr()
for _ in range(5000):
    logging.getLogger("robot").warning("x" * 100)
print("went on", flush=True)
os._exit(0)
"""
SAYS_LITTLE = """
import logging
from nao_hil.cli.console import end_log, log_to_stderr
log_to_stderr()
logging.getLogger("robot").warning("x" * 100)
end_log()
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
            process.wait(60)
        finally:
            process.kill()
        assert process.stdout.read() == "went on\n"


def test_the_last_words_are_written_in_a_line_each() -> None:
    done = python("-c", SAYS_LITTLE)
    (line,) = done.stderr.splitlines()
    assert line.endswith("WARNING " + "x" * 100)
