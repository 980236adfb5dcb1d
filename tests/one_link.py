"""One Zenoh link for several robots, each of which is the router of its own."""

from __future__ import annotations

import json
from collections.abc import Sequence

import zenoh


def one_link(endpoints: Sequence[str]) -> zenoh.Session:
    """A router that connects to those of all robots, now or whenever they start; close it.

    Whoever is connected to one of the robots hears all of them then.

    Args:
        endpoints: of the robots, without certificates.
    """
    settings = {
        "mode": "router",
        "listen/endpoints": [],
        "connect/endpoints": list(endpoints),
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 10, "period_max_ms": 50, "period_increase_factor": 1.5},
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
    }
    config = zenoh.Config()
    for name, value in settings.items():
        config.insert_json5(name, json.dumps(value))
    return zenoh.open(config)
