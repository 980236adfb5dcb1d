"""Keeps, of what a fuzzer grew, the few files that reach every branch of our code that all of them reach.

Usage, from the repository's root: python -m tests.fuzz.minimise [TARGET ...]. Needs `coverage`, which pytest
does not. Files `tests/fuzz/corpus/TARGET/grown-...` may go; all others are findings or seeds, and stay.
"""

from __future__ import annotations

import logging
import sys
from pathlib import Path

import coverage

from tests.fuzz.targets import TARGETS

CORPUS = Path(__file__).with_name("corpus")
MEASURED = ["bridge", "emulator", "nao_hil"]

Branches = frozenset[tuple[str, int, int]]
"""File, line from, line to."""


def branches(target: str, file: Path) -> Branches:
    """Branches of the measured packages that a file reaches."""
    measure = coverage.Coverage(data_file=None, branch=True, source_pkgs=MEASURED)
    measure.set_option("run:disable_warnings", ["module-not-measured", "no-data-collected"])
    with measure.collect():
        TARGETS[target](file.read_bytes())
    data = measure.get_data()
    return frozenset((name, *arc) for name in data.measured_files() for arc in data.arcs(name) or ())


def cover(kept: list[Branches], grown: dict[Path, Branches]) -> list[Path]:
    """The greedy set cover: in each round the file that adds most, the smallest of equals.

    Args:
        kept: of the files that stay anyway.
        grown: of each file that may go.
    """
    reached, chosen = set().union(*kept), []
    for _ in grown:
        best = max(grown, key=lambda path: (len(grown[path] - reached), -path.stat().st_size, path.name))
        if not grown[best] - reached:
            break
        chosen.append(best)
        reached |= grown[best]
    return chosen


def main() -> None:
    """Delete what adds nothing."""
    logging.disable(logging.CRITICAL)
    for target in sys.argv[1:] or TARGETS:
        files = sorted((CORPUS / target).iterdir())
        for file in files:  # what is read once and kept counts for none
            TARGETS[target](file.read_bytes())
        reached = {file: branches(target, file) for file in files}
        grown = {file: found for file, found in reached.items() if file.name.startswith("grown-")}
        chosen = cover([found for file, found in reached.items() if file not in grown], grown)
        for file in set(grown) - set(chosen):
            file.unlink()
        total = len(set().union(*reached.values()))
        print(f"{target}: {total} branches, {len(chosen)} of {len(grown)} grown files")


if __name__ == "__main__":
    main()
