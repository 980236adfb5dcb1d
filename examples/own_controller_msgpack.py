"""A controller from docs/protocol.md alone, with a Zenoh and a msgpack library: the robot shakes its head.

nao-hil emulate                              # in one terminal
python examples/own_controller_msgpack.py    # in another; needs: pip install eclipse-zenoh msgpack
"""

import json
import math
import queue
import secrets
import sys

import msgpack
import zenoh

ENDPOINT = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
ROOT = "nao/nao"

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([ENDPOINT]))
config.insert_json5("scouting/multicast/enabled", "false")


def ask(session, key, message=None):
    """Answer to a query; an error reply is a sentence."""
    payload = b"" if message is None else msgpack.packb(message)
    for reply in session.get(f"{ROOT}/{key}", payload=payload, timeout=5.0):
        if reply.ok is None:
            raise SystemExit(reply.err.payload.to_bytes().decode())
        return msgpack.unpackb(reply.ok.payload.to_bytes())
    raise SystemExit(f"Nobody answers {key} at {ENDPOINT}.")


with zenoh.open(config) as session:
    frames = queue.SimpleQueue()
    session.declare_subscriber(f"{ROOT}/sensors", lambda sample: frames.put(sample.payload.to_bytes()))
    info = ask(session, "info")
    ticket = secrets.randbits(63)
    token = session.liveliness().declare_token(f"{ROOT}/alive/controller/shaker.{ticket:016x}")
    request = {"version": 2, "op": "acquire", "controller": "shaker", "ticket": ticket}
    lease = ask(session, "lease", request)
    if not lease["granted"]:
        raise SystemExit(lease["message"])
    first, heads = None, []
    while len(heads) < 200:
        frame = msgpack.unpackb(frames.get(timeout=5.0))
        first = first or frame
        heads.append(frame["position"][0])  # slot 0 is HeadYaw
        wanted = list(info["stand"])  # not the measured angles, which sag
        wanted[0] = 0.3 * math.sin(math.pi * (frame["time"] - first["time"]))
        answer = {"version": 2, "reply_to": frame["seq"], "lease": lease["lease"]}
        answer |= {"position": wanted, "stiffness": [1.0] * 25}
        session.put(f"{ROOT}/actuators", msgpack.packb(answer))
    ask(session, "lease", request | {"op": "release"})
    print(f"{info['body']}: the head turned from {min(heads):.2f} to {max(heads):.2f} rad")
