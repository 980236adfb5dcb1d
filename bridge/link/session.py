"""Zenoh sessions as this project opens them: one machine, no router process, no multicast; rights by key.

The robot's session is a Zenoh node in `router` mode that listens on one endpoint, so that everyone connected
to it (walker, viewer, recorder) receives the others' messages; all others are clients with retries.
"""

from __future__ import annotations

import errno
import json
import logging
import re
import socket
import time
from collections.abc import Callable, Iterable
from ipaddress import ip_address
from typing import Any, Final, NamedTuple

import zenoh
from zenoh.handlers import Callback

from bridge.errors import ConfigurationError, LinkError, RobotSilent
from bridge.link import keys
from bridge.link.certificates import OPEN_MARK, ROLES, check_peer, load_certificates, split_endpoint
from bridge.messages.topics import TOPICS, Side, sent_by

_ALL_KEYS: Final = "**"
logger = logging.getLogger(__name__)


class Rights(NamedTuple):
    """Key suffixes of a role."""

    subscribes: tuple[str, ...]
    """Publications."""
    queries: tuple[str, ...]
    """Queries."""
    publishes: tuple[str, ...] = ()
    serves: tuple[str, ...] = ()
    """Queries of others."""
    tokens: tuple[str, ...] = ()
    """Liveliness tokens."""


RIGHTS: Final = {
    "listener": Rights(subscribes=(_ALL_KEYS,), queries=(keys.INFO, "guard")),
    "controller": Rights(
        subscribes=(*(topic.suffix for topic in TOPICS.values() if topic.receiver == "controller"), "walk/**"),
        queries=(keys.INFO, "guard", "stop", "arm", keys.LEASE, "dcm/**", "walk/**"),
        publishes=(*sent_by("controller").values(), "walk/**"),
        serves=("walk/**",),
        tokens=(keys.ALIVE_CONTROLLERS,),
    ),
    "world": Rights(subscribes=(_ALL_KEYS,), queries=(keys.INFO, "guard", "stop", "arm", "world/**")),
}
"""Enforced by the robot's node; a second robot has no rights."""

_PUBLICATIONS: Final = ("put", "delete")
_QUERIES: Final = ("query",)


def access_control() -> dict[str, Any]:
    """Zenoh's `access_control` configuration of a robot's node, for any id."""
    rules: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []

    def allow(role: str, flow: str, messages: tuple[str, ...], suffixes: tuple[str, ...]) -> None:
        """Allow a role's messages of these kinds in one direction on these keys."""
        if suffixes:
            rules.append(
                {
                    "id": f"{role}-{len(rules)}",
                    "permission": "allow",
                    "flows": [flow],
                    "messages": list(messages),
                    "key_exprs": [keys.key("*", suffix) for suffix in suffixes],
                }
            )

    for role, rights in RIGHTS.items():
        first = len(rules)
        allow(role, "ingress", ("declare_subscriber",), rights.subscribes)
        allow(role, "egress", _PUBLICATIONS, rights.subscribes)
        allow(role, "ingress", _PUBLICATIONS, rights.publishes)
        allow(role, "egress", ("declare_subscriber",), rights.publishes)
        allow(role, "ingress", _QUERIES, rights.queries)
        allow(role, "egress", ("reply", "declare_queryable"), rights.queries)
        allow(role, "ingress", ("reply", "declare_queryable"), rights.serves)
        allow(role, "egress", _QUERIES, rights.serves)
        allow(role, "ingress", ("liveliness_token",), rights.tokens)
        allow(role, "ingress", ("declare_liveliness_subscriber", "liveliness_query"), ("alive/**",))
        allow(role, "egress", ("liveliness_token",), ("alive/**",))
        policies.append({"subjects": [role], "rules": [rule["id"] for rule in rules[first:]]})
    assert set(RIGHTS) <= set(ROLES)
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{"id": role, "cert_common_names": [role]} for role in RIGHTS],
        "policies": policies,
    }


