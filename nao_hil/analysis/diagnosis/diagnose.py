"""Diagnosis: the chain of symptoms that ended in a fall."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import msgspec

from bridge.body import Body
from bridge.recording.playback import read_recording, recorded_body
from nao_hil.analysis.diagnosis.balance import BalanceEstimator, Moment, moments
from nao_hil.analysis.diagnosis.symptoms import OUTSIDE, Symptom, Symptoms, first_of

SYMPTOM_GAP: Final = 1.5
"""Time without a symptom that separates the symptoms of a fall from earlier ones, s."""
CAUSE_WINDOW: Final = 5.0
"""How long before the first symptom something done to the robot is named with it, s."""


class Diagnosis(msgspec.Struct, frozen=True, kw_only=True):
    """Why a robot fell."""

    fell: float
    """When, robot time, s."""
    chain: tuple[Symptom, ...]
    """Symptoms up to the fall, in order of time, the fall and disturbances included; overcome signs
    are not in it."""
    first: Symptom | None
    """The robot's own first one; None when it fell without a sign."""
    before: Symptom | None
    """Disturbances before, if any."""
    torso_off: bool = False
    """Its walk is known to have no torso control."""

    @property
    def sentence(self) -> str:
        """As text for the terminal."""
        text = f"The robot fell at {self.fell:.2f} s"
        if self.first is None:
            return f"{text}, without a sign before."
        text += f"; first, at {self.first.time:.2f} s, {self.first.text}"
        if self.before is not None:
            text += f" (before, at {self.before.time:.2f} s: {self.before.text})"
        later = {s.kind: s for s in reversed(self.chain) if s.kind not in OUTSIDE}
        rest = sorted((s for s in later.values() if s.kind != self.first.kind), key=lambda s: s.time)
        if rest:
            text += "; then " + ", ".join(f"{s.text} at {s.time:.2f} s" for s in rest)
        return f"{text}."


def explain(symptoms: Sequence[Symptom], *, torso_off: bool = False) -> Diagnosis | None:
    """The first fall among symptoms in any order, explained; None without a fall.

    Args:
        symptoms: of a run.
        torso_off: its walk did without torso control.
    """
    ordered = sorted(symptoms, key=lambda s: s.time)
    fall = next((s for s in ordered if s.kind == "fall"), None)
    if fall is None:
        return None
    own = [s for s in ordered if s.kind not in OUTSIDE and s.time <= fall.time]
    chain: list[Symptom] = []
    until = fall.time
    for symptom in reversed(own):
        if until - symptom.time > SYMPTOM_GAP:
            break
        chain.insert(0, symptom)
        until = symptom.time
    begin = chain[0].time if chain else fall.time
    done = [s for s in ordered if s.kind == "world" and begin - CAUSE_WINDOW <= s.time <= fall.time]
    before = [s for s in done if s.time <= begin and not s.text.endswith(" ends")]
    first = first_of(chain)
    return Diagnosis(
        fell=fall.time,
        chain=(*sorted([*done, *chain], key=lambda s: s.time), fall),
        first=first,
        before=before[-1] if before else None,
        torso_off=torso_off,
    )


def symptoms_of(run: Iterable[Moment], body: Body) -> list[Symptom]:
    """All symptoms of a run in order of their discovery, to the first fall."""
    observer = BalanceEstimator(body)
    watch = Symptoms(observer)
    found: list[Symptom] = []
    for moment in run:
        found += watch.update(observer.update(moment))
        if found and found[-1].kind == "fall":
            break
    return found


def diagnose(recording: str | Path) -> Diagnosis | None:
    """Why the robot of a recording fell; None when it did not.

    Raises:
        ConfigurationError: not a recording, or of an unknown body.
    """
    return explain(symptoms_of(moments(read_recording(recording)), recorded_body(recording, default="nao-v3")))
