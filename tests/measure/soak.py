"""A long walk in real time, watched: memory, file descriptors, punctuality and drift of both processes.

Robot and walker run as two processes over loopback, as `nao-hil up` does; this process listens to the frames
and looks into /proc every few seconds (Linux). A bare loop of the same cycle and priority runs at the
same time: its lateness is the machine's.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import minimum_filter1d

from bridge.body import load_body
from bridge.errors import FrameError, LinkError
from bridge.link import keys
from bridge.link.session import open_client, subscribe
from bridge.messages import SensorFrame, decode
from bridge.types import Array
from nao_hil.analysis.report.render import Claim
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Drawing, Experiment, Measured
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.supervisor import Child
from tests.bare_loop import BareLoop

SETTLED: Final = 60.0
"""s after which memory counts: libraries are loaded and buffers full."""
LARGEST_GROWTH: Final = 5.0
"""MB of resident memory of each process."""
LARGEST_DRIFT: Final = 0.002
"""s that the robot's cycle may leave the wall clock's grid, skipped cycles apart."""
LATER: Final = 0.002
"""s by which lateness at the end may exceed the one at the beginning more than the bare loop's does: a fifth
of a cycle, more than other work on the machine makes of it and less than a walk notices."""
WINDOW: Final = 5.0
"""s; lateness is the 99th percentile in a window, the median of those of the walk's first and last third: a
burst of other work on the machine is not the robot's lateness."""
GAIT: Final = "static"
NAME: Final = "soak"
"""Robot id: a robot of the ordinary name may run at the same time."""
ENDPOINT: Final = "tcp/127.0.0.1:7449"
SCENARIO: Final = "plugged-in"
"""An hour is more than a battery."""
DURATION: Final = 300.0
"""s, default."""
SAMPLING: Final = 5.0
"""s between two looks at the processes."""
GRACE: Final = 10.0


class Use(msgspec.Struct, frozen=True, kw_only=True):
    """Resources of one process."""

    memory_mb: float
    """Resident, in the end."""
    growth_mb: float
    """Of it since `SETTLED`."""
    descriptors: int
    """Open in the end."""
    descriptor_growth: int
    """Since `SETTLED`."""


