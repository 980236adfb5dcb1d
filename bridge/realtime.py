"""A process that keeps time: no timer slack, no collector's pauses, a real-time priority where permitted."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from typing import Final

ROBOT_PRIORITY: Final = 50
"""SCHED_FIFO priority of a robot's cycle: over every ordinary process, under the kernel's own threads."""
CONTROLLER_PRIORITY: Final = 40
"""Real-time priority of a controller: below the robot it serves."""

_PR_SET_TIMERSLACK: Final = 29
"""Number of the prctl request (Linux)."""


def quiet_process(priority: int | None) -> bool:
    """Prepare the calling process for short, punctual cycles; call it once everything is built.

    Sets the timer slack of the calling thread to 1 ns (Linux; the default of 50 us is added to every sleep),
    and hides all living objects from the garbage collector (a full collection of a large process
    takes tens of milliseconds).

    Args:
        priority: also ask for SCHED_FIFO with this one; None: stay an ordinary process.

    Returns:
        Whether the process now runs under SCHED_FIFO; without the permission it stays an ordinary one.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    gc.collect()
    gc.freeze()
    return priority is not None and request_real_time(priority)


def request_real_time(priority: int) -> bool:
    """Put all threads of this process, Zenoh's too, under SCHED_FIFO.

    Args:
        priority: 1 to 99.

    Returns:
        False where the system does not permit or know it.
    """
    if sys.platform != "linux":
        return False
    try:
        for thread in os.listdir("/proc/self/task"):
            os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return False
    return True


def leave_real_time() -> None:
    """Make the calling thread an ordinary one, and so the processes that it starts."""
    if sys.platform == "linux":
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
