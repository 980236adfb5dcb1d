"""Nodes, publishers and subscriptions in the wire format of rmw_zenoh (its docs/design.md, ROS 2 Jazzy).

A topic is the key `<domain>/<topic>/<type>/<hash>`; a message is its CDR bytes with an attachment: number, time
and 16 bytes that name the publisher. A node and each of its publishers and subscriptions declare a liveliness
token, for discovery: `@ros2_lv/<domain>/<session>/<node>/<entity>/<kind>/...`.
"""

from __future__ import annotations

import hashlib
import itertools
import struct
import threading
import time
from collections.abc import Callable
from typing import Any, Final, Literal, NamedTuple

import zenoh
from rosbags.typesys import Stores, get_typestore
from zenoh.ext import CacheConfig, declare_advanced_publisher
from zenoh.handlers import Callback

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name

DISTROS: Final = {"humble": Stores.ROS2_HUMBLE, "jazzy": Stores.ROS2_JAZZY, "kilted": Stores.ROS2_KILTED}
NO_HASH: Final = "TypeHashNotSupported"
"""In place of a type's hash on Humble."""
MAX_DOMAIN: Final = 232
_ATTACHMENT: Final = struct.Struct("<qqB16s")
"""Number, time in ns since 1970, length of the name, name of the publisher."""
_RELIABLE, _LATCHED = "::,10:,:,:,,", ":1:,1:,:,:,,"
"""Qualities of service; empty parts are the defaults: reliable, volatile, keep last. The latched one is
transient local."""

Kind = Literal["MP", "MS"]


class Listening(NamedTuple):
    """A subscription of some node."""

    node: str
    topic: str


def check_distro(distro: str) -> str:
    """The distribution, if its types are known.

    Raises:
        ConfigurationError: they are not.
    """
    if distro not in DISTROS:
        raise ConfigurationError(unknown_name("ROS distribution", distro, DISTROS))
    return distro


def dds_name(type_name: str) -> str:
    """`std_msgs::msg::dds_::String_` for `std_msgs/msg/String`."""
    *package, name = type_name.split("/")
    return "::".join([*package, "dds_", f"{name}_"])


