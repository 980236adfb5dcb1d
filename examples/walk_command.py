"""Command a walk: some way ahead, then faster in another gait, then stop; and ask for what cannot be.

nao-hil up --serve                 # in one terminal
python examples/walk_command.py    # in another
"""

import sys
import time

from bridge.errors import WalkRefused
from bridge.link import DEFAULT_ENDPOINT
from nao_hil import WalkClient


def arrive(client: WalkClient, x: float) -> float:
    """Wait until the robot stands further ahead than `x`; where it is then by its odometry, m."""
    while (status := client.status()).state != "stand" or status.position[0] <= x:
        time.sleep(0.02)
    return status.position[0]


def main(endpoint: str) -> None:
    """Three commands, and where they led to."""
    with WalkClient(connect=endpoint) as client:
        x = arrive(client, -1.0)
        print(client.walk((0.015, 0.0, 0.0), distance=0.05).text)
        x = arrive(client, x)
        print(f"x = {x:.3f} m by its odometry")

        print(client.walk(gait="dynamic", hold=2.0).text)  # stops by itself, as nobody says `walk` again
        x = arrive(client, x)
        print(f"x = {x:.3f} m by its odometry")

        try:
            client.walk((0.0, 0.1, 0.0))
        except WalkRefused as refusal:
            print(f"refused: {refusal}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else DEFAULT_ENDPOINT)