RECONNECT: Final = {"period_init_ms": 10, "period_max_ms": 50, "period_increase_factor": 1.5}
"""Reconnects within tens of milliseconds instead of Zenoh's seconds."""
MAX_MESSAGE_SIZE: Final = 1 << 20
"""bytes; Zenoh itself drops longer messages, so that no sender can fill the memory of the robot side."""
SESSION_LEASE: Final = 30_000
"""ms of silence of a party after which its session ends; longer than a pause in which a machine swaps or all
processes are stopped. A party that dies ends its session at once."""
CONNECT_TIMEOUT_MS: Final = 2000
"""ms an attempt to connect may take."""
_OTHERS_TIME: Final = 2.0
"""s without a robot after which the robots that are there are reported."""
_SEARCH_TIME: Final = 5.0
"""s without any robot after which that is reported."""
_ROBOTS_TIMEOUT: Final = 5.0
"""s to wait for the robots of a link to answer; their node answers for all at once, a starved one late."""
MAX_SESSIONS: Final = 32
"""Parties that the robot's node takes at a time."""

_TLS: Final = "transport/link/tls/"


def _config(settings: dict[str, Any]) -> zenoh.Config:
    config: zenoh.Config = zenoh.Config()
    common = {
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "transport/link/tx/lease": SESSION_LEASE,
        "transport/link/rx/max_message_size": MAX_MESSAGE_SIZE,
        "transport/shared_memory/enabled": False,
    }
    for name, value in (common | settings).items():
        config.insert_json5(name, json.dumps(value))
    return config


def check_endpoint(endpoint: str) -> str:
    """The endpoint, if it looks like one.

    Raises:
        ConfigurationError: not `protocol/address`, or certificates and TLS without one another. Zenoh's `ws` is
            none of ours: its WebSocket takes connections of any site's page in a browser of this machine.
    """
    if not isinstance(endpoint, str):
        raise ConfigurationError(f"Endpoint {endpoint!r} must be text such as tcp/127.0.0.1:7447.")
    locator, folder = split_endpoint(endpoint)
    protocol, _, address = locator.partition("/")
    if protocol not in ("tcp", "tls", "udp", "unixsock-stream") or not address:
        raise ConfigurationError(f"Endpoint {endpoint!r} must look like tcp/127.0.0.1:7447.")
    if protocol == "tls" and folder is None:
        raise ConfigurationError(
            f"Endpoint {locator!r} is encrypted and needs certificates; add --keys DIR (`nao-hil keys DIR` "
            "makes them)."
        )
    if protocol != "tls" and folder is not None:
        raise ConfigurationError(
            f"Certificates (--keys {folder}) need an encrypted endpoint; write tls/{address} in place of "
            f"{locator}."
        )
    if protocol in ("tcp", "udp", "tls"):
        host, _, port = address.rpartition(":")
        if not host or not port.isdecimal() or len(port) > 5 or not 0 < int(port) < 65536:
            raise ConfigurationError(
                f"Endpoint {locator!r} needs a host and a port of 1 to 65535, as in {protocol}/127.0.0.1:7447."
            )
    return endpoint


def is_loopback(name: str) -> bool:
    """Whether a host's name or address is this machine's own."""
    if name == "localhost":
        return True
    try:
        return ip_address(name).is_loopback
    except ValueError:
        return False


def split_open(address: str, host: Callable[[str], str]) -> str:
    """The address of an adapter's server without its word `#open`.

    Args:
        address: as a user writes it.
        host: host of an address without the word; empty: none, it is on this machine.

    Raises:
        ConfigurationError: everyone on a network reaches it, and the word is missing.
    """
    plain = address.removesuffix(OPEN_MARK)
    name = host(plain)
    if name and not is_loopback(name) and plain == address:
        raise ConfigurationError(
            f"At {plain} everyone on the network could move the robot; listen on 127.0.0.1, or write "
            f"{plain}{OPEN_MARK} to let everyone."
        )
    return plain


def _require_guarded(listen: str) -> None:
    """Refuse an address that everyone on a network reaches, unless it is encrypted or ends with `#open`."""
    locator, _ = split_endpoint(listen)
    protocol, _, address = locator.partition("/")
    host = address.rpartition(":")[0].strip("[]")
    if protocol in ("tcp", "udp") and not is_loopback(host) and not listen.endswith(OPEN_MARK):
        raise ConfigurationError(
            f"At {locator} everyone on the network could move the robot; write tls/{address} and add --keys "
            f"DIR (`nao-hil keys DIR` makes them), or write {locator}{OPEN_MARK} to let everyone."
        )


