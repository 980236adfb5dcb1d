"""A controller from docs/protocol.md alone, with Zenoh, msgpack and X25519: the robot shakes its head.

nao-hil emulate                              # in one terminal
python examples/own_controller_msgpack.py    # in another; needs: pip install eclipse-zenoh msgpack cryptography
"""

import hashlib
import hmac
import itertools
import json
import math
import queue
import sys

import msgpack
import zenoh
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey

ENDPOINT = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
ROOT = "nao/nao"

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([ENDPOINT]))
config.insert_json5("scouting/multicast/enabled", "false")


def ask(session, key, message=None, seal=lambda key, payload: None):
    """Answer to a query; an error reply is a sentence."""
    payload = b"" if message is None else msgpack.packb(message)
    attachment = seal(key, payload)
    for reply in session.get(f"{ROOT}/{key}", payload=payload, attachment=attachment, timeout=30.0):
        if reply.ok is None:
            raise SystemExit(reply.err.payload.to_bytes().decode())
        return msgpack.unpackb(reply.ok.payload.to_bytes())
    raise SystemExit(f"Nobody answers {key} at {ENDPOINT}.")


with zenoh.open(config) as session:
    frames = queue.SimpleQueue()
    session.declare_subscriber(f"{ROOT}/sensors", lambda sample: frames.put(sample.payload.to_bytes()))
    info = ask(session, "info")
    private = X25519PrivateKey.generate()
    request = {"version": 3, "controller": "shaker", "key": private.public_key().public_bytes_raw().hex()}
    token = session.liveliness().declare_token(f"{ROOT}/alive/controller/shaker.{request['key']}")
    robot = X25519PublicKey.from_public_bytes(
        bytes.fromhex(ask(session, "lease", request | {"op": "status"})["key"])
    )
    secret, counts = hashlib.sha256(private.exchange(robot)).digest(), itertools.count(1)

    def seal(key, payload):
        """Proof that this program sends the message, and sends it now."""
        count = next(counts).to_bytes(8, "big")
        return count + hmac.digest(secret, count + f"{ROOT}/{key}".encode() + payload, "sha256")

    lease = ask(session, "lease", request | {"op": "acquire"}, seal)
    if not lease["granted"]:
        raise SystemExit(lease["message"])
    first, heads = None, []
    while len(heads) < 200:
        frame = msgpack.unpackb(frames.get(timeout=30.0))
        first = first or frame
        heads.append(frame["position"][0])  # slot 0 is HeadYaw
        wanted = list(info["stand"])  # not the measured angles, which sag
        wanted[0] = 0.3 * math.sin(math.pi * (frame["time"] - first["time"]))
        answer = {"version": 3, "reply_to": frame["seq"], "lease": lease["lease"]}
        answer |= {"position": wanted, "stiffness": [1.0] * 25}
        payload = msgpack.packb(answer)
        session.put(f"{ROOT}/actuators", payload, attachment=seal("actuators", payload))
    ask(session, "lease", request | {"op": "release"}, seal)
    print(f"{info['body']}: the head turned from {min(heads):.2f} to {max(heads):.2f} rad")
