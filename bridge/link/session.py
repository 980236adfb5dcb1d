"""Zenoh sessions as this project opens them: one machine, no router process, no multicast, no configuration.

The robot's session is a Zenoh node in `router` mode that listens on one endpoint, so that everyone connected
to it (walker, viewer, recorder) also hears one another; all others are clients that keep trying to connect.
"""

from __future__ import annotations

import json
import re
from typing import Any, Final

import zenoh

from bridge.errors import ConfigurationError, LinkError

RETRY: Final = {"period_init_ms": 10, "period_max_ms": 50, "period_increase_factor": 1.5}
"""Reconnects within tens of milliseconds instead of Zenoh's seconds."""
MAX_PAYLOAD: Final = 1 << 20
"""Largest message anyone may send to the robot side, bytes."""


def _config(settings: dict[str, Any]) -> zenoh.Config:
    config = zenoh.Config()
    common = {
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "transport/shared_memory/enabled": False,
    }
    for name, value in (common | settings).items():
        config.insert_json5(name, json.dumps(value))
    return config


def _open(settings: dict[str, Any], what: str) -> zenoh.Session:
    try:
        return zenoh.open(_config(settings))
    except zenoh.ZError as error:
        # Zenoh's own text carries source paths of its build; only the system's reason is of use to a person.
        reason = re.search(r"([A-Z][\w ]+) \(os error \d+\)", str(error))
        raise LinkError(f"{what}: {reason[1] if reason else 'zenoh refused'}.") from None


def check_endpoint(endpoint: str) -> str:
    """The endpoint, if it looks like one.

    Raises:
        ConfigurationError: not `protocol/address`.
    """
    protocol, _, address = endpoint.partition("/")
    if protocol not in ("tcp", "tls", "quic", "udp", "ws", "unixsock-stream") or not address:
        raise ConfigurationError(f"Endpoint {endpoint!r} must look like tcp/127.0.0.1:7447.")
    if protocol in ("tcp", "udp", "tls", "quic", "ws"):
        host, _, port = address.rpartition(":")
        if not host or not port.isdigit() or not 0 < int(port) < 65536:
            raise ConfigurationError(f"Endpoint {endpoint!r} needs a host and a port, as in tcp/127.0.0.1:7447.")
    return endpoint


def open_robot(listen: str) -> zenoh.Session:
    """The robot side's session.

    Raises:
        ConfigurationError: not an endpoint.
        LinkError: the endpoint cannot be listened on, for example because its port is in use.
    """
    settings = {"mode": "router", "listen/endpoints": [check_endpoint(listen)]}
    return _open(settings, f"Cannot listen on {listen} (another robot there? --listen takes another place)")


def open_client(connect: str) -> zenoh.Session:
    """A session of anyone else; returns at once and connects as soon as the robot side is there.

    Raises:
        ConfigurationError: not an endpoint.
    """
    settings = {
        "mode": "client",
        "connect/endpoints": [check_endpoint(connect)],
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "connect/retry": RETRY,
    }
    return _open(settings, f"Cannot open a session towards {connect}")