def _require_network(locator: str) -> None:
    """Check that this machine can reach its own loopback, for an endpoint there.

    Raises:
        LinkError: the interface is down.
    """
    host = locator.partition("/")[2].rpartition(":")[0].strip("[]")
    if not is_loopback(host):
        return
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((host, 9))  # looks for a route, sends nothing
        except OSError as error:
            raise LinkError(
                f"{locator} cannot be reached: {error.strerror}; this machine's loopback interface is down, "
                "`ip link set lo up` starts it."
            ) from None


def open_robot(listen: str) -> zenoh.Session:
    """The robot side's session.

    Raises:
        ConfigurationError: not an endpoint, beyond loopback without certificates or `#open`, or with
            certificates that cannot be used.
        LinkError: the endpoint cannot be listened on, for example because its port is in use.
    """
    locator, folder = split_endpoint(check_endpoint(listen))
    _require_guarded(listen)
    _require_network(locator)
    settings: dict[str, Any] = {
        "mode": "router",
        "listen/endpoints": [locator],
        "transport/unicast/max_sessions": MAX_SESSIONS,
    }
    if folder is not None:
        files = load_certificates(folder, "robot")
        settings |= {
            _TLS + "root_ca_certificate": str(files.ca),
            _TLS + "listen_certificate": str(files.certificate),
            _TLS + "listen_private_key": str(files.private_key),
            _TLS + "enable_mtls": True,
            _TLS + "close_link_on_expiration": True,
            "access_control": access_control(),
        }
    try:
        return zenoh.open(_config(settings))
    except zenoh.ZError as error:
        # Zenoh's own text carries source paths of its build; only the system's reason is of use to a person.
        reason = re.search(r"([A-Z][\w ]+) \(os error \d+\)", str(error))
        raise _listen_error(listen, reason[1] if reason else "it is no place of this machine") from None


def _listen_error(listen: str, reason: str) -> LinkError:
    locator, _ = split_endpoint(listen)
    if "in use" in reason and locator.startswith("tcp/") and (session := try_client(locator)) is not None:
        with session:
            names = robots(session)
        reason += f" by robot {' and '.join(f'`{name}`' for name in names)}" if names else ""
    return LinkError(
        f"Cannot listen on {locator}: {reason}; stop its listener, or give another place with --listen."
    )


def check_free(listen: str) -> None:
    """Refuse an endpoint that has a listener.

    Args:
        listen: endpoint of a robot side that is not open yet.

    Raises:
        ConfigurationError: not an endpoint.
        LinkError: it has a listener.
    """
    locator, _ = split_endpoint(check_endpoint(listen))
    _require_guarded(listen)
    _require_network(locator)
    protocol, _, address = locator.partition("/")
    if protocol not in ("tcp", "tls"):
        return
    host, _, port = address.rpartition(":")
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as servers do after an end
        try:
            probe.bind((host.strip("[]"), int(port)))
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise _listen_error(listen, "Address already in use") from None


def try_client(connect: str, role: str = "listener", *, timestamps: bool = False) -> zenoh.Session | None:
    """A client's session; None without a listener.

    One attempt, a millisecond on one machine: Zenoh's own wait for the first connection sees no Ctrl-C. Once
    open, the session connects again by itself whenever the robot side is back.

    Args:
        connect: endpoint of the robot.
        role: of `bridge.link.certificates.ROLES`; with certificates, those of this role are shown.
        timestamps: Zenoh puts the time on each message, as publishers that keep messages need.

    Raises:
        ConfigurationError: not an endpoint, or its certificates cannot be used.
        LinkError: robot and certificates do not trust each other, or loopback is down.
    """
    locator, folder = split_endpoint(check_endpoint(connect))
    files = None if folder is None else load_certificates(folder, role)
    settings: dict[str, Any] = {
        "mode": "client",
        "connect/endpoints": [locator],
        "connect/timeout_ms": 0,
        "connect/retry": RECONNECT,
        "transport/unicast/open_timeout": CONNECT_TIMEOUT_MS,
        "timestamping/enabled": timestamps,
    }
    if files is not None:
        settings |= {
            _TLS + "root_ca_certificate": str(files.ca),
            _TLS + "connect_certificate": str(files.certificate),
            _TLS + "connect_private_key": str(files.private_key),
            _TLS + "enable_mtls": True,
            _TLS + "verify_name_on_connect": True,
            _TLS + "close_link_on_expiration": True,
        }
    try:
        return zenoh.open(_config(settings))
    except zenoh.ZError:
        _require_network(locator)
        if files is not None:
            check_peer(locator, files)
        return None


