"""Result of the soak: memory, files, punctuality and drift of both processes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt
from scipy.ndimage import minimum_filter1d

SETTLED: Final = 60.0
"""s after which memory counts: libraries are loaded and buffers full."""


LARGEST_GROWTH: Final = 5.0
"""MB of resident memory of each process."""


LARGEST_DRIFT: Final = 0.002
"""s that the robot's cycle may leave the wall clock's grid, skipped cycles apart."""


LATER: Final = 0.002
"""s by which lateness at the end may exceed the one at the beginning more than the bare loop's does: a fifth
of a cycle, more than other work on the machine makes of it and less than what a walk feels."""


WINDOW: Final = 5.0
"""s; lateness is the 99th percentile in a window, the median of those of the walk's first and last third: a
burst of other work on the machine is not the robot's lateness."""


class Use(msgspec.Struct, frozen=True, kw_only=True):
    """What one process used."""

    memory_mb: float
    """Resident, in the end."""
    growth_mb: float
    """Of it since `SETTLED`."""
    descriptors: int
    """Open in the end."""
    descriptor_growth: int
    """Since `SETTLED`."""


class Soak(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil experiment soak`."""

    name: str = "soak"
    passed: bool
    done: bool
    """The walk went on for its whole time."""
    seconds: float
    """Of robot time, watched."""
    fell: bool
    steps: int
    cycles: int
    missed: int
    skipped: int
    """Cycles that the robot's process came too late for."""
    robot_use: Use
    walker_use: Use
    lateness: tuple[float, float]
    """s, of the frames in the first and in the last third, beyond the earliest of the next ten seconds; see
    `WINDOW`."""
    lateness_bare: tuple[float, float]
    """The same of the bare loop, beyond its deadlines."""
    drift: float
    """s between the robot's time and the wall clock's over the whole walk, skipped cycles apart."""


def lateness(frames: Sequence[tuple[int, int]], cycle: float) -> tuple[npt.NDArray[np.float64], float]:
    """How late each frame was sent, and how far robot time left the wall clock.

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


def punctuality(late: npt.NDArray[np.float64], cycle: float) -> tuple[float, float]:
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
    bare_late: npt.NDArray[np.float64],
    samples: list[tuple[float, list[float], list[int]]],
    summary: dict[str, object],
    *,
    done: bool,
) -> Soak:
    """The result of a soak from its frames, its samples and the ends of both processes."""
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
    robot_late, bare = punctuality(late, cycle), punctuality(bare_late, cycle)
    fell = bool(summary["fell"])
    seconds = (frames[-1][0] - frames[0][0]) * cycle
    good = (
        not fell
        and done
        and all(use.growth_mb < LARGEST_GROWTH and use.descriptor_growth <= 0 for use in uses)
        and as_punctual(robot_late, bare)
        and abs(drift) <= LARGEST_DRIFT
    )
    timing = summary["timing"]
    assert isinstance(timing, dict)
    return Soak(
        passed=good,
        done=done,
        seconds=seconds,
        fell=fell,
        steps=int(str(summary["steps"])),
        cycles=int(str(summary["cycles"])),
        missed=int(str(summary["cycles_missed"])),
        skipped=int(timing["skipped"]),
        robot_use=uses[0],
        walker_use=uses[1],
        lateness=robot_late,
        lateness_bare=bare,
        drift=drift,
    )


def as_punctual(robot: tuple[float, float], bare: tuple[float, float]) -> bool:
    """Whether the robot's frames came no later in the end than at first, the machine's share taken out."""
    return robot[1] - robot[0] <= LATER + max(0.0, bare[1] - bare[0])
