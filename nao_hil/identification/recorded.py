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
from bridge.recording.playback import recorded_body
from bridge.types import Array
from nao_hil.identification.bhuman_log import read_bhuman
from nao_hil.identification.clock import on_one_clock
from nao_hil.identification.csv_file import MEASURED, read_csv
from nao_hil.identification.hulks_mcap import is_hulks, read_hulks
from nao_hil.identification.naoth_log import is_naoth, read_naoth
from nao_hil.identification.readings import Readings, Signals, on_grid, timing_notes
from nao_hil.recording import load

_VALUES: Final = 8
"""Different angles that a joint needs: eight random ones seem to be on a grid once in a thousand."""
_ON_GRID: Final = 0.95
"""Least length of the mean of unit vectors that make one turn a step: the angles then scatter by 0.05 steps at
most, as those rounded to four decimals do."""


class JointGrid(msgspec.Struct, frozen=True, kw_only=True):
    """Angles of one joint."""

    on_grid: bool
    shift: float
    """Of the grid from zero, by half a step at most, rad; meaningless off the grid."""


class EncoderGrid(msgspec.Struct, frozen=True, kw_only=True):
    """Angles of all joints that moved."""

    step: float
    """rad"""
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
    readings: Readings
    """The same measurements at their own times."""
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
    config: dict[str, Any] = {}
    whole = False
    if path.name.lower().endswith(_CSV):
        body, readings = _named_body(path, robot), read_csv(path, columns)
    elif columns is not None:
        raise ConfigurationError(f"--columns {columns}: maps the columns of a CSV; {path} is none.")
    elif path.suffix.lower() == ".log":
        body = _named_body(path, robot)
        readings = read_naoth(path) if is_naoth(path) else read_bhuman(path)
    elif is_hulks(path):
        body, readings = _named_body(path, robot), read_hulks(path)
    else:
        body = recorded_body(path, robot)
        readings, config, whole = _own(path)
    if readings.own_clock and readings.commands:
        readings = on_one_clock(readings, body, path)
    signals = on_grid(readings, body.cycle)
    first = round(begin / body.cycle)
    last = len(signals.time) if end is None else min(round(end / body.cycle) + 1, len(signals.time))
    if last - first < 2 or np.sum(signals.measured[first:last]) < 2:
        raise ConfigurationError(
            f"{path}: has {signals.time[-1]:.2f} s; --from and --to leave nothing of them."
        )
    half = 0.5 * body.cycle
    readings = readings.from_to(signals.time[first] - half, signals.time[last - 1] + half)
    signals = signals.part(slice(first, last))
    grid = encoder_grid(body, readings.measured)
    notes = (*readings.notes, *timing_notes(readings, body.cycle), *([grid.sentence] if grid.joints else []))
    return RecordedSignals(body, signals, readings, config, whole and first == 0, grid, notes)


def _named_body(path: Path, robot: str | None) -> Body:
    if robot is None:
        raise ConfigurationError(
            f"{path}: does not say which body was recorded; name it with --robot, as `--robot nao-v6`."
        )
    return load_body(robot)


def _own(path: Path) -> tuple[Readings, dict[str, Any], bool]:
    """Readings, configuration, and whether it begins with the robot's first cycle."""
    recording = load(path)
    if "sensors" not in recording or recording["sensors"].rows < 2:
        raise ConfigurationError(f"{path}: holds no sensor frame; a recording of a robot does.")
    sensors = recording["sensors"]
    time = np.asarray(sensors["time"])
    commands = _commands(sensors, recording["actuators"]) if "actuators" in recording else {}
    config = recording.config if isinstance(recording.config, dict) else {}
    measured = {name: sensors[name] for name in MEASURED}
    return Readings(time, measured, time, commands), config, int(sensors["seq"][0]) == 0


def _commands(sensors: Any, actuators: Any) -> dict[str, Array]:
    """The command in force in the cycle after each sensor frame; NaN before the first one.

    `command` of a frame names the one in force in the cycle that it ends.
    """
    replies = actuators["reply_to"].astype(int)
    order = np.argsort(replies, kind="stable")
    in_force = np.append(sensors["command"][1:], sensors["command"][-1]).astype(int)
    place = np.searchsorted(replies[order], in_force, side="right") - 1
    known = (place >= 0) & (in_force >= 0)
    rows = order[np.maximum(place, 0)]
    return {
        name: np.where(known[:, None], actuators[field][rows], np.nan)
        for name, field in (("command", "position"), ("stiffness", "stiffness"))
    }
