"""Runs one program: `python -m nao_hil.naoqi_programs.runner PROGRAM [ARGUMENT ...]`.

Whatever robot the program names, it is connected to the one at the address in `NAO_HIL_NAOQI`. The process ends
with the program's exit code at once: qi can take seconds to be taken apart.
"""

from __future__ import annotations

import os
import runpy
import sys
import traceback
from pathlib import Path
from typing import Any, Final

ADDRESS: Final = "NAO_HIL_NAOQI"
MODULES: Final = Path(__file__).parent / "modules"


def _redirect(url: str) -> None:
    """Lead every session and application of qi to one address."""
    import qi

    from nao_hil.naoqi_programs.pictures import SERVICE, VideoProxy

    session, application = qi.Session, qi.Application

    def session_here(*_: Any) -> Any:
        made = session()
        connect = made.connect
        made.connect = lambda *_, **options: connect(url, **options)
        find = made.service
        made.service = lambda name, *_: VideoProxy(find(name)) if name == SERVICE else find(name)
        return made

    def application_here(args: Any = None, raw: bool = False, autoExit: bool = True, **_: Any) -> Any:
        given = [a for a in (args or [sys.argv[0]]) if not str(a).startswith("--qi-url")]
        return application([*given, f"--qi-url={url}"], raw, autoExit)

    qi.Session = session_here
    qi.Application = qi.ApplicationSession = application_here


def main(program: str, arguments: list[str]) -> int:
    """Run a program; its exit code."""
    sys.path[0:0] = [str(Path(program).resolve().parent), str(MODULES)]
    _redirect(os.environ[ADDRESS])
    sys.argv = [program, *arguments]
    try:
        runpy.run_path(program, run_name="__main__")
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or 0
        print(end.code, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    except BaseException as error:
        frames = traceback.extract_tb(error.__traceback__)
        inside = [i for i, frame in enumerate(frames) if frame.filename == program]
        _print(error, frames[inside[0] :] if inside else frames)
        return 1
    return 0


def _print(error: BaseException, frames: list[traceback.FrameSummary]) -> None:
    """As Python prints an error, from the program's first line on."""
    print("Traceback (most recent call last):", file=sys.stderr)
    sys.stderr.write("".join(traceback.format_list(frames)))
    sys.stderr.write("".join(traceback.format_exception_only(type(error), error)))


if __name__ == "__main__":
    _code = main(sys.argv[1], sys.argv[2:])
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(_code & 255)
