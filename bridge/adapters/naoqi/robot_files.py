"""Files of a served robot: programs write below its home only, and no call waits for a file.

The robot's `/home/nao` is a folder of this machine. Files are read in threads of their own; devices and pipes
are refused.
"""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar

from bridge.adapters.naoqi.declared import Own, offers, text
from bridge.errors import NaoqiRefused

logger = logging.getLogger(__name__)

ROBOT_HOME: Final = Path("/home/nao")
HOME_PREFIX: Final = f"the robot's {ROBOT_HOME} is "
"""Begins the line of the log that names the folder."""
T = TypeVar("T")
R = TypeVar("R")
S = TypeVar("S")


def in_thread(work: Callable[[], T]) -> Future[T]:
    """Work in a thread of its own, which does not delay the end of the process."""
    done: Future[T] = Future()

    def run() -> None:
        try:
            done.set_result(work())
        except Exception as error:
            done.set_exception(error)

    threading.Thread(target=run, name="file", daemon=True).start()
    return done


class RobotFiles:
    """Files of one robot.

    Args:
        home: the folder that stands for `/home/nao`; made at the first file.
    """

    def __init__(self, home: Path, lock: threading.RLock) -> None:
        self.home, self._lock = home.absolute(), lock

    def path(self, value: Any) -> Path:
        """A path to read from: of the robot's home, if there is such a file, or of this machine."""
        given = Path(text(value, "path"))
        inside = self._in_home(given)
        return given if inside is None or not os.path.exists(self.home / inside) else self.home / inside

    def new_file(self, value: Any) -> Path:
        """A path to write to; its folder is made.

        Raises:
            NaoqiRefused: outside the robot's home, or no regular file.
        """
        inside = self._in_home(Path(text(value, "path")))
        if inside is None:
            raise NaoqiRefused(
                f"{value!r:.80} is outside the robot's home; an absolute path below {ROBOT_HOME} is expected."
            )
        file = self.home / inside
        try:
            self.made_home()
            place = file.resolve()
            if not place.is_relative_to(self.home.resolve()) or (place.exists() and not place.is_file()):
                raise NaoqiRefused(f"{value!r:.80} is no file that can be written; give another path.")
            place.parent.mkdir(parents=True, exist_ok=True)
        except (OSError, RuntimeError) as error:  # RuntimeError: links in a circle
            reason = getattr(error, "strerror", None) or error
            raise NaoqiRefused(f"{value!r:.80} cannot be written ({reason}); give another path.") from None
        return place

    @offers("NaoHil.home")
    def made_home(self) -> str:
        """The folder of this machine that stands for the robot's home; it is made."""
        if not self.home.is_dir():
            self.home.mkdir(parents=True)
            logger.info("%s%s", HOME_PREFIX, self.home)
        return str(self.home)

    def _in_home(self, given: Path) -> Path | None:
        """A path relative to the robot's home, whose name is the robot's or this machine's; None: outside."""
        plain = Path(os.path.normpath(given))
        for home in (ROBOT_HOME, self.home):
            if "\0" not in str(given) and plain.is_relative_to(home) and plain != home:
                return plain.relative_to(home)
        return None

    def load(self, source: S, read: Callable[[S], T], store: Callable[[T], R]) -> Future[R]:
        """Read a file, or a long text, in a thread of its own, then store its content.

        Args:
            read: source -> content; raises a refusal.
            store: content -> result of the call; the lock is held.
        """

        def work() -> R:
            content = read(source)
            with self._lock:
                return store(content)

        return in_thread(work)


RobotFile = Annotated[Path, Own("files.path")]
"""A file to read; the class has the `RobotFiles` as `files`."""
NewFile = Annotated[Path, Own("files.new_file")]
"""A file to write, below the robot's home; the class has the `RobotFiles` as `files`."""
