"""For all tests: a Ctrl-C that children can hear, properties' examples, and the engines that are installed.

A shell starts background jobs with SIGINT ignored, and what is ignored stays so in every child; a handler of
this process is the default in its children.
"""

from __future__ import annotations

import gc
import os
import signal
from importlib.util import find_spec

import pytest
from hypothesis import HealthCheck, settings

from emulator.engine.catalogue import ENGINES

signal.signal(signal.SIGINT, signal.default_int_handler)
gc.disable()  # until all tests are collected
os.nice = lambda increment: 0  # a page gives way; here it shares its process with later tests
# The same examples on every day, and however long a busy machine takes for one.
settings.register_profile(
    "repeatable",
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("repeatable")


def pytest_collection_finish() -> None:
    """Later collections of garbage do not look through four thousand tests and all libraries (0.4 s each)."""
    gc.collect()
    gc.freeze()
    gc.enable()


@pytest.fixture(params=ENGINES)
def physics(request: pytest.FixtureRequest) -> str:
    """Name of a physics engine; what holds in the world holds on each."""
    name: str = request.param
    if find_spec(name) is None:
        pytest.skip(f"{name} is not installed")
    return name
