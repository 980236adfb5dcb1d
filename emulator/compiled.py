"""Numerical loops as machine code: numba compiles them at their first call, no compiler is needed.

The machine code is kept next to the sources, or in the user's cache folder where these cannot be written;
`NUMBA_CACHE_DIR` names another folder. Where no folder can be written, every process compiles again.

The first start of a fresh installation waits until all are compiled. So they are written as loops: the first
tuple assigned to a slice, the first expression of whole arrays and `np.interp` take one to two seconds each.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numba
from numba.extending import register_jitable

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function, *, nogil: bool = False) -> Function:
    """The function as machine code, in strict IEEE arithmetic in the order in which it is written.

    Args:
        function: To compile. The kept code is renewed when its own file changes, not when the file of a
            function that it calls does: delete `__pycache__` then.
        nogil: It runs without Python's lock, parallel to other threads.
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