def lateness(frames: Sequence[tuple[int, int]], cycle: float) -> tuple[Array, float]:
    """Lateness of each frame, and drift of robot time from the wall clock.

    Args:
        frames: cycle number and wall clock in ns, in order.
        cycle: s.

    Returns:
        s beyond the earliest of the frames of the following ten seconds, so that skipped cycles, which move all
        later ones, do not count, shape (n,); and the drift between the first and the last ten seconds, s, whole
        cycles taken out.
    """
    seq, wall = np.array(frames, dtype=np.int64).T
    over = (wall - wall[0]) * 1e-9 - (seq - seq[0]) * cycle
    n = round(10.0 / cycle)
    least = minimum_filter1d(over, n, mode="nearest", origin=-(n // 2))
    leap = over[-n:].min() - over[:n].min()
    return over - least, float(leap - cycle * round(leap / cycle))


def punctuality(late: Array, cycle: float) -> tuple[float, float]:
    """Typical 99th percentile of lateness in the first and in the last third, s.

    Args:
        late: lateness of each cycle, s, shape (n,).
        cycle: s.
    """
    n = max(1, min(round(WINDOW / cycle), len(late) // 3))
    windows = [np.percentile(late[i : i + n], 99) for i in range(0, len(late) - n + 1, n)]
    third = max(1, len(windows) // 3)
    return float(np.median(windows[:third])), float(np.median(windows[-third:]))


def sum_up(
    duration: float,
    cycle: float,
    frames: list[tuple[int, int]],
    bare_late: Array,
    samples: list[tuple[float, list[float], list[int]]],
    summary: dict[str, object],
    *,
    done: bool,
) -> dict[str, Any]:
    """The figures of a soak from its frames, its samples and the ends of both processes."""
    late, drift = lateness(frames, cycle)
    settled = next((s for s in samples if s[0] >= min(SETTLED, 0.2 * duration)), samples[-1])
    first, last = settled, samples[-1]
    uses = [
        Use(
            memory_mb=last[1][i],
            growth_mb=last[1][i] - first[1][i],
            descriptors=last[2][i],
            descriptor_growth=last[2][i] - first[2][i],
        )
        for i in range(2)
    ]
    timing = summary["timing"]
    assert isinstance(timing, dict)
    return {
        "done": done,  # walked for the whole time
        "seconds": (frames[-1][0] - frames[0][0]) * cycle,  # robot time, watched
        "fell": bool(summary["fell"]),
        "steps": int(str(summary["steps"])),
        "cycles": int(str(summary["cycles"])),
        "missed": int(str(summary["cycles_missed"])),
        "skipped": int(timing["skipped"]),  # cycles that the robot's process began too late
        "robot_use": uses[0],
        "walker_use": uses[1],
        "lateness": punctuality(late, cycle),  # s, first and last third, see `WINDOW`
        "lateness_bare": punctuality(bare_late, cycle),  # of the bare loop, beyond its deadlines
        "drift": drift,  # s between robot time and wall clock over the walk, skipped cycles apart
    }


def as_punctual(robot: tuple[float, float], bare: tuple[float, float]) -> bool:
    """Whether the robot's frames are no later in the end than at first, the machine's share taken out."""
    return robot[1] - robot[0] <= LATER + max(0.0, bare[1] - bare[0])


class Soak(NamedTuple):
    """A long walk."""

    found: dict[str, Any]
    """Of `sum_up`."""
    cycle: float
    """s"""
    duration: float
    """Wanted, s."""
    frames: list[tuple[int, int]]
    samples: list[tuple[float, list[float], list[int]]]


def draw(figure: Figure, measured: Measured[Soak]) -> None:
    """Memory of both processes above, lateness of the frames below, over time."""
    _, cycle, _, frames, samples = measured.results
    above, below = figure.subplots(2, 1)
    for i, who in enumerate(("robot", "walker")):
        above.plot([s[0] for s in samples], [s[1][i] for s in samples], label=who)
    above.set_ylabel("resident memory, MB")
    above.legend()
    late, _ = lateness(frames, cycle)
    below.plot([cycle * (seq - frames[0][0]) for seq, _ in frames], 1e3 * late, lw=0.3)
    below.set(xlabel="time, s", ylabel="lateness, ms")


def measure(context: Context) -> Soak:
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
    found = sum_up(duration, cycle, frames, bare.lateness, samples, lived.result, done=done)
    return Soak(found, cycle, duration, frames, samples)


def _claims(duration: float, found: dict[str, Any]) -> list[Claim]:
    claims = [
        Claim(
            f"It walks for {duration:g} s",
            f"{found['seconds']:.0f} s watched" + ("" if found["done"] else "; walker.log has the reason"),
            found["done"],
        ),
        Claim("No fall", "fell" if found["fell"] else f"{found['steps']} steps, upright", not found["fell"]),
    ]
    for who in ("robot", "walker"):
        use = found[f"{who}_use"]
        claims += [
            Claim(
                f"The {who}'s memory grows by less than {LARGEST_GROWTH:g} MB",
                f"{use.growth_mb:+.2f} MB to {use.memory_mb:.0f} MB",
                use.growth_mb < LARGEST_GROWTH,
            ),
            Claim(
                f"The {who} opens no more files",
                f"{use.descriptor_growth:+d} to {use.descriptors}",
                use.descriptor_growth <= 0,
            ),
        ]
    both = found["lateness"], found["lateness_bare"]
    late, bare = ([f"{1e3 * s:.2f} ms" for s in each] for each in both)
    drift = found["drift"]
    return [
        *claims,
        Claim(
            "Frames are as punctual in the end as in the beginning",
            f"99 % within {late[0]} at first, {late[1]} at last; of a bare loop {bare[0]} and {bare[1]}",
            as_punctual(*both),
        ),
        Claim("Robot time does not drift", f"{1e6 * drift:+.0f} us", abs(drift) <= LARGEST_DRIFT),
    ]


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
        subscriber = subscribe(session, keys.topic_key(NAME, SensorFrame), on_sensors)
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


def _setup(measured: Measured[Soak]) -> list[tuple[str, str]]:
    found = measured.figures
    return [
        ("walk", f"{found['seconds']:.0f} s of the {GAIT} gait in real time, two processes over loopback"),
        ("cycles", f"{found['cycles']}, {found['missed']} missed, {found['skipped']} skipped"),
    ]


SOAK: Final = Experiment(
    title="A long walk",
    source="No part of the thesis.",
    setup=_setup,
    measure=measure,
    quantities=lambda measured: measured.results.found,
    claims=lambda measured: _claims(measured.results.duration, measured.figures),
    pictures=(
        Drawing(
            "soak.png",
            draw,
            "Memory and lateness",
            "Lateness beyond the earliest frame of the next ten seconds.",
            (7.0, 5.0),
        ),
    ),
)
