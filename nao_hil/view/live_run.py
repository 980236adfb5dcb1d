"""One robot's run as the live page shows it: rows, symptoms, footprints and the verdict on a fall."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Mapping
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import body_of
from bridge.link.robots import LinkRobot
from bridge.link.session import in_order
from bridge.messages import Info
from bridge.messages.world_state import WorldReply
from bridge.types import Array
from nao_hil.analysis.diagnosis import Balance, BalanceEstimator, Diagnosis, Symptom, Symptoms, explain
from nao_hil.runs.run import Cycle
from nao_hil.view.rows import RunRows, events_json
from nao_hil.view.signals import Lateness
from walker.estimation.odometry import GroundPlane

MAX_ROWS: Final = 10_000
"""Rows that are kept: five minutes."""
MAX_EVENTS: Final = 200
"""Symptoms and footprints that are kept."""


class LiveRun:
    """One robot from its start, or its last reset, up to now.

    Args:
        info: The robot.
        title: Its name on the page.
        world: Its surroundings; None: a real robot.
        others: The other robots of its world, by name.
    """

    def __init__(
        self,
        info: Info,
        title: str,
        world: WorldReply | None,
        others: Mapping[str, LinkRobot] | None = None,
    ) -> None:
        body = body_of(info.body, info.sheet)
        self.info, self._title, self.others = info, title, dict(others or {})
        self.rows = RunRows(body, world, {name: robot.body for name, robot in self.others.items()})
        self._observer = BalanceEstimator(body)
        self._watch, self._late = Symptoms(self._observer), Lateness()
        self.set_world(world)
        self._table: deque[Array] = deque(maxlen=MAX_ROWS)
        self._prints: deque[list[float]] = deque(maxlen=MAX_EVENTS)
        self._symptoms: list[Symptom] = []
        self.diagnosis: Diagnosis | None = None
        self.newest: Cycle | None = None
        self._lock = threading.Lock()
        self._latest_late = math.nan

    def set_world(self, world: WorldReply | None) -> None:
        """The surroundings are like this."""
        if world is not None:
            self._observer.ground = GroundPlane(*world.floor, 0.0)
            if world.terrain is None and self.rows.world is not None:
                world = msgspec.structs.replace(world, terrain=self.rows.world.terrain)
            self.rows.world = world

    def take(self, cycle: Cycle) -> list[bytes | dict[str, Any]]:
        """Process the next cycle; returns the messages for the browsers."""
        balance = self._observer.update(cycle)
        late = self._late.update(cycle.sensors.time, cycle.sensors.wall)
        self._latest_late = float(np.fmax(self._latest_late, late))
        messages: list[bytes | dict[str, Any]] = []
        found = self._watch.update(balance)
        with self._lock:
            self.newest = cycle
            if found:
                messages.append(self._add_symptoms(found))
            elif self._stands_again(balance):
                self.diagnosis = None
                messages.append(events_json(self._symptoms, None))
            if prints := self.rows.prints(balance):
                self._prints.extend(prints)
                messages.append({"prints": prints})
            if self.rows.due(cycle.sensors.time):
                truths = {name: robot.truth for name, robot in self.others.items()}
                row = self.rows.row(balance, self._latest_late, truths).astype("<f4")
                self._latest_late = math.nan
                self._table.append(row)
                messages.append(row.tobytes())
        return messages

    def _add_symptoms(self, found: list[Symptom]) -> dict[str, Any]:
        self._symptoms += found
        del self._symptoms[:-MAX_EVENTS]
        if any(s.kind == "fall" for s in found):
            last = self.diagnosis.fell if self.diagnosis else -1.0
            since = [s for s in self._symptoms if s.time > last]
            self.diagnosis = explain(since, torso_off=self._watch.torso_off) or self.diagnosis
        return events_json(self._symptoms, self.diagnosis)

    def _stands_again(self, balance: Balance) -> bool:
        walk = balance.cycle.walk
        if self.diagnosis is None or walk is None or balance.cycle.sensors.time < self.diagnosis.fell + 1.0:
            return False
        return walk.state in ("stand", "walk")

    def packed(self, name: str = "", **header: Any) -> bytes:
        """The run up to now; `name`: that of the robot on the link."""
        with self._lock:
            table = np.array(self._table) if self._table else np.zeros((0, self.rows.width))
            prints, symptoms, diagnosis = list(self._prints), list(self._symptoms), self.diagnosis
        subtitle = f"{self.info.body}, {self.info.side}, {self.info.mode}"
        events = events_json(symptoms, diagnosis)
        names = in_order([name, *self.others])
        return self.rows.pack(
            table, prints, title=self._title, subtitle=subtitle, name=name, names=names, live=header, **events
        )
