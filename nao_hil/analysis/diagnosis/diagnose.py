"""Diagnosis: the chain of symptoms that ended in a fall."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import msgspec

from bridge.body import Body
from nao_hil.analysis.diagnosis.balance import BalanceEstimator
from nao_hil.analysis.diagnosis.symptoms import CAUSES, OUTSIDE, Symptom, Symptoms
from nao_hil.runs.run import Cycle, Run

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
    """Last thing done to the robot before that sign: a push, a fault, a limp joint, a pause; None: nothing."""
    torso_off: bool = False
    """Its walk is known to have no torso control."""

    @property
    def sentence(self) -> str:
        """As text for the terminal."""
        signs = {s.kind: s for s in reversed(self.chain) if s.kind not in OUTSIDE}
        signs = {kind: s for kind, s in signs.items() if s is not self.before}
        after = sorted(signs.values(), key=lambda s: s.time)
        if self.before is not None:
            after.insert(0, self.before)
        if not after:
            return f"The robot fell at {self.fell:.2f} s, without a sign before."
        first, *rest = after
        text = f"The robot fell at {self.fell:.2f} s; first, at {first.time:.2f} s, {first.text}"
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
    own = [s for s in ordered if s.kind not in (*OUTSIDE, *CAUSES) and s.time <= fall.time]
    chain: list[Symptom] = []
    until = fall.time
    for symptom in reversed(own):
        if until - symptom.time > SYMPTOM_GAP:
            break
        chain.insert(0, symptom)
        until = symptom.time
    # Steps have signs that the robot overcomes: it falls from its last tilt on, the earlier ones have ended.
    tilted = next((s.time for s in reversed(chain) if s.kind == "tilt"), 0.0)
    begin = max(chain[0].time, chain[0].counted, tilted) if chain else fall.time
    done = [s for s in ordered if s.kind in CAUSES and begin - CAUSE_WINDOW <= s.time <= fall.time]
    before = next((s for s in reversed(done) if s.time <= begin and not s.text.endswith(" ends")), None)
    if before is not None:  # signs that lasted only after it are its own; those before were overcome
        lasting = [s for s in chain if max(s.time, s.counted) >= before.time]
        chain = [s._replace(time=max(s.time, before.time)) for s in lasting]
    return Diagnosis(
        fell=fall.time,
        chain=(*sorted([*done, *chain], key=lambda s: s.time), fall),
        first=chain[0] if chain else None,
        before=before,
        torso_off=torso_off,
    )


def symptoms_of(cycles: Iterable[Cycle], body: Body) -> list[Symptom]:
    """All symptoms of a run in order of their discovery, to the first fall."""
    observer = BalanceEstimator(body)
    watch = Symptoms(observer)
    symptoms: list[Symptom] = []
    for cycle in cycles:
        symptoms += watch.update(observer.update(cycle))
        if symptoms and symptoms[-1].kind == "fall":
            break
    return symptoms


def diagnose(run: Run) -> Diagnosis | None:
    """Why the robot of a run fell; None when it did not.

    Raises:
        ConfigurationError: as `Run`.
    """
    return explain(symptoms_of(run.cycles(), run.body))
