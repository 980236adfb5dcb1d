"""For all tests: Ctrl-C that children can hear, no real-time priority, properties' examples, installed engines.

A shell starts background jobs with SIGINT ignored, and what is ignored stays so in every child; a handler of
this process is the default in its children.
"""

from __future__ import annotations

import ctypes
import gc
import os
import resource
import signal
import sys
from importlib.util import find_spec
from typing import Final

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

_PR_CAPBSET_DROP: Final = 24
"""Number of the prctl request (Linux): processes that are started from now on lack a capability."""
_CAP_SYS_NICE: Final = 23


def pytest_configure(config: pytest.Config) -> None:
    """Tests that run beside others start no process with a real-time priority.

    Root may have it; a robot that has it takes the processor from the tests of all other workers.
    """
    if "not realtime" in config.option.markexpr and sys.platform == "linux":
        resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
        ctypes.CDLL(None).prctl(_PR_CAPBSET_DROP, _CAP_SYS_NICE, 0, 0, 0)


@pytest.fixture(autouse=True)
def _ordinary_process(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor do they get it themselves, and with them all later tests: as from a bridge in a thread."""
    if request.node.get_closest_marker("realtime") is None:
        monkeypatch.setattr("bridge.realtime.request_real_time", lambda _: False)


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
