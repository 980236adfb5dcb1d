"""Whether a robot answers, or a controller is there: the health check of the containers.

Usage: python -m nao_hil.runs.health, with ROBOT (id), CONNECT (endpoint) and ROLE (`robot` or `controller`) in
the environment. Exit code 0 or 1.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Mapping
from typing import Final

import zenoh

from bridge.errors import NaoHilError
from bridge.link import keys
from bridge.link.session import open_client

TIMEOUT: Final = 3.0
"""Patience with an answer, s."""


def healthy(environment: Mapping[str, str]) -> bool:
    """Check once.

    Args:
        environment: with `ROBOT`, `CONNECT` and `ROLE`; the defaults are those of the commands.

    Raises:
        NaoHilError: no answer there, or the certificates do not fit.
    """
    robot = environment.get("ROBOT", keys.DEFAULT_ROBOT)
    endpoint = environment.get("CONNECT", keys.DEFAULT_ENDPOINT)
    with contextlib.closing(open_client(endpoint, TIMEOUT)) as session:
        if environment.get("ROLE", "robot") == "robot":
            replies = session.get(keys.key(robot, keys.INFO), timeout=TIMEOUT)
        else:
            replies = session.liveliness().get(keys.key(robot, keys.ALIVE_CONTROLLERS), timeout=TIMEOUT)
        return any(isinstance(reply, zenoh.Reply) and reply.ok is not None for reply in replies)


def main() -> None:
    """Entry point; prints only the reason of a failure."""
    try:
        good = healthy(os.environ)
    except NaoHilError as error:
        print(f"error: {error}", file=sys.stderr)
        good = False
    sys.stdout.flush()
    os._exit(0 if good else 1)  # as the other commands: Zenoh's threads would take their time


if __name__ == "__main__":
    main()
