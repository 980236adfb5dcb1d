"""A program's process: its command line, and its own modules, which may be in Python 2 as well."""

from __future__ import annotations

import os
import site
import sys
import sysconfig
from functools import partial
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader, FileFinder, SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any

from nao_hil.naoqi_programs.source import compiled


def command(code: Path | str, program: Path, arguments: list[str]) -> list[str]:
    """The command that runs a program; `python -m` would take modules from the working directory first."""
    return [sys.executable, str(Path(__file__).with_name("runner.py")), str(code), str(program), *arguments]


class ProgramLoader(SourceFileLoader):
    """Loader of modules in the program's folder, which may be in Python 2 as well; bytecode is not kept.

    Args:
        old: whether a module that both Pythons read is in Python 2.
    """

    def __init__(self, name: str, path: str, *, old: bool | None = None) -> None:
        super().__init__(name, path)
        self._old = old

    def get_code(self, fullname: str) -> CodeType:
        """The code of a module."""
        path = Path(self.path)
        package = path.parent if "." in fullname or self.is_package(fullname) else None
        return compiled(self.get_data(self.path), self.path, old=self._old, package=package)


def load_modules(old: bool) -> None:
    """Load modules from everywhere but Python's own folders and this project's by `ProgramLoader`."""
    own = [sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    own += [str(Path(__file__).parents[1]), *map(str, site.getsitepackages())]
    installed = {os.path.realpath(path) for path in own}

    def hook(path: str) -> FileFinder:
        """A finder of the program's modules in a folder."""
        place = os.path.realpath(path or os.getcwd())
        if not os.path.isdir(place) or any(place == p or place.startswith(p + os.sep) for p in installed):
            raise ImportError(path)
        extensions = (ExtensionFileLoader, EXTENSION_SUFFIXES)
        loader: Any = partial(ProgramLoader, old=old)
        return FileFinder(place, extensions, (loader, [".py"]))

    sys.path_hooks.insert(0, hook)
    sys.path_importer_cache.clear()
