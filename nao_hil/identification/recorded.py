"""Signals of a recording: ours (.mcap), a CSV, or a log of another team's software."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import Body, load_body
from bridge.body.joints import JOINTS
from bridge.body.quantities import HANDS
from bridge.errors import ConfigurationError
from bridge.types import Array
from nao_hil.identification.bhuman_log import read_bhuman
from nao_hil.identification.clock import clock_offset
from nao_hil.identification.csv_file import MEASURED, read_csv
from nao_hil.identification.hulks_mcap import is_hulks, read_hulks
from nao_hil.identification.naoth_log import is_naoth, read_naoth
from nao_hil.identification.readings import LoggedRun, Signals, on_grid, timing_notes
from nao_hil.runs.run import Run, Table, load

_VALUES: Final = 8
"""Different angles that a joint needs: eight random ones seem to be on a grid once in a thousand."""
_ON_GRID: Final = 0.95
"""Least length of the mean of unit vectors that make one turn a step: the angles then scatter by 0.05 steps at
most, as those rounded to four decimals do."""


class JointGrid(msgspec.Struct, frozen=True, kw_only=True):
    """Angles of one joint."""

    on_grid: bool
    shift: float
    """Shift of the grid from zero, by half a step at most, rad; meaningless off the grid."""


class EncoderGrid(msgspec.Struct, frozen=True, kw_only=True):
    """Angles of all joints that moved."""

    step: float
    """Step of the encoder's grid, rad."""
    joints: dict[str, JointGrid]

    @property
    def sentence(self) -> str:
        """The result in words."""
        if not self.joints:
            return "No joint moves enough to tell whether its angles are the encoder's."
        on = {name: joint for name, joint in self.joints.items() if joint.on_grid}
        grid = f"the encoders' grid of {self.step:.3e} rad"
        if not on:
            return f"No joint's angles are on {grid}: they are filtered, interpolated or not measured."
        shifts = [abs(joint.shift) for joint in on.values()]
        off = [name for name in self.joints if name not in on]
        return (
            f"Angles of {len(on)} of {len(self.joints)} joints are on {grid}, shifted by "
            f"{np.median(shifts):.1e} rad in the median ({min(shifts):.1e} to {max(shifts):.1e})"
            f"{'; not those of ' + ', '.join(off) if off else ''}."
        )


def encoder_grid(body: Body, measured: Mapping[str, Array]) -> EncoderGrid:
    """Test each joint that has taken enough angles.

    Args:
        body: Gives the encoders' step.
        measured: Measured signals; `position` is read, (n, 25), as recorded, rad.
    """
    step = 2.0 * np.pi / body.encoder_steps
    position = measured.get("position", np.empty((0, len(JOINTS))))
    joints = {}
    for number, name in enumerate(JOINTS):
        values = np.unique(position[np.isfinite(position[:, number]), number])
        if name not in HANDS and len(np.unique(np.rint(values / (0.5 * step)))) >= _VALUES:
            mean = np.exp(2j * np.pi * values / step).mean()
            shift = float(np.angle(mean) / (2.0 * np.pi) * step)
            joints[name] = JointGrid(on_grid=bool(abs(mean) >= _ON_GRID), shift=shift)
    return EncoderGrid(step=step, joints=joints)


_CSV: Final = (".csv", ".csv.gz")


@dataclass(frozen=True)
class RecordedSignals:
    """A recording to replay, and the robot that it is of."""

    body: Body
    signals: Signals
    sensors: Table
    """The same measurements at their own times."""
    own_clock: bool
    """The commands have a clock of their own."""
    config: dict[str, Any]
    """Configuration of the recorded run; empty: it holds none."""
    whole: bool
    """It begins with the robot's first cycle."""
    encoder_grid: EncoderGrid
    notes: tuple[str, ...]
    """Sentences about its times, clocks, units and angles."""

    @property
    def commanded(self) -> bool:
        """It has a command at least."""
        return bool(np.isfinite(self.signals.command).any())

    @property
    def has_angles(self) -> bool:
        """It has measured joint angles."""
        return bool(np.isfinite(self.signals.position).any())


def read_signals(
    path: Path, robot: str | None, begin: float = 0.0, end: float | None = None, columns: Path | None = None
) -> RecordedSignals:
    """Read a recording.

    Args:
        path: .mcap of ours or of HULKs, .csv, .csv.gz, or .log of B-Human or NaoTH.
        robot: Body; None: the one that the recording names.
        begin: First second of the recording to take.
        end: Last one; None: its end.
        columns: Maps a CSV's columns, see `csv_file.read_csv`.

    Raises:
        ConfigurationError: unreadable, malformed, no body known, or no measurements in it.
    """
    if path.name.lower().endswith(_CSV):
        run, body = read_csv(path, columns), _named_body(path, robot)
    elif columns is not None:
        raise ConfigurationError(f"--columns {columns}: maps the columns of a CSV; {path} is none.")
    elif path.suffix.lower() == ".log":
        run = read_naoth(path) if is_naoth(path) else read_bhuman(path)
        body = _named_body(path, robot)
    elif is_hulks(path):
        run, body = read_hulks(path), _named_body(path, robot)
    else:
        recorded = load(path, robot)
        body, run = recorded.body, _in_force(path, recorded)
    notes, offset = run.notes, 0.0
    if run.own_clock and run["actuators"].rows:
        offset, said = clock_offset(run, body, path)
        notes += said
    signals = on_grid(run, body.cycle, offset)
    first = round(begin / body.cycle)
    last = len(signals.time) if end is None else min(round(end / body.cycle) + 1, len(signals.time))
    if last - first < 2 or np.sum(signals.measured[first:last]) < 2:
        raise ConfigurationError(
            f"{path}: has {signals.time[-1]:.2f} s; --from and --to leave nothing of them."
        )
    half, zero = 0.5 * body.cycle, run["sensors"]["time"][0]
    sensors = run.between(zero + signals.time[first] - half, zero + signals.time[last - 1] + half)["sensors"]
    signals = signals.part(slice(first, last))
    grid = encoder_grid(body, sensors)
    notes += (*timing_notes(sensors["time"], body.cycle), *([grid.sentence] if grid.joints else []))
    whole = first == 0 and "seq" in sensors and sensors["seq"][0] == 0
    return RecordedSignals(body, signals, sensors, run.own_clock, run.config, whole, grid, notes)


def _named_body(path: Path, robot: str | None) -> Body:
    if robot is None:
        raise ConfigurationError(
            f"{path}: does not say which body was recorded; name it with --robot, as `--robot nao-v6`."
        )
    return load_body(robot)


def _in_force(path: Path, run: Run) -> LoggedRun:
    """A run with the command in force in the cycle after each sensor frame; NaN before the first one.

    `command` of a frame names the one in force in the cycle that it ends.
    """
    sensors, actuators = run["sensors"], run["actuators"]
    if sensors.rows < 2:
        raise ConfigurationError(f"{path}: holds no sensor frame; a recording of a robot does.")
    in_force = np.append(sensors["command"][1:], sensors["command"][-1])
    rows = actuators.last("reply_to", in_force)
    known = ((rows >= 0) & (in_force >= 0))[:, None]
    fields = (("command", "position"), ("stiffness", "stiffness")) if actuators.rows else ()
    commands = {name: np.where(known, actuators[field][rows], np.nan) for name, field in fields}
    measured = {name: sensors[name] for name in (*MEASURED, "seq")}
    return LoggedRun(sensors["time"], measured, sensors["time"], commands, config=run.config)