def require_seconds(name: str, value: object) -> None:
    """Refuse a time to wait that is not positive and finite.

    Args:
        name: of the argument, for the message.
        value: it.

    Raises:
        ConfigurationError: not a number, or less than 0.
    """
    if not isinstance(value, int | float) or not value >= 0.0:
        raise ConfigurationError(f"{name} is {value!r}; seconds from 0 on are expected.")


def open_client(connect: str, timeout: float = 10.0, role: str = "listener") -> zenoh.Session:
    """As `try_client`, repeated until a listener answers.

    Raises:
        ConfigurationError, LinkError: as `try_client`.
        RobotSilent: no listener there for `timeout` s.
    """
    deadline = time.monotonic() + timeout
    while (session := try_client(connect, role)) is None:
        if time.monotonic() > deadline:
            raise RobotSilent(f"No robot listened at {connect} for {timeout:g} s; start one there.")
        time.sleep(0.02)
    return session


def robots(session: zenoh.Session) -> list[str]:
    """Ids of the robots of a link, `nao2` before `nao10`."""
    replies = session.liveliness().get(keys.key("*", keys.ALIVE_ROBOT), timeout=_ROBOTS_TIMEOUT)
    names = {str(reply.ok.key_expr).split("/")[1] for reply in replies if reply.ok is not None}
    return in_order(names)


def in_order(names: Iterable[str]) -> list[str]:
    """Names by the alphabet, digits as numbers: `nao2` before `nao10`."""

    def key(name: str) -> list[tuple[int, str]]:
        return [(int(part or 0), "") if i % 2 else (0, part) for i, part in enumerate(re.split(r"(\d+)", name))]

    return sorted(names, key=key)


def other_robots(session: zenoh.Session, robot: str) -> str:
    """Clause that lists the robots of a link without this one; empty: it is there, or none is.

    Args:
        session: of the link.
        robot: id of the silent robot.
    """
    names = robots(session)
    if not names or robot in names:
        return ""
    listed = ", ".join(f"`{name}`" for name in names)
    return f"; {listed} {'is' if len(names) == 1 else 'are'} there (--name)"


class Search:
    """A wait for a robot, reported once where it is long.

    Args:
        robot: its id.
        connect: Zenoh endpoint of its link.
    """

    def __init__(self, robot: str, connect: str) -> None:
        self._robot, self._endpoint, self._began, self._reported = robot, connect, time.monotonic(), False

    def failed(self, session: zenoh.Session | None) -> None:
        """It is not there yet; `session`: of the link, None without one."""
        waited = time.monotonic() - self._began
        if self._reported or waited < _OTHERS_TIME:
            return
        if session is not None and (others := other_robots(session, self._robot)):
            text = f"There is no robot `{self._robot}` at {self._endpoint}{others}."
        elif waited > _SEARCH_TIME:
            text = (
                f"No robot `{self._robot}` answers at {self._endpoint}; start one with `nao-hil emulate`, or "
                "give its address with --connect."
            )
        else:
            return
        self._reported = True
        logger.warning("%s Waiting for it.", text)


def declare_publishers(session: zenoh.Session, robot: str, side: Side) -> dict[type[Any], zenoh.Publisher]:
    """A publisher for each kind of message that a side of a robot's link publishes."""
    return {kind: session.declare_publisher(keys.key(robot, suffix)) for kind, suffix in sent_by(side).items()}


def subscribe(session: zenoh.Session, key: str, receive: Callable[[bytes], None]) -> Any:
    """Call `receive` with each payload in Zenoh's own receiving thread.

    Messages of one sender arrive in the order of sending, also over several keys; Zenoh's
    default, a thread for each subscriber, does not keep that order. `receive` must be short and must not raise.
    """

    def on_sample(sample: zenoh.Sample) -> None:
        receive(sample.payload.to_bytes())

    return session.declare_subscriber(key, Callback(on_sample, indirect=False))
