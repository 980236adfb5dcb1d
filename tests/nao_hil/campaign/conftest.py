"""For all tests of campaigns."""

from __future__ import annotations

import gc
import warnings
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True)
def sockets_that_dask_leaves() -> Iterator[None]:
    """Distributed leaves sockets to the garbage collector: they are collected here, and blamed on no test."""
    yield
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        gc.collect()
