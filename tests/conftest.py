"""For all tests: a Ctrl-C that children can hear, and the engines that are installed.

A shell starts background jobs with SIGINT ignored, and what is ignored stays so in every child; a handler of
this process is the default in its children.
"""

from __future__ import annotations

import signal
from importlib.util import find_spec

import pytest

from emulator.engine.catalogue import ENGINES

signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(params=ENGINES)
def physics(request: pytest.FixtureRequest) -> str:
    """Name of a physics engine; what holds in the world holds on each."""
    name: str = request.param
    if find_spec(name) is None:
        pytest.skip(f"{name} is not installed")
    return name
