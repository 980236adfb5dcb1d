"""Signals of a recording: ours (.mcap), or a CSV."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bridge.body import Body, load_body
from bridge.errors import ConfigurationError
from nao_hil.identification.csv_file import read_csv
from nao_hil.identification.signals import Array, Signals, on_grid
from nao_hil.recording import load
from nao_hil.runs.replay import recorded_body


@dataclass(frozen=True)
class RecordedSignals:
    """A recording to replay, and the robot that it is of."""

    body: Body
    signals: Signals
    config: dict[str, Any]
    """Configuration that the recording was made with; empty: it holds none."""
    whole: bool
    """It begins with the robot's first cycle."""


def read_signals(
    path: Path, robot: str | None, begin: float = 0.0, end: float | None = None
) -> RecordedSignals:
    """Read a recording.

    Args:
        path: .mcap or .csv.
        robot: Body; None: the one that the recording names.
        begin: First second of the recording to take.
        end: Last one; None: its end.

    Raises:
        ConfigurationError: unreadable, malformed, no body known, or no commands in it.
    """
    if path.suffix.lower() == ".csv":
        if robot is None:
            raise ConfigurationError(
                f"{path}: a CSV does not say which body was recorded; name it with --robot."
            )
        body = load_body(robot)
        time, columns = read_csv(path)
        signals, config, whole = on_grid(time, columns, body.cycle), {}, False
    else:
        body = recorded_body(path, robot)
        recording = load(path)
        for topic, what in (("sensors", "sensor frame"), ("actuators", "command")):
            if topic not in recording or recording[topic].rows < 2:
                raise ConfigurationError(f"{path}: holds no {what}; a recording of a robot under command does.")
        sensors = recording["sensors"]
        columns = {
            name: sensors[name] for name in ("position", "accelerometer", "gyroscope", "angle", "fsr")
        } | _commands(sensors, recording["actuators"])
        signals = on_grid(np.asarray(sensors["time"]), columns, body.cycle)
        config = recording.config if isinstance(recording.config, dict) else {}
        whole = int(sensors["seq"][0]) == 0
    first = round(begin / body.cycle)
    last = len(signals.time) if end is None else min(round(end / body.cycle) + 1, len(signals.time))
    if last - first < 2:
        raise ConfigurationError(
            f"{path}: has {signals.time[-1]:.2f} s; --from and --to leave nothing of them."
        )
    return RecordedSignals(body, signals.part(slice(first, last)), config, whole and first == 0)


def _commands(sensors: Any, actuators: Any) -> dict[str, Array]:
    """The command in force in the cycle after each sensor frame; NaN before the first one.

    A frame says with `command` which one was in force in the cycle that it ends.
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
