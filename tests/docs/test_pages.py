"""The readers' pages and the how-to pages, followed to the letter in an empty folder."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
DOCS = REPOSITORY / "docs"
READERS = ("student", "team", "researcher", "owner")
PAGES = [*(DOCS / f"{reader}.md" for reader in READERS), *sorted((DOCS / "how-to").glob("*.md"))]
PROJECT = ("bridge", "emulator", "walker", "nao_hil", "pyproject.toml")
TIMEOUT = 500.0
"""s for a page that takes a dozen on an idle machine."""

BLOCK = re.compile(
    r"(?P<before><!-- not run: [^>]+ -->\n)?^```(?P<language>\w+)(?: title=\"(?P<title>[^\"]+)\")?\n"
    r"(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
SHOWN = {"text"}
"""Languages of blocks that are there to be read."""


def script_of(page: Path, folder: Path) -> str:
    """The page's commands in their order, as one script; its files are written where they are named."""
    lines = ["set -euo pipefail"]
    for block in BLOCK.finditer(page.read_text()):
        if block["title"]:
            file = folder / f"at-line-{page.read_text()[: block.start()].count(chr(10))}"
            file.write_text(block["text"])
            lines.append(f"mkdir -p $(dirname {block['title']}) && cp {file} {block['title']}")
        elif block["language"] == "sh":
            lines += [] if block["before"] else [block["text"]]
        else:
            assert block["language"] in SHOWN, f"{page.name} has a {block['language']} block without a file"
    return "\n".join(lines)


@pytest.fixture
def machine() -> Iterator[None]:
    """One page at a time: they all use the default endpoint."""
    with Path("/tmp", f"nao-hil-pages-{os.getuid()}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A folder with nothing but a clone of the project in it."""
    place = tmp_path / "empty"
    for name in PROJECT:
        source, target = REPOSITORY / name, place / "nao-hil" / name
        if source.is_dir():
            shutil.copytree(source, target)  # with what numba has compiled
        else:
            shutil.copy(source, target)
    return place


def follow(page: Path, clone: Path, folder: Path) -> str:
    """What the page's commands say; every process they start ends with them."""
    # the clone's code and not the installed one's, as in a clone with a .venv of its own
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(clone / "nao-hil"),
    }
    script, said = folder / "page.sh", folder / "said"
    script.write_text(script_of(page, folder))
    with (
        said.open("w") as out,
        subprocess.Popen(
            ["bash", str(script)],
            cwd=clone,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        ) as process,
    ):
        try:
            code = process.wait(TIMEOUT)
        finally:
            _end_group(process.pid)
    assert code == 0, said.read_text()
    return said.read_text()


def _end_group(group: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)


EXPECTED = {
    "student.md": [
        r"The robot stands",
        r"frames-torso\.png",
        r"The robot stands.*steps +│ 16 ",
        r"The robot fell .*The robot fell at \d\.\d+ s; first, at .*exit code 1",
        r"3 s later: walk",
    ],
    "team.md": [r"left foot \d\.\d kg, right foot \d\.\d kg", r"nao-v6"],
    "researcher.md": [
        r"requested 0\.\d+, measured",
        r"stands after 0\.\d+ m",
        r"largest roll: 0\.[01]",
        r"damping",
    ],
    "owner.md": [r"armed"],
    "own-controller.md": [r"the knees went 0\.(3[5-9]|4)\d* rad down", r"joints\.png"],
    "another-language.md": [r"The left knee went 0\.(1[5-9]|2\d) rad down"],
    "add-a-body.md": [r"The robot stands"],
    "replace-the-estimator.md": [r'"fell": ?false'],
    "wear-profile.md": [
        r"loose-knees\.toml: a good wear file",
        r"The robot stands.*?steps +│ 4 ",
        r"mine\.toml: a good wear file",
        r"The robot stands.*?steps +│ 4 ",
        r"[LR]KneePitch differs most",
    ],
    "add-a-gait.md": [r"squat", r"The robot stands.*steps +│ 2 ", r"joints\.png"],
    "gymnasium.md": [],
    "export.md": [r"peak [12]\.\d\d of the final value, natural frequency [789]\.\d+ rad/s"],
    "add-an-experiment.md": [r"upright", r"upright: confirmed", r"report\.html"],
    "identify.md": [
        r"\w+ differs most",
        r"report\.html",
        r"60\.0 s of nao-v3.*backlash\.KneePitch",
        r"\w+ differs most",
    ],
    "index.md": [],
}
"""What must be said, in this order."""


@pytest.mark.timeout(600, func_only=True)  # the wait for other pages is not its own time
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page_does_what_it_says(page: Path, machine: None, clone: Path, tmp_path: Path) -> None:
    said = follow(page, clone, tmp_path)
    at = 0
    for expected in EXPECTED[page.name]:
        found = re.compile(expected, re.DOTALL).search(said, at)
        assert found, f"after what was expected before, {expected!r} is missing in:\n{said}"
        at = found.end()


def test_the_controller_is_the_example() -> None:
    page, code = DOCS / "how-to" / "own-controller.md", (REPOSITORY / "examples/own_controller.py").read_text()
    assert f'```python title="own_controller.py"\n{code}```' in page.read_text()


def test_a_controller_takes_60_lines_at_most() -> None:
    assert len((REPOSITORY / "examples/own_controller.py").read_text().splitlines()) <= 60
