"""Push a standing robot harder and harder until it falls over, then set it up again.

nao-hil up --serve         # in one terminal
python examples/push.py    # in another
"""

import sys
import time

from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.messages.world import Push, Reset, Status
from nao_hil import WalkClient, WorldClient
from nao_hil.runs.monitor import Monitor

WATCH = 2.0  # s of robot time after each push


def main(endpoint: str) -> None:
    """Push to the left, by 0.5 N s more each time."""
    with WorldClient(connect=endpoint) as world, Monitor(DEFAULT_ROBOT, endpoint) as monitor:
        monitor.connect()
        with WalkClient(connect=endpoint) as walker:
            while walker.status().state != "stand":
                time.sleep(0.02)
        impulse, fell = 0.0, False
        while not fell:
            impulse += 0.5
            pushed = world.send(Push(impulse=(0.0, impulse, 0.0), duration=0.1))
            while world.send(Status()).time < pushed.time + WATCH:
                time.sleep(0.02)
                fell = fell or (monitor.truth is not None and monitor.truth.fell)
            print(f"{impulse:.1f} N s: {'falls' if fell else 'stands'}")
        print(world.send(Reset()).text)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else DEFAULT_ENDPOINT)
