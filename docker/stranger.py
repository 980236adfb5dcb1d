"""What a party on the robot's network can do, tried with bare Zenoh: one JSON object on stdout.

Usage: stranger.py [KEYS]; without a folder of certificates it tries plain text, and TLS without a certificate.
It prints `listening` as soon as it would hear the robot; it waits `PATIENCE` seconds for a first frame.
"""

import json
import os
import sys
import threading
from pathlib import Path
from typing import Any

import zenoh

HOST = "emulator:7447"
TIMEOUT = 2.0
PATIENCE = 120.0


def attempts(keys: Path | None) -> list[dict[str, Any]]:
    """Settings of the sessions to try."""
    tls = "transport/link/tls/"
    if keys is None:
        bare = {"endpoint": f"tls/{HOST}", tls + "verify_name_on_connect": False}
        return [{"endpoint": f"tcp/{HOST}"}, bare]
    return [
        {
            "endpoint": f"tls/{HOST}",
            tls + "root_ca_certificate": str(keys / "ca.pem"),
            tls + "connect_certificate": str(keys / "certificate.pem"),
            tls + "connect_private_key": str(keys / "key.pem"),
            tls + "enable_mtls": True,
        }
    ]


def try_all(settings: dict[str, Any]) -> dict[str, bool]:
    """Listen, ask for the lease, send a command, touch the world."""
    config = zenoh.Config()
    settings = {"mode": "client", "connect/endpoints": [settings.pop("endpoint")], **settings}
    for name, value in ({"connect/timeout_ms": 0, "scouting/multicast/enabled": False} | settings).items():
        config.insert_json5(name, json.dumps(value))
    try:
        session = zenoh.open(config)
    except zenoh.ZError:
        return {}
    heard = threading.Event()
    subscriber = session.declare_subscriber("nao/nao/sensors", lambda _: heard.set())

    def answered(key: str, payload: bytes) -> bool:
        replies = session.get(key, payload=payload, timeout=TIMEOUT)
        return any(
            r.ok is not None or (r.err is not None and r.err.payload.to_string() != "Timeout") for r in replies
        )

    lease = answered("nao/nao/lease", b"\x82\xa2op\xa6status\xaacontroller\xa5thief")
    world = answered("nao/nao/world/command", b"\x80")
    print("listening", flush=True)
    heard.wait(PATIENCE)
    subscriber.undeclare()
    return {"listened": heard.is_set(), "commanded": lease, "world": world}


def main() -> None:
    """Try everything; whatever worked once counts."""
    keys = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    found = [try_all(settings) for settings in attempts(keys)]
    result = {name: any(f.get(name) for f in found) for name in ("listened", "commanded", "world")}
    print(json.dumps(result | {"connected": any(found)}), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
