"""Tracebacks of a program, without the lines of its runner."""

from __future__ import annotations

import sys
import traceback
from pathlib import Path

_OWN = {str(Path(__file__).with_name(name)) for name in ("python2.py", "services.py")}
"""Files between a program and its callees."""


def print_error(error: BaseException, program: str) -> None:
    """Print an error's traceback from the program's first line on; all of it where none is the program's.

    Args:
        error: with its traceback.
        program: file name of its code.
    """
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename not in _OWN]
    first = next((i for i, frame in enumerate(frames) if frame.filename == program), 0)
    lines = [*traceback.format_list(frames[first:]), *traceback.format_exception_only(type(error), error)]
    sys.stderr.write("Traceback (most recent call last):\n" + "".join(lines))
