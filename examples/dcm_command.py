"""Timed commands in the manner of NAOqi's DCM: turn the head by 0.4 rad within a second, and read it back.

nao-hil emulate                   # in one terminal
python examples/dcm_command.py    # in another
"""

import sys
import time

from bridge.body.joints import INDEX
from bridge.link import DEFAULT_ENDPOINT, ControllerLink
from bridge.messages import dcm as wire
from bridge.messages import decode, encode

HEAD = "HeadYaw/Position/Actuator/Value"
STIFF = "HeadYaw/Hardness/Actuator/Value"


def main(endpoint: str) -> None:
    """One command, three looks at what comes of it."""
    with ControllerLink(connect=endpoint, name="nodder") as link:
        link.wait_robot()
        link.acquire()

        def ask(key, message):
            return decode(link.query(key, encode(message)), wire.DcmReply).result

        now = ask(wire.GET_TIME, wire.DcmTime())  # ms
        ask(wire.SET, wire.DcmCommand(lease=link.lease, command=[STIFF, "ClearAll", [[1.0, now]]]))
        turn = [HEAD, "ClearAll", [[0.0, now + 100], [0.4, now + 1100]]]
        ask(wire.SET, wire.DcmCommand(lease=link.lease, command=turn))
        for wait in (500, 1000, 1500):
            while ask(wire.GET_TIME, wire.DcmTime()) < now + wait:
                time.sleep(0.02)
            print(f"{wait} ms: HeadYaw {link.latest(10.0).position[INDEX['HeadYaw']]:.2f} rad")
        link.release()


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else DEFAULT_ENDPOINT)
