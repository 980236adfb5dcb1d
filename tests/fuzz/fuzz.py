"""Feeds a target what a coverage-guided fuzzer thinks of; needs atheris, which pytest does not.

Usage, from the repository's root: python -m tests.fuzz.fuzz TARGET [libFuzzer's options] [FOLDER ...], for
example `python -m tests.fuzz.fuzz frames -max_total_time=600 new tests/fuzz/corpus/frames`. A finding becomes a
file in tests/fuzz/corpus/TARGET/, and with it a test; `-merge=1 SMALL LARGE` keeps the files that add coverage.
"""

from __future__ import annotations

import logging
import sys

import atheris


def main() -> None:
    """Fuzz until told otherwise."""
    name = sys.argv.pop(1) if len(sys.argv) > 1 else ""
    with atheris.instrument_imports(
        include=[
            *("bridge", "mcap", "nao_hil.runs.config", "nao_hil.view.access", "nao_hil.view.server"),
            *("emulator.scenarios", "emulator.wear", "websockets"),
        ]
    ):
        from tests.fuzz.targets import TARGETS
    if name not in TARGETS:
        sys.exit(f"error: {name!r} must be one of {', '.join(TARGETS)}.")
    logging.disable(logging.CRITICAL)
    atheris.Setup(sys.argv, TARGETS[name])
    atheris.Fuzz()


if __name__ == "__main__":
    main()
