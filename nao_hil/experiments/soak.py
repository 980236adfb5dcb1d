"""A long walk in real time, watched: memory, file descriptors, punctuality and drift of both processes.

Robot and walker run as two processes over loopback, as `nao-hil up` does; this process listens to the frames
and looks into /proc every few seconds (Linux). A bare loop of the same cycle and priority runs beside them:
where it comes late too, it was the machine.
"""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import Final

from bridge.body import load_body
from bridge.errors import FrameError, LinkError
from bridge.link import keys
from bridge.link.session import open_client, subscribe
from bridge.messages import SensorFrame, decode
from nao_hil.analysis.report.page import Outcome
from nao_hil.experiments.context import Context
from nao_hil.experiments.soak_page import GAIT, draw, soak_page
from nao_hil.experiments.soak_result import sum_up
from nao_hil.runs.bare_loop import BareLoop
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.supervisor import Child

NAME: Final = "soak"
"""Robot id: beside a robot of the ordinary name this one is left alone."""
ENDPOINT: Final = "tcp/127.0.0.1:7449"
SCENARIO: Final = "plugged-in"
"""An hour is more than a battery."""
DURATION: Final = 300.0
"""s, unless told otherwise."""
SAMPLING: Final = 5.0
"""s between two looks at the processes."""
GRACE: Final = 10.0


def experiment(context: Context) -> Outcome:
    """Walk for the duration, once.

    Raises:
        LinkError: a process failed.
        Interrupted: stopped before the end.
    """
    duration = context.duration or DURATION
    config = context.changes
    robot_folder, walker_folder = context.out / "robot", context.out / "walker"
    for folder in (robot_folder, walker_folder):
        folder.mkdir(parents=True, exist_ok=True)
    robot = Child(
        "robot",
        [
            *("emulate", "--name", NAME, "--listen", ENDPOINT, "--robot", config.robot, "--wear", config.wear),
            *("--scenario", SCENARIO, "--seed", str(context.seeds[0])),
            *("--out", str(robot_folder), "--json"),
        ],
        robot_folder,
    )
    walker = Child(
        "walker",
        [
            *("walk", "--name", NAME, "--connect", ENDPOINT, "--gait", GAIT, "--steps", "0"),
            *("--duration", str(duration), "--json"),
        ],
        walker_folder,
    )
    try:
        with BareLoop() as bare:
            frames, samples = _watch(context, robot, walker)
    finally:
        walker.ask_to_end()
        walked = walker.end(GRACE)
        lived = robot.end(GRACE)
    if walked.result is None or lived.result is None:
        raise LinkError(f"a process failed: {walked.error if walked.result is None else lived.error}")
    cycle = load_body(config.robot).cycle
    done = walked.result["done"] is True
    result = sum_up(duration, cycle, frames, bare.lateness, samples, lived.result, done=done)
    picture = context.out / "soak.png"
    draw(frames, cycle, samples, picture)
    return Outcome(result, soak_page(context, duration, result, picture))


def _watch(
    context: Context, robot: Child, walker: Child
) -> tuple[list[tuple[int, int]], list[tuple[float, list[float], list[int]]]]:
    """(seq, wall clock in ns) of the frames, and (time, MB, descriptors) of both processes."""
    frames: list[tuple[int, int]] = []

    def on_sensors(payload: bytes) -> None:
        with contextlib.suppress(FrameError):
            frame = decode(payload, SensorFrame)
            frames.append((frame.seq, frame.wall))

    samples: list[tuple[float, list[float], list[int]]] = []
    with contextlib.closing(open_client(ENDPOINT, 60.0)) as session:
        subscriber = subscribe(session, keys.key(NAME, keys.SENSORS), on_sensors)
        began = time.monotonic()
        while walker.running and robot.running:
            if context.campaign.interrupted:
                raise Interrupted
            with contextlib.suppress(OSError):  # one ended just now
                both = (robot.pid, walker.pid)
                samples.append(
                    (
                        time.monotonic() - began,
                        [_memory(pid) for pid in both],
                        [_descriptors(pid) for pid in both],
                    )
                )
            time.sleep(SAMPLING)
        subscriber.undeclare()
    if not frames or not samples:
        raise LinkError("No frame was heard; see robot.log and walker.log in the run's folder.")
    return frames, samples


def _memory(pid: int) -> float:
    """Resident memory, MB."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def _descriptors(pid: int) -> int:
    return len(os.listdir(f"/proc/{pid}/fd"))
