"""Faults of the way from the controller to the DCM: commands lost, late, twice, out of order."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from bridge.messages import ActuatorFrame
from bridge.messages.faults import (
    CommandDuplicated,
    CommandFault,
    CommandJitter,
    CommandLate,
    CommandLost,
    CommandReordered,
)


class CommandChannel:
    """Carries commands, each to arrive some cycles after it was sent; the last to arrive is in force.

    Args:
        random: decides which commands suffer.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._cycle = 0
        self._sent = 0
        self._on_the_way: list[tuple[int, int, ActuatorFrame]] = []
        """Cycle of arrival, order among those of one cycle, command."""

    @property
    def empty(self) -> bool:
        """Nothing is on the way."""
        return not self._on_the_way

    def carry(self, command: ActuatorFrame | None, faults: Iterable[CommandFault]) -> ActuatorFrame | None:
        """One cycle.

        Args:
            command: Sent in this cycle.
            faults: In force.

        Returns:
            The last command to arrive in this cycle; None when none does.
        """
        self._cycle += 1
        if command is not None:
            for delay, behind in self._fates(faults):
                # one that was overtaken arrives after all that were sent up to the cycle of its arrival
                order = 2 * (self._sent + (delay + 1 if behind else 0)) + behind
                self._on_the_way.append((self._cycle + delay, order, command))
            self._sent += 1
        arrived = sorted((item for item in self._on_the_way if item[0] <= self._cycle), key=lambda i: i[:2])
        if not arrived:
            return None
        self._on_the_way = [item for item in self._on_the_way if item[0] > self._cycle]
        return arrived[-1][2]

    def _fates(self, faults: Iterable[CommandFault]) -> list[tuple[int, bool]]:
        """Delays, in cycles, with which copies of one command arrive, and whether behind the newer ones."""
        delay, copies = 0, []
        behind = False
        for fault in faults:
            if isinstance(fault, CommandJitter):
                delay += int(self._random.integers(0, fault.cycles + 1))
                continue
            struck = self._random.random() < fault.probability
            if not struck:
                continue
            if isinstance(fault, CommandLost):
                return []
            if isinstance(fault, CommandLate):
                delay += fault.cycles
            elif isinstance(fault, CommandDuplicated):
                copies.append((fault.cycles, True))
            elif isinstance(fault, CommandReordered):
                delay, behind = delay + 1, True
        return [(delay, behind), *((delay + extra, late) for extra, late in copies)]
