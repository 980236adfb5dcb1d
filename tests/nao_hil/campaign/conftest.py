"""For tests of campaigns."""

from __future__ import annotations

import gc
import warnings
from collections.abc import Iterator

import pytest


@pytest.fixture
def connections_left_open() -> Iterator[None]:
    """Dask and optuna leave connections to the garbage collector: collected here, blamed on no other test."""
    yield
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        gc.collect()
