"""Numerical loops as machine code: numba compiles them at their first call, no compiler is needed.

The machine code is kept beside the sources, or in the user's cache folder where the sources cannot be written;
`NUMBA_CACHE_DIR` names another folder. Where no folder can be written, every process compiles anew.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numba

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """The function as machine code, in strict IEEE arithmetic in the order in which it is written."""
    kept: Function
    try:
        kept = numba.njit(cache=True)(function)
    except RuntimeError:  # no folder can be written
        kept = numba.njit(function)
    return kept
