"""Play key-frame motions one after the other through LoLA, as a team's program does: a socket and msgpack.

nao-hil emulate --robot nao-v6 --start lie-side                     # in one terminal
nao-hil serve lola                                                  # in another
python examples/lola_motion.py roll-from-side get-up-back sit-down  # in a third; needs: pip install msgpack

A motion is a name (`bridge/motion/`) or a file of your own, as docs/floor.md describes it. `--socket PATH` is
for a place other than /tmp/robocup.
"""

import argparse
import math
import socket
from collections.abc import Iterator

import msgpack

from bridge.body import load_body
from bridge.errors import ConfigurationError
from bridge.motion import load_motion
from bridge.motion.keyframes import Motion, targets

CYCLE = 0.012  # s; LoLA sends a packet in each
BYTES = 896  # of a packet
ANKLES = (11, 16)  # slots of LAnklePitch and RAnklePitch
REST = 0.5  # s at the last frame, so that the torso is still


def key_frames(motion: Motion, measured: list[float]) -> Iterator[tuple[list[float], float]]:
    """Angles and stiffness of each cycle: straight lines, the first from where the joints are."""
    before = measured
    for number, frame in enumerate(targets(motion, load_body("nao-v6"))):
        duration, position = frame.duration, list(before)
        for slot, angle in frame.position.items():  # joints that the motion leaves out stay
            position[slot] = angle
        if number == 0:  # no faster than the motion allows
            way = max(abs(b - a) for a, b in zip(before, position, strict=True))
            duration = max(duration, way / motion.approach_speed)
        cycles = max(1, round(duration / CYCLE))
        for cycle in range(1, cycles + 1):
            fraction = cycle / cycles
            yield [a + fraction * (b - a) for a, b in zip(before, position, strict=True)], frame.stiffness
        before = position
    yield from [(before, frame.stiffness)] * round(REST / CYCLE)


def exchange(lola: socket.socket, answer: dict) -> dict:
    """Answer a packet, if there is an answer; the next one."""
    if answer:
        lola.sendall(msgpack.packb(answer, use_single_float=True))
    return msgpack.unpackb(lola.recv(BYTES, socket.MSG_WAITALL))


def play(lola: socket.socket, motion: Motion, packet: dict) -> dict:
    """Answer a packet and those after it until the motion is over; the last one is still to be answered."""
    rate = 0.0
    for angles, stiffness in key_frames(motion, packet["Position"]):
        position = list(angles)
        rate += 0.3 * (packet["Gyroscope"][1] - rate)
        for slot in ANKLES:
            position[slot] += motion.ankle_gyroscope * rate
        packet = exchange(lola, {"Position": position, "Stiffness": [stiffness] * len(position)})
    return packet


def main() -> None:
    """Play the motions of the command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("motions", nargs="+")
    parser.add_argument("--socket", default="/tmp/robocup")
    arguments = parser.parse_args()
    try:
        motions = {name: load_motion(name) for name in arguments.motions}
    except ConfigurationError as error:
        parser.error(str(error))
    with socket.socket(socket.AF_UNIX) as lola:
        try:
            lola.connect(arguments.socket)
        except OSError as error:
            parser.error(f"no LoLA at {arguments.socket} ({error.strerror}); start `nao-hil serve lola` first.")
        packet = exchange(lola, {})
        for name in arguments.motions:
            packet = play(lola, motions[name], packet)
            roll, pitch = map(math.degrees, packet["Angles"])
            soles = sum(packet["FSR"])
            print(f"{name}: roll {roll:.0f}, pitch {pitch:.0f} degrees, {soles:.1f} kg on the soles")


if __name__ == "__main__":
    main()
