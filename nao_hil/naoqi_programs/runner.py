"""Runs one program: `python -m nao_hil.naoqi_programs.runner PROGRAM [ARGUMENT ...]`.

Whatever robot the program names, it is connected to the one at the address in `NAO_HIL_NAOQI`. The process ends
with the program's exit code at once: qi can take seconds to be taken apart.
"""

from __future__ import annotations

import os
import signal
import sys
from importlib.machinery import FileFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, Final

from bridge.adapters.naoqi.device import connected
from bridge.errors import LinkError
from nao_hil.naoqi_programs.errors import print_error
from nao_hil.naoqi_programs.source import compiled, program_code

ADDRESS: Final = "NAO_HIL_NAOQI"
MODULES: Final = Path(__file__).parent / "modules"
PATIENCE: Final = 20.0
"""s that NAOqi has to answer, on a busy machine; qi itself would wait for ever for what is no NAOqi."""


def _redirect(url: str) -> None:
    """Lead every session and application of qi to one address.

    Raises:
        LinkError: no NAOqi answers there.
    """
    connected(url, PATIENCE).close()
    import qi

    from nao_hil.naoqi_programs.pictures import SERVICE, VideoProxy

    session, application = qi.Session, qi.Application

    def session_here(*_: Any) -> Any:
        """A session that connects to the served robot, whatever address it is given."""
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


class ProgramLoader(SourceFileLoader):
    """Of modules beside the program, which may be in Python 2 as well."""

    def source_to_code(self, data: Any, path: Any, **_: Any) -> CodeType:  # type: ignore[override]
        """The code of a source."""
        return compiled(bytes(data), str(path))


def _interrupt_once() -> None:
    """Let SIGTERM be a Ctrl-C to the program, but for one that comes after a Ctrl-C.

    A terminal sends Ctrl-C to this process and to `run-naoqi`, which then sends SIGTERM: of both the program
    gets one KeyboardInterrupt, and may lay the robot to rest.
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


def main(program: str, arguments: list[str]) -> int:
    """Run a program; its exit code."""
    try:
        _redirect(os.environ[ADDRESS])
    except LinkError as error:
        print(f"error: {error} Stop what listens there, or give another --url.", file=sys.stderr)
        return error.exit_code
    beside = str(Path(program).resolve().parent)
    sys.path[0:0] = [beside, str(MODULES)]
    sys.path_importer_cache[beside] = FileFinder(beside, (ProgramLoader, [".py"]))
    sys.argv = [program, *arguments]
    module = sys.modules["__main__"] = ModuleType("__main__")
    module.__file__ = program
    try:
        exec(program_code(Path(program)), vars(module))
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


if __name__ == "__main__":
    _interrupt_once()
    _code = main(sys.argv[1], sys.argv[2:])
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(_code & 255)
