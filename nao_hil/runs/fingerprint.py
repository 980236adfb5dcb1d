"""Hash of all that a result depends on: sources, shipped data, libraries and their kernels, the task itself.

The last digit of a sine or of a product of matrices depends on the processor: glibc, NumPy and OpenBLAS choose
a kernel by its features when they are loaded. `numerics` shows whether two hosts compute alike.
"""

from __future__ import annotations

import ctypes
import hashlib
import math
import platform
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final

import numpy as np

from emulator.engine.catalogue import ENGINES

ROOT: Final = Path(__file__).parents[2]
IN_PROCESS: Final = (
    "bridge",
    "emulator",
    "walker",
    "nao_hil/__init__.py",
    "nao_hil/arguments.py",
    "nao_hil/files.py",
    "nao_hil/runs",
)
"""Sources and data of a walk in process. Nothing in them imports another part of nao_hil (import-linter)."""
PROCESSES: Final = ("bridge", "emulator", "walker", "nao_hil")
"""Sources and data of walks that are started as `nao-hil` commands."""
LIBRARIES: Final = ("numpy", "scipy", "numba", *ENGINES, "msgspec", "onnxruntime")
"""Packages whose version may change a number."""


def fingerprint(*parts: Any, sources: Sequence[str] = IN_PROCESS) -> str:
    """Hash of a task and of all that it depends on, 32 hexadecimal digits.

    Args:
        parts: Inputs of the result other than sources and libraries; values whose `repr` shows every field.
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
    """Name and version of Python, of the machine, of the libraries that compute, and of their results."""
    own = (("python", platform.python_version()), ("machine", platform.machine()), ("numerics", numerics()))
    return (*own, *((name, package_version(name)) for name in LIBRARIES))


def package_version(package: str) -> str:
    """Version of a package; an engine may be missing."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


@cache
def numerics() -> str:
    """Hash of results of libm, NumPy and BLAS, 16 hexadecimal digits: equal on hosts that compute alike."""
    x = np.linspace(-3.0, 3.0, 1001)
    digest = hashlib.sha256()
    for scalar in (math.sin, math.cos, math.tan, math.exp, math.atan, math.sinh, math.tanh):
        digest.update(np.array([scalar(value) for value in x.tolist()]).tobytes())
    digest.update(np.array([math.atan2(value, 1.3) for value in x.tolist()]).tobytes())
    for vector in (np.sin, np.cos, np.tan, np.exp, np.arctan, np.sinh, np.tanh):
        digest.update(vector(x).tobytes())
    for bounded in (np.arcsin, np.arccos):
        digest.update(bounded(x / 3.0).tobytes())
    matrix = np.sin(np.arange(900.0)).reshape(30, 30) + 5.0 * np.eye(30)
    for size in (2, 3, 6, 30):
        part = np.ascontiguousarray(matrix[:size, :size])
        for result in (part @ part, part @ x[:size], x[:size] @ x[-size:], np.linalg.solve(part, x[:size])):
            digest.update(np.asarray(result).tobytes())
    return digest.hexdigest()[:16]


def kernels() -> dict[str, str]:
    """Inputs of `numerics`: processor, libm, OpenBLAS's kernel, NumPy's instruction sets."""
    features = import_module("numpy._core._multiarray_umath").__cpu_features__  # loaded with NumPy; not public
    names = (
        line.partition(":")[2].strip() for line in _lines("/proc/cpuinfo") if line.startswith("model name")
    )
    return {
        "processor": next(names, platform.processor() or "unknown"),
        "libm": " ".join(platform.libc_ver()).strip() or "unknown",
        "openblas": _openblas_kernel(),
        "instruction_sets": " ".join(sorted(name for name, used in features.items() if used)),
        "numerics": numerics(),
    }


def _openblas_kernel() -> str:
    """NumPy's BLAS kernel; `unknown` for another BLAS."""
    for library in Path(np.__file__).parent.with_name("numpy.libs").glob("*openblas*"):
        name = getattr(ctypes.CDLL(str(library)), "scipy_openblas_get_corename64_", None)
        if name is not None:
            name.restype = ctypes.c_char_p
            return str(name().decode())
    return "unknown"


def _lines(file: str) -> list[str]:
    try:
        return Path(file).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
