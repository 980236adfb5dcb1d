"""The robot's process: the DCM cycle in real time or in lockstep, and the queries of the link.

Both modes put the answer to frame k in force for the cycle from k to k+1 and then publish frame k+1. In real
time an answer that is not there when the wall clock reaches k+1 is missed, and the joints keep their last
target. The physics of the cycle runs at its beginning, right after frame k is out, if the drives delay requests
by a cycle or more: the controller has the whole cycle, and frame k+1 leaves on its boundary. With faster drives
(the profile `ideal`) the physics runs when the answer is there, and delays the frame. In lockstep the robot
waits.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

from bridge.guard import Guard
from bridge.host import RobotHost
from bridge.link import RobotLink
from bridge.messages import ActuatorFrame, Notice
from bridge.messages.dcm import COMMANDS
from bridge.messages.world import WORLD_COMMAND
from bridge.recording.observer import Observer
from emulator.queries import DcmQueries, WorldQueries
from emulator.robot import EmulatedRobot
from emulator.timing import BoundaryQueue, CycleTimer

RESEND_INTERVAL = 0.2
"""s; interval at which a robot in lockstep repeats an unanswered frame."""
LONG_PAUSE = 0.5
"""s; a pause of the process of this length is reported."""
POLL_INTERVAL = 0.005
"""s; interval at which a paused robot in lockstep polls for commands to the world."""


class RobotProcess:
    """Runs an emulated robot behind its link.

    Args:
        robot: the emulated robot.
        link: open link, robot side.
        guard: between every command and the robot.
        observers: called in each cycle.
        stop: set by a signal handler to end the run.
        dry_run: the guard's decisions are published, and none reaches the robot.
    """

    def __init__(
        self,
        robot: EmulatedRobot,
        link: RobotLink,
        guard: Guard,
        observers: Sequence[Observer],
        stop: threading.Event,
        *,
        dry_run: bool = False,
    ) -> None:
        self._robot, self._link = robot, link
        self._host = RobotHost(link, guard, observers, dry_run=dry_run, emulated=True)
        self._observers = observers
        self._stop = stop
        self._cycle_time = robot.body.cycle
        self._began: float | None = None
        self._commands, self._events = (BoundaryQueue(wake=link.wake) for _ in range(2))
        # commands of the DCM wait for the end of a cycle, those of the world for the beginning
        self._world = WorldQueries(robot, self._events, guard)
        link.serve(WORLD_COMMAND, self._world.answer)
        for suffix, answer in DcmQueries(robot, self._commands, self._require).handlers().items():
            link.serve(suffix, answer, sealed=suffix in COMMANDS)
        link.announce()

    @property
    def wall_seconds(self) -> float:
        """Wall-clock time since the first cycle began, s."""
        return time.monotonic() - self._began if self._began is not None else 0.0

    def _require(self, lease: int, what: str) -> None:
        self._link.require_lease(lease, what)
        self._host.guard.accept_timed(self._robot.seq)

    def real_time(self, timer: CycleTimer) -> None:
        """Cycle by the wall clock until stopped."""
        self._publish()
        while not self._stop.is_set():
            self._run_events()
            runs = not self._world.paused
            if runs:
                self._robot.run_ahead()
            before = timer.skipped
            timer.wait()
            if runs and timer.skipped - before >= LONG_PAUSE / self._cycle_time:
                self._notify_pause((timer.skipped - before) * self._cycle_time)
            self._commands.run()
            if runs and not self._robot.run_stalled():
                self._cycle(self._link.commands(), supervised=self._host.supervised)
        self._world.close()

    def _notify_pause(self, seconds: float) -> None:
        text = (
            f"The robot's process stood still for {seconds:.1f} s of wall clock (suspended, or starved by "
            "other work); the robot goes on where it was."
        )
        notice = Notice(seq=self._robot.seq, level="warning", code="paused", text=text)
        self._host.emit(notice)

    def lockstep(self) -> None:
        """Cycle by the controller's answers until stopped; an answer that is here by then is still served."""
        self._publish()
        while not self._stop.is_set():
            self._run_events()
            self._commands.run()
            if self._world.paused:
                self._stop.wait(POLL_INTERVAL)
            elif self._host.needs_cycle or (self._world.steps and self._link.holder is None):
                self._cycle(self._link.commands(), supervised=self._link.leases.abandoned)
            else:
                self._serve(self._link.wait_command(RESEND_INTERVAL))
        # So that a run that its controller ended has the same frames, however fast the stop follows.
        last = self._link.commands()
        if last:
            self._serve(last[-1])
        self._world.close()

    def _run_events(self) -> None:
        """Carry out the events of robot and world between two cycles."""
        self._events.run()
        if self._world.restarted:
            self._world.restarted = False
            self._host.guard.reset()
            self._publish()
        self._host.report()
        self._publish_notices()

    def _serve(self, command: ActuatorFrame | None) -> None:
        """One cycle, if this answers the present frame; without any answer the frame is sent again."""
        if command is None:
            self._host.rest_released(self._robot.frame.seq)
            self._link.publish(self._robot.frame)
        elif command.reply_to >= self._robot.frame.seq:  # older ones answer an earlier copy
            accepted = self._host.admit([command], self._robot.frame.seq)
            # a refused answer counts too: its sender waits for the next frame
            self._run(accepted, supervised=False, answered=True)

    def _cycle(self, commands: Sequence[ActuatorFrame], *, supervised: bool) -> None:
        """One cycle, with or without a command."""
        self._run(self._host.admit(commands, self._robot.frame.seq), supervised=supervised)

    def _run(self, command: ActuatorFrame | None, *, supervised: bool, answered: bool = False) -> None:
        if self._began is None:
            self._began = time.monotonic()
        expected = self._host.expected and not answered
        if (lights := self._link.leds()) is not None:
            self._robot.dcm.light(lights.leds)
        if self._robot.dcm.busy:
            self._host.guard.timed_waiting()
        given = self._host.decide(self._robot.frame, command, supervised=supervised)
        self._robot.advance(given, expected=expected)
        self._publish()
        self._world.cycle_done()

    def _publish(self) -> None:
        self._host.publish(self._robot.frame, self._robot.truth)
        self._publish_notices()

    def _publish_notices(self) -> None:
        """Pass on the robot's notices about its world."""
        for notice in self._robot.take_notices():
            self._host.emit(notice)
