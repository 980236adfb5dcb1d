"""The record of a walk, cycle by cycle: enough for every figure of the thesis and its evidence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge import rotations
from bridge.body.joints import JOINTS, LEG_SLOTS
from nao_hil.runs.run import Run

Array = NDArray[Any]

PHASES: Final = ("stand", "start", "DSL", "SSL", "DSR", "SSR", "stop")
"""Numbers of the phases in a track."""
LEG_COLUMNS: Final = tuple(sorted({slot for slots in LEG_SLOTS.values() for slot in slots}))
"""Frame slots of the eleven leg motors."""
LEG_NAMES: Final = tuple(JOINTS[slot] for slot in LEG_COLUMNS)

CHANNELS: Final[dict[str, int]] = {
    "time": 1,
    "phase": 1,
    "step": 1,
    "torso": 3,
    "orientation": 4,
    "angle": 2,
    "fsr": 8,
    "force": 2,
    "zmp": 2,
    "com": 3,
    "place": 3,
    "plan_zmp": 2,
    "plan_com": 2,
    "plan_left": 6,
    "plan_right": 6,
    "lift": 2,
    "ankle_roll": 2,
    "ankle_pitch": 2,
    "control": 2,
    "joints": len(LEG_COLUMNS),
    "request": len(LEG_COLUMNS),
}
"""Name -> width. `time` is that of the walk, s. World frame: torso's place and orientation (x, y, z, w),
vertical `force` on both feet, `zmp`, `com`. As the walker has it: `place` (x, y and yaw by the odometry),
`angle` (torso roll and pitch), the plan in the walk frame, `lift` of the feet, corrections of the ankles,
torso `control`. Leg motors: true and requested angles, rad."""
_STARTS: Final = dict(zip(CHANNELS, np.cumsum([0, *CHANNELS.values()]).tolist(), strict=False))
WIDTH: Final = sum(CHANNELS.values())


@dataclass(frozen=True)
class Track:
    """A walk as a table, one row per cycle."""

    rows: Array
    """Shape (cycles, WIDTH), NaN where there is nothing (the ZMP in flight)."""

    def __getitem__(self, channel: str) -> Array:
        """A channel, shape (cycles,) or (cycles, width)."""
        start, width = _STARTS[channel], CHANNELS[channel]
        values = self.rows[:, start : start + width].astype(np.float64)
        return values[:, 0] if width == 1 else values

    def __len__(self) -> int:
        return len(self.rows)

    def until(self, time: float) -> Track:
        """The rows before a time of the walk, s."""
        return Track(self.rows[self["time"] < time])

    def during(self, *phases: str) -> Array:
        """Mask of the cycles in some phases, shape (cycles,)."""
        return np.isin(self["phase"], [PHASES.index(phase) for phase in phases])

    @property
    def roll(self) -> Array:
        """True torso roll, rad, positive to the right, shape (cycles,)."""
        return rotations.roll(self["orientation"])

    @property
    def pitch(self) -> Array:
        """True torso pitch, rad, positive nose down, shape (cycles,)."""
        return rotations.pitch(self["orientation"])

    @property
    def tilt(self) -> Array:
        """Angle between the torso's z axis and the vertical, rad, shape (cycles,)."""
        return rotations.tilt(self["orientation"])


def track_of(run: Run, began: float) -> Track:
    """The walk of a run, one row per command.

    Args:
        run: With ground truth and telemetry.
        began: Robot time at which the walk began, s.
    """
    asked = run["actuators"].where(run["actuators"]["time"] >= began)
    s, t, w = (
        run[topic].where(run[topic].last("time", asked["time"]))
        for topic in ("sensors", "world/truth", "walk/telemetry")
    )
    columns: list[Any] = [
        asked["time"] - began,
        [PHASES.index(phase) for phase in w["phase"]],
        w["step"],
        t["torso_position"],
        t["torso_orientation"],
        w["angle"],
        s["fsr"],
        t["left.force"][:, 2],
        t["right.force"][:, 2],
        t["zmp"],
        t["com"],
        *(w[name] for name in ("place", "zmp", "com", "left", "right", "foot_lift")),
        *(w[name] for name in ("ankle_roll", "ankle_pitch", "torso_control")),
        t["joints"][:, LEG_COLUMNS],
        asked["position"][:, LEG_COLUMNS],
    ]
    return Track(np.column_stack(columns).astype(np.float32))
