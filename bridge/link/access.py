"""Rights on the link: access-control rules by key expression, in force at the robot's node.

Everyone is a client of the robot's node, so that every message between two parties passes these rules. What no
rule allows is dropped. A role is the common name of a certificate.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from bridge.link import keys
from bridge.link.certificates import ROLES

_EVERYTHING: Final = "**"


class Rights(NamedTuple):
    """Key suffixes of a role."""

    hears: tuple[str, ...]
    """Publications."""
    asks: tuple[str, ...]
    """Queries."""
    publishes: tuple[str, ...] = ()
    answers: tuple[str, ...] = ()
    """Queries of others."""
    lives: tuple[str, ...] = ()
    """Liveliness tokens."""


RIGHTS: Final = {
    "listener": Rights(hears=(_EVERYTHING,), asks=(keys.INFO, "guard")),
    "controller": Rights(
        hears=(keys.SENSORS, keys.GUARD, keys.NOTICES, "walk/**"),
        asks=(keys.INFO, "guard", "stop", "arm", keys.LEASE, "dcm/**", "walk/**"),
        publishes=(keys.ACTUATORS, keys.LEDS, "walk/**"),
        answers=("walk/**",),
        lives=(keys.ALIVE_CONTROLLERS,),
    ),
    "world": Rights(hears=(_EVERYTHING,), asks=(keys.INFO, "guard", "stop", "arm", "world/**")),
}
"""The robot itself is the node that enforces them; a second one gets no rights at all."""

_TELL: Final = ("put", "delete")
_ASK: Final = ("query",)


def access_control() -> dict[str, Any]:
    """Zenoh's `access_control` configuration of a robot's node, whatever the robot's id."""
    rules: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []

    def allow(role: str, flow: str, messages: tuple[str, ...], suffixes: tuple[str, ...]) -> None:
        """Let a role's messages of these kinds pass one way, on these keys; no rule without a key."""
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
        allow(role, "ingress", ("declare_subscriber",), rights.hears)
        allow(role, "egress", _TELL, rights.hears)
        allow(role, "ingress", _TELL, rights.publishes)
        allow(role, "egress", ("declare_subscriber",), rights.publishes)
        allow(role, "ingress", _ASK, rights.asks)
        allow(role, "egress", ("reply", "declare_queryable"), rights.asks)
        allow(role, "ingress", ("reply", "declare_queryable"), rights.answers)
        allow(role, "egress", _ASK, rights.answers)
        allow(role, "ingress", ("liveliness_token",), rights.lives)
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
