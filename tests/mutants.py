"""Breaks each promise of docs/promises.md on purpose, and expects its test to fail.

`tests/mutants.toml` has the mutants by test. Each is applied alone to a copy of the sources, in which its test
runs, the processes that it starts included.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Final, NamedTuple

import msgspec

from bridge.config import load_toml

ROOT: Final = Path(__file__).parents[1]
PROMISES: Final = ROOT / "docs" / "promises.md"
NAMED_TEST: Final = re.compile(r"`(test_\w+)`")
PATIENCE: Final = 30.0
"""s that `tests.loops.until` waits in the copy: there its condition mostly never comes true."""
OUTCOMES: Final = ("killed", "survived", "stale", "broken", "skipped")
"""The test failed; it passed; the file no longer has the text; the test could not begin; it is not for here."""
_NOT_COPIED: Final = {".git", ".venv", "site", "runs", "build", "dist"}
"""Of the repository's root."""


class Mutant(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A change of the sources that breaks a promise."""

    test: str
    """Name of the test that fails then."""
    breaks: str
    """The broken behaviour, in words."""
    file: str
    old: str
    """Text that occurs once in the file."""
    new: str
    slow: bool = False
    """Needs over 15 s, a browser, or an idle machine: not in a sample."""
    timeout: int = 90
    """s after which the test fails: it hangs."""

    @property
    def fits(self) -> bool:
        """Whether the file still has the text, once."""
        path = ROOT / self.file
        return path.is_file() and path.read_text(encoding="utf-8").count(self.old) == 1

    def __str__(self) -> str:
        return f"{self.breaks} ({self.file}): {self.test}"


class _Mutants(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Content of `mutants.toml`."""

    mutant: tuple[Mutant, ...]


class Promise(NamedTuple):
    """A row of docs/promises.md."""

    text: str
    tests: tuple[str, ...]


def mutants() -> tuple[Mutant, ...]:
    """All mutants."""
    return load_toml(ROOT / "tests" / "mutants.toml", _Mutants).mutant


def promises() -> list[Promise]:
    """All promises."""
    rows = [row[2:] for row in PROMISES.read_text(encoding="utf-8").splitlines() if row.startswith("- ")]
    return [
        Promise(re.sub(r"\[(.+)\]\(\S+\)", r"\1", row.partition(": `test_")[0]), tuple(NAMED_TEST.findall(row)))
        for row in rows
    ]


@cache
def places_of_tests() -> dict[str, Path]:
    """Name and file of each test."""
    return {
        node.name: path
        for path in sorted((ROOT / "tests").rglob("test_*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
    }


def judge(mutant: Mutant, copy: Path) -> str:
    """One of `OUTCOMES`.

    Args:
        mutant: to apply.
        copy: of the repository, as it was before.
    """
    if not mutant.fits:
        return "stale"
    source, report = copy / mutant.file, copy / "report.xml"
    shutil.copy2(source, copy / "original")
    source.write_text(source.read_text(encoding="utf-8").replace(mutant.old, mutant.new), encoding="utf-8")
    test = f"{places_of_tests()[mutant.test].relative_to(ROOT)}::{mutant.test}"
    command = [sys.executable, "-m", "pytest", "-n", "0", "-x", "-p", "no:cacheprovider"]
    options = [f"--junitxml={report}", f"--timeout={mutant.timeout}", "--timeout-method=signal"]
    marks = [] if mutant.slow else ["-m", "not realtime and not browser"]
    try:
        subprocess.run(
            [*command, *options, *marks, test],
            cwd=copy,
            env=os.environ | {"PYTHONPATH": str(copy)},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=False,
        )
        return _outcome(report)
    finally:
        shutil.move(copy / "original", source)
        report.unlink(missing_ok=True)


def _outcome(report: Path) -> str:
    """Of a test that ran with a mutant."""
    if not report.exists():
        return "broken"
    (suite,) = ElementTree.parse(report).iter("testsuite")
    count = {kind: int(suite.attrib[kind]) for kind in ("tests", "failures", "errors", "skipped")}
    if count["failures"]:
        return "killed"
    if count["errors"] or not count["tests"]:
        return "broken"
    return "skipped" if count["skipped"] == count["tests"] else "survived"


def run(chosen: Sequence[Mutant]) -> dict[str, list[str]]:
    """Outcomes, and the mutants of each."""
    found: dict[str, list[str]] = {kind: [] for kind in OUTCOMES}
    with tempfile.TemporaryDirectory(prefix="mutants-") as name:
        copy = Path(name) / "tree"
        shutil.copytree(ROOT, copy, ignore=lambda at, _: _NOT_COPIED if Path(at) == ROOT else ())
        loops = copy / "tests" / "loops.py"
        text, number = re.subn(r"TIMEOUT: Final = .*", f"TIMEOUT: Final = {PATIENCE}", loops.read_text())
        assert number == 1
        loops.write_text(text)
        for mutant in chosen:
            began = time.monotonic()
            outcome = judge(mutant, copy)
            found[outcome].append(str(mutant))
            print(f"{time.monotonic() - began:5.1f} s  {outcome}: {mutant}", file=sys.stderr, flush=True)
    return found


def main() -> None:
    """Exit code 1: a mutant survived, or could not be judged."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("word", nargs="?", default="", help="only mutants with this word in file, test or text")
    parser.add_argument("--list", action="store_true", help="show promises, mutants and tests; run nothing")
    parser.add_argument("--sample", type=int, metavar="N", help="run N drawn ones that are not slow")
    today = int(time.time() // 86400)
    parser.add_argument("--seed", type=int, default=today, help="of the sample; default: the day's")
    parser.add_argument("--json", action="store_true", help="the outcomes as one object")
    given = parser.parse_args()
    chosen = [mutant for mutant in mutants() if given.word in str(mutant)]
    if given.list:
        for promise in promises():
            print(promise.text)
            for mutant in (mutant for mutant in chosen if mutant.test in promise.tests):
                print(f"    {mutant}")
        return
    if given.sample is not None:
        quick = [mutant for mutant in chosen if not mutant.slow]
        chosen = random.Random(given.seed).sample(quick, min(given.sample, len(quick)))
    found = run(chosen)
    if given.json:
        print(json.dumps(found))
    else:
        print(", ".join(f"{len(of_kind)} {kind}" for kind, of_kind in found.items() if of_kind))
    sys.exit(any(found[kind] for kind in ("survived", "stale", "broken")))


if __name__ == "__main__":
    main()
