"""A whole recording as the page shows it: the robot's pose at each moment, and its symptoms."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final, NamedTuple

from rich.console import Console
from rich.progress import track

from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.messages.world_state import WorldReply
from bridge.recording.playback import read_recording, recorded_body
from nao_hil.analysis.diagnosis import (
    Balance,
    BalanceEstimator,
    Diagnosis,
    Moment,
    Symptom,
    Symptoms,
    explain,
    moments,
)
from nao_hil.view.surroundings import recorded_world

MAX_CYCLES: Final = 20_000
"""Moments that are kept to be drawn; of a longer recording every second, third, ... one."""


class RecordedRun(NamedTuple):
    """The run before the robot restarted."""

    body: Body
    balances: list[Balance]
    symptoms: list[Symptom]
    """Up to the fall, if there is one."""
    diagnosis: Diagnosis | None
    """Of the fall."""
    stood: float
    """Robot time at which it stands or walks again after the fall, s; inf: never."""
    world: WorldReply | None
    """At the start; None where it is not recorded."""


def read_run(file: Path) -> RecordedRun:
    """Follow the robot of a recording once.

    Raises:
        ConfigurationError: not a recording, or an empty one.
    """
    body = recorded_body(file, default="nao-v3")
    run = first_run(list(moments(read_recording(file))))
    if not run:
        raise ConfigurationError(f"{file}: there is no sensor frame in it; record a robot that runs.")
    observer = BalanceEstimator(body)
    watch = Symptoms(observer)
    stride = 1 + len(run) // MAX_CYCLES
    balances: list[Balance] = []
    symptoms: list[Symptom] = []
    off = None
    console = Console(stderr=True)
    for i, moment in enumerate(track(run, "reading the recording", console=console, transient=True)):
        balance = observer.update(moment)
        symptoms += watch.update(balance)
        if i % stride == 0:
            balances.append(balance)
        if off is None and symptoms and symptoms[-1].kind == "fall":
            off = watch.torso_off
    diagnosis = explain(symptoms, torso_off=bool(off))
    if diagnosis is not None:  # motions of a fallen robot are no symptoms
        symptoms = [s for s in symptoms if s.time <= diagnosis.fell or s.kind in ("world", "order")]
    return RecordedRun(body, balances, symptoms, diagnosis, _stood(run, diagnosis), recorded_world(file))


def _stood(run: list[Moment], diagnosis: Diagnosis | None) -> float:
    fell = diagnosis.fell + 1.0 if diagnosis is not None else math.inf
    later = (m for m in run if m.sensors.time > fell and m.walk is not None)
    return next((m.sensors.time for m in later if m.walk and m.walk.state in ("stand", "walk")), math.inf)


def first_run(recorded: list[Moment]) -> list[Moment]:
    """The moments before the robot restarted: a timeline has one run."""
    for i in range(1, len(recorded)):
        if recorded[i].sensors.seq <= recorded[i - 1].sensors.seq:
            return recorded[:i]
    return recorded