class RosNode:
    """One node of a ROS 2 graph; close it.

    Args:
        session: to a router of the graph, with timestamps; the node closes it.
        name: of the node.
        domain: ROS domain.
        distro: a key of `DISTROS`.
        namespace: of the node and its topics, one part; its `-` become `_`, which ROS allows. Empty: the root.

    Raises:
        ConfigurationError: an unknown domain or distribution, or a namespace that begins with a digit.
    """

    def __init__(
        self,
        session: zenoh.Session,
        name: str,
        domain: int = 0,
        distro: str = "jazzy",
        *,
        namespace: str = "",
    ) -> None:
        if namespace[:1].isdigit():
            raise ConfigurationError(
                f"Robot id {namespace} cannot be a namespace of ROS, which begins with a letter."
            )
        self._namespace = namespace.replace("-", "_")
        if not 0 <= domain <= MAX_DOMAIN:
            raise ConfigurationError(f"ROS domain {domain} is none; 0 to {MAX_DOMAIN} are.")
        self.store = get_typestore(DISTROS[check_distro(distro)])
        self._hashes = distro != "humble"
        self._name, self._domain = name, domain
        self._session = session
        self._numbers = itertools.count()
        self._entities: list[Any] = []
        self._lock = threading.Lock()
        self._listening: dict[str, Listening] = {}
        self._token("NN")
        self._entities.append(
            self._session.liveliness().declare_subscriber(
                f"@ros2_lv/{domain}/*/*/*/MS/**", Callback(self._on_token, indirect=False), history=True
            )
        )

    def _key(self, topic: str, type_name: str, type_hash: str) -> str:
        return f"{self._domain}/{topic}/{dds_name(type_name)}/{type_hash}"

    def _hash(self, type_name: str) -> str:
        return self.store.hash_rihs01(type_name) if self._hashes else NO_HASH

    def _token(self, kind: Kind | Literal["NN"], *rest: str) -> str:
        """Declare the liveliness token of the node or of one of its entities."""
        session, number = self._session.zid(), next(self._numbers)
        space = f"%{self._namespace}"
        parts = [str(self._domain), str(session), "0", str(number), kind, "%", space, self._name, *rest]
        token = "/".join(["@ros2_lv", *parts])
        self._entities.append(self._session.liveliness().declare_token(token))
        return token

    def _declare(self, kind: Kind, topic: str, type_name: str, quality: str) -> str:
        return self._token(
            kind, f"%{topic.replace('/', '%')}", dds_name(type_name), self._hash(type_name), quality
        )

    def full(self, topic: str) -> str:
        """A topic of the node's namespace, without a leading slash."""
        return f"{self._namespace}/{topic}" if self._namespace else topic

    def publisher(self, topic: str, type_name: str, *, latched: bool = False) -> Publisher:
        """A publisher.

        Args:
            topic: of the node's namespace, without a leading slash.
            type_name: as `std_msgs/msg/String`.
            latched: later subscribers get the last message.
        """
        topic = self.full(topic)
        token = self._declare("MP", topic, type_name, _LATCHED if latched else _RELIABLE)
        key = self._key(topic, type_name, self._hash(type_name))
        if latched:
            inner: Any = declare_advanced_publisher(
                self._session, key, cache=CacheConfig(max_samples=1), publisher_detection=True
            )
        else:
            inner = self._session.declare_publisher(key, congestion_control=zenoh.CongestionControl.DROP)
        return Publisher(inner, self.store, type_name, hashlib.sha256(token.encode()).digest()[:16])

    def subscribe(self, topic: str, type_name: str, receive: Callable[[Any], None]) -> None:
        """Call `receive` with each valid message of a topic of the namespace, in a thread of Zenoh's.

        The key matches any hash of the type, so publishers may be of every distribution.
        """
        topic = self.full(topic)
        self._declare("MS", topic, type_name, _RELIABLE)

        def on_sample(sample: zenoh.Sample) -> None:
            try:
                message = self.store.deserialize_cdr(sample.payload.to_bytes(), type_name)
            except Exception:  # rosbags raises any error of its generated code
                return
            receive(message)

        key = self._key(topic, type_name, "*")
        self._entities.append(self._session.declare_subscriber(key, Callback(on_sample, indirect=False)))

    def _on_token(self, sample: zenoh.Sample) -> None:
        """Note the beginning or the end of another node's subscription."""
        token = str(sample.key_expr)
        parts = token.split("/")
        if len(parts) < 13 or parts[2] == str(self._session.zid()):
            return
        with self._lock:
            if sample.kind == zenoh.SampleKind.DELETE:
                self._listening.pop(token, None)
            else:
                node = "/".join(part.replace("%", "/").strip("/") for part in parts[7:9])
                self._listening[token] = Listening("/" + node.strip("/"), parts[9].replace("%", "/").strip("/"))

    @property
    def listening(self) -> frozenset[Listening]:
        """Subscriptions of the other nodes in the domain."""
        with self._lock:
            return frozenset(self._listening.values())

    def close(self) -> None:
        """Leave the graph."""
        self._session.close()


class Publisher:
    """Publishes messages of one type; see `RosNode.publisher`."""

    def __init__(self, inner: Any, store: Any, type_name: str, name: bytes) -> None:
        self._inner, self._store, self._type, self._name = inner, store, type_name, name
        self._numbers = itertools.count(1)

    def publish(self, message: Any) -> None:
        """Publish a message."""
        payload = bytes(self._store.serialize_cdr(message, self._type))
        attachment = _ATTACHMENT.pack(next(self._numbers), time.time_ns(), 16, self._name)
        self._inner.put(payload, attachment=attachment)
