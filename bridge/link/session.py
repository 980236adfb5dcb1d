"""Zenoh sessions as this project opens them: one machine, no router process, no multicast, no configuration.

The robot's session is a Zenoh node in `router` mode that listens on one endpoint, so that everyone connected
to it (walker, viewer, recorder) also hears one another; all others are clients that keep trying to connect.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable
from typing import Any, Final

import zenoh
from zenoh.handlers import Callback

from bridge.errors import ConfigurationError, LinkError, RobotSilent

RETRY: Final = {"period_init_ms": 10, "period_max_ms": 50, "period_increase_factor": 1.5}
"""Reconnects within tens of milliseconds instead of Zenoh's seconds."""
MAX_RECEIVED: Final = 1 << 20
"""bytes; Zenoh itself drops longer messages, so that nobody can fill the memory of the robot side."""
OPEN_TIMEOUT: Final = 1000
"""ms an attempt to connect may take."""


def _config(settings: dict[str, Any]) -> zenoh.Config:
    config: zenoh.Config = zenoh.Config()
    common = {
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "transport/link/rx/max_message_size": MAX_RECEIVED,
        "transport/shared_memory/enabled": False,
    }
    for name, value in (common | settings).items():
        config.insert_json5(name, json.dumps(value))
    return config


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
        if not host or not port.isdecimal() or not 0 < int(port) < 65536:
            raise ConfigurationError(
                f"Endpoint {endpoint!r} needs a host and a port, as in tcp/127.0.0.1:7447."
            )
    return endpoint


def open_robot(listen: str) -> zenoh.Session:
    """The robot side's session.

    Raises:
        ConfigurationError: not an endpoint.
        LinkError: the endpoint cannot be listened on, for example because its port is in use.
    """
    settings = {"mode": "router", "listen/endpoints": [check_endpoint(listen)]}
    try:
        return zenoh.open(_config(settings))
    except zenoh.ZError as error:
        # Zenoh's own text carries source paths of its build; only the system's reason is of use to a person.
        reason = re.search(r"([A-Z][\w ]+) \(os error \d+\)", str(error))
        raise LinkError(
            f"Cannot listen on {listen}: {reason[1] if reason else 'zenoh refused'}; stop what is there, or "
            "take another place with --listen."
        ) from None


def try_client(connect: str) -> zenoh.Session | None:
    """A session of anyone else, or None when nobody listens there (yet).

    One attempt, a millisecond on one machine: Zenoh's own wait for the first connection sees no Ctrl-C. Once
    open, the session connects again by itself whenever the robot side is back.

    Raises:
        ConfigurationError: not an endpoint.
    """
    settings = {
        "mode": "client",
        "connect/endpoints": [check_endpoint(connect)],
        "connect/timeout_ms": 0,
        "connect/retry": RETRY,
        "transport/unicast/open_timeout": OPEN_TIMEOUT,
    }
    try:
        return zenoh.open(_config(settings))
    except zenoh.ZError:
        return None


def open_client(connect: str, timeout: float = 10.0) -> zenoh.Session:
    """As `try_client`, again and again.

    Raises:
        ConfigurationError: not an endpoint.
        RobotSilent: nobody listened there for `timeout` s.
    """
    deadline = time.monotonic() + timeout
    while (session := try_client(connect)) is None:
        if time.monotonic() > deadline:
            raise RobotSilent(f"Nobody listened at {connect} for {timeout:g} s; start a robot there.")
        time.sleep(0.02)
    return session


def subscribe(session: zenoh.Session, key: str, receive: Callable[[bytes], None]) -> Any:
    """Call `receive` with each payload in Zenoh's own receiving thread.

    So what one sender sent arrives here in the order of its sending, also over several keys; Zenoh's default,
    a thread for each subscriber, does not keep that order. `receive` must be short and must not raise.
    """

    def on_sample(sample: zenoh.Sample) -> None:
        receive(sample.payload.to_bytes())

    return session.declare_subscriber(key, Callback(on_sample, indirect=False))
