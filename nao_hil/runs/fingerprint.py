"""Hash of all that a result depends on: sources, shipped data, versions of libraries, and the task itself."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final

ROOT: Final = Path(__file__).parents[2]
IN_PROCESS: Final = ("bridge", "emulator", "walker", "nao_hil/__init__.py", "nao_hil/runs")
"""Sources and data of a walk in process. Nothing in them imports another part of nao_hil (import-linter)."""
PROCESSES: Final = ("bridge", "emulator", "walker", "nao_hil")
"""Sources and data of walks that are started as `nao-hil` commands."""
LIBRARIES: Final = ("numpy", "scipy", "numba", "pybullet", "mujoco", "msgspec")
"""Packages whose version may change a number."""


def fingerprint(*parts: Any, sources: Sequence[str] = IN_PROCESS) -> str:
    """Hash of a task and of all that it depends on, 32 hexadecimal digits.

    Args:
        parts: What the result depends on beside sources and libraries; values whose `repr` shows every field.
        sources: Files and folders that the task runs, relative to the root of the packages.
    """
    everything = (parts, source_hash(tuple(sources)), library_versions())
    return hashlib.sha256(repr(everything).encode()).hexdigest()[:32]


@cache
def source_hash(parts: tuple[str, ...] = IN_PROCESS, root: Path = ROOT) -> str:
    """SHA-256 over names and contents of all files in `parts`, read once per process.

    Args:
        parts: Files and folders, relative to `root`.
        root: Folder of the packages.
    """
    digest = hashlib.sha256()
    for part in parts:
        path = root / part
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file() and "__pycache__" not in file.parts:
                digest.update(f"{file.relative_to(root)}\0{file.stat().st_size}\0".encode())
                digest.update(file.read_bytes())
    return digest.hexdigest()


@cache
def library_versions() -> tuple[tuple[str, str], ...]:
    """Name and version of Python, of the machine's architecture, and of the libraries that compute."""
    own = (("python", platform.python_version()), ("machine", platform.machine()))
    return (*own, *((name, _version(name)) for name in LIBRARIES))


def _version(package: str) -> str:
    """An engine may be missing where the other is."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
