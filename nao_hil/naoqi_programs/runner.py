"""Runs one program: `python runner.py CODE PROGRAM [ARGUMENT ...]`.

CODE is a file with the program's code (`marshal`). Whatever robot the program names, it is connected to the one
at the address in `NAO_HIL_NAOQI`. The process ends after the program's threads and exit functions, with its
exit code, but does not call the exit functions of qi, which can take seconds.
"""

from __future__ import annotations

import atexit
import marshal
import os
import signal
import sys
import threading
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from bridge.adapters.naoqi.real_robot import connected
from bridge.errors import LinkError
from nao_hil.naoqi_programs.loading import load_modules
from nao_hil.naoqi_programs.python2 import put_back
from nao_hil.naoqi_programs.services import Service, print_error, sendable
from nao_hil.naoqi_programs.source import is_old

ADDRESS: Final = "NAO_HIL_NAOQI"
MODULES: Final = Path(__file__).parent / "modules"
PATIENCE: Final = 20.0
"""Timeout of NAOqi on a busy machine, s; qi itself would wait for ever for a server that is no NAOqi."""


def _redirect(url: str) -> None:
    """Lead every session and application of qi to one address.

    Raises:
        LinkError: no NAOqi answers there.
    """
    connected(url, PATIENCE).close()
    import qi

    session, application = qi.Session, qi.Application

    def session_here(*_: Any) -> Any:
        """A session that connects to the served robot, whatever address it is given."""
        made = session()
        connect = made.connect
        made.connect = lambda *_, **options: connect(url, **options)
        find = made.service
        made.service = lambda name, *_: frames() if name == "ALFrameManager" else Service(find(sendable(name)))
        return made

    @cache
    def frames() -> Any:
        """`ALFrameManager` of the program, made at its first use: few programs have one."""
        from nao_hil.naoqi_programs.choregraphe.play import make_player

        player = make_player(session_here(), Path(sys.argv[0]).resolve().parent)
        atexit.register(lambda: [print(f"not done: {one}", file=sys.stderr) for one in player.could_not])
        return player.frames

    def application_here(args: Any = None, raw: bool = False, autoExit: bool = True, **_: Any) -> Any:
        given = [a for a in (args or [sys.argv[0]]) if not str(a).startswith("--qi-url")]
        return application([*given, f"--qi-url={url}"], raw, autoExit)

    qi.Session = session_here
    qi.Application = qi.ApplicationSession = application_here


def _interrupt_once() -> None:
    """Let SIGTERM be a Ctrl-C to the program, except after a Ctrl-C.

    A terminal sends Ctrl-C to this process and to `run-naoqi`, which then sends SIGTERM: of both the program
    gets one KeyboardInterrupt, and may put the robot to rest.
    """
    interrupted = False

    def handle(number: int, _frame: object) -> None:
        nonlocal interrupted
        if interrupted and number == signal.SIGTERM:
            return
        interrupted = True
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, handle)
    signal.signal(signal.SIGTERM, handle)


def main(code: Path, program: str, arguments: list[str]) -> int:
    """Run a program until its threads have ended; its exit code."""
    try:
        _redirect(os.environ[ADDRESS])
    except LinkError as error:
        print(f"error: {error} Stop what listens there, or give another --url.", file=sys.stderr)
        return error.exit_code
    sys.path[0:0] = [str(Path(program).resolve().parent), str(MODULES)]
    sys.argv = [program, *arguments]
    module = sys.modules["__main__"] = ModuleType("__main__")
    module.__file__ = program
    put_back()
    atexit._clear()  # those of qi
    try:
        program_code = marshal.loads(code.read_bytes())
        load_modules(is_old(program_code))
        exec(program_code, vars(module))
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or 0
        print(end.code, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    except BaseException as error:
        print_error(error, program)
        return 1
    return 0


def _ended(code: int) -> int:
    """Wait for the program's threads, and call its exit functions, as an interpreter does; the exit code."""
    for end in (threading._shutdown, atexit._run_exitfuncs):  # type: ignore[attr-defined]
        try:
            end()
        except KeyboardInterrupt:
            code = 130
        except BaseException as error:
            print_error(error, sys.argv[0])
    return code


if __name__ == "__main__":
    del sys.path[0]  # this folder
    _interrupt_once()
    _code = _ended(main(Path(sys.argv[1]), sys.argv[2], sys.argv[3:]))
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(_code & 255)
