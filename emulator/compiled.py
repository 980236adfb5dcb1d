"""Numerical loops as machine code: numba compiles them at their first call, no compiler is needed.

The machine code is kept beside the sources, or in the user's cache folder where the sources cannot be written;
`NUMBA_CACHE_DIR` names another folder. Where no folder can be written, every process compiles again.

The first start of a fresh installation waits until all are compiled. So they are written as loops: the first
tuple assigned to a slice, the first expression of whole arrays and `np.interp` take one to two seconds each.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import ModuleType
from typing import Final, TypeVar

import numba
from numba.core.registry import cpu_target
from numba.extending import register_jitable

Function = TypeVar("Function", bound=Callable[..., object])


BLAS: Final = "scipy.linalg.cython_blas"
"""Module of which numba's library asks whether it is there, before the first call of any function."""


def _load_library() -> None:
    """Load numba's library without `scipy.linalg`, which takes a third of the time, in each start of a robot.

    No loop here needs it. A function that multiplies matrices loads it when it is compiled.
    """
    if BLAS in sys.modules:
        return
    sys.modules[BLAS] = ModuleType(BLAS)  # SciPy is always there: the answer is yes
    try:
        cpu_target.target_context.refresh()
    finally:
        del sys.modules[BLAS]


_load_library()


def compiled(function: Function, *, nogil: bool = False) -> Function:
    """The function as machine code, in strict IEEE arithmetic in the order in which it is written.

    Args:
        function: To compile. The kept code is renewed when its own file changes, not when the file of a
            function that it calls does: delete `__pycache__` then.
        nogil: It runs without Python's lock, beside other threads.
    """
    kept: Function
    try:
        kept = numba.njit(cache=True, nogil=nogil)(function)
    except RuntimeError:  # no folder can be written
        kept = numba.njit(function, nogil=nogil)
    return kept


def compilable(function: Function) -> Function:
    """The function as it is, which `compiled` functions call as machine code."""
    kept: Function = register_jitable(function)
    return kept
