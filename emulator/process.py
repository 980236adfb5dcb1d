"""The robot's process: the DCM cycle in real time or in lockstep, over the link.

Both modes put the answer to frame k in force for the cycle from k to k+1 and then publish frame k+1. In real
time the cycle from k to k+1 is computed right after the wall clock has reached k+1: an answer that has not
come by then is missed, and the joints keep their last target. In lockstep the robot waits.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

from bridge.errors import FrameError
from bridge.guard import Guard
from bridge.link import RobotLink
from bridge.link.lease import Holder
from bridge.messages import ActuatorFrame
from bridge.observer import Observer
from bridge.world import COMMAND
from emulator.boundary import BoundaryQueue
from emulator.dcm_queries import DcmQueries
from emulator.robot import EmulatedRobot
from emulator.timing import CycleTimer
from emulator.world.queries import WorldQueries

RESEND = 0.2
"""s; how often a robot in lockstep repeats the frame it waits on."""
IDLE = 0.005
"""s; how often a robot in lockstep that was paused looks for commands to the world."""


class RobotProcess:
    """Runs an emulated robot behind its link.

    Args:
        robot: the emulated robot.
        link: open link, robot side.
        guard: checks every command.
        observers: told of each cycle.
        stop: set by a signal handler to end the run.
    """

    def __init__(
        self,
        robot: EmulatedRobot,
        link: RobotLink,
        guard: Guard,
        observers: Sequence[Observer],
        stop: threading.Event,
    ) -> None:
        self._robot, self._link, self._guard = robot, link, guard
        self._observers = observers
        self._stop = stop
        self._began: float | None = None
        self._asked: Holder | None = None
        self.boundary = BoundaryQueue(wake=link.wake)
        """Where handlers of queries leave what touches the robot."""
        self._world = WorldQueries(robot, self.boundary)
        link.serve(COMMAND, self._world.answer)
        for suffix, answer in DcmQueries(robot, self.boundary, link.require_lease).handlers().items():
            link.serve(suffix, answer)

    @property
    def wall_seconds(self) -> float:
        """Wall-clock time since the first cycle began, s."""
        return time.monotonic() - self._began if self._began is not None else 0.0

    def real_time(self, timer: CycleTimer) -> None:
        """Cycle by the wall clock until stopped."""
        self._publish()
        while not self._stop.is_set():
            timer.wait()
            self._at_boundary()
            if not self._world.stands_still and not self._robot.run_stalled():
                self._cycle(self._guarded(self._link.newest_command()))
        self._world.close()

    def lockstep(self) -> None:
        """Cycle by the controller's answers until stopped; an answer that is here by then is still served."""
        self._publish()
        while not self._stop.is_set():
            self._at_boundary()
            if self._world.stands_still:
                self._stop.wait(IDLE)
            elif self._world.steps and self._link.holder is None:
                self._cycle(None)
            else:
                self._serve(self._link.wait_command(RESEND))
        # So that a run that its controller ended has the same frames, however fast the stop follows.
        last = self._link.newest_command()
        if last is not None:
            self._serve(last)
        self._world.close()

    def _at_boundary(self) -> None:
        """Between two cycles: what queries want of the robot."""
        self.boundary.run()
        if self._world.began_anew:
            self._world.began_anew = False
            self._publish()
        self._tell()

    def _serve(self, command: ActuatorFrame | None) -> None:
        """One cycle, if this answers the present frame; the frame is sent again if nothing came at all."""
        if command is None:
            self._link.publish_sensors(self._robot.frame)
        elif command.reply_to >= self._robot.frame.seq:  # older ones answer a frame that was sent again
            accepted = self._guarded(command)
            if accepted is not None:
                self._cycle(accepted)

    def _guarded(self, command: ActuatorFrame | None) -> ActuatorFrame | None:
        if command is None:
            return None
        try:
            command = self._guard.check(command, self._robot.frame.seq)
        except FrameError as error:
            self._link.refuse("frame-refused", str(error))
            return None
        if self._guard.clipped:
            self._link.notice("clipped", self._guard.clipped)
        return command

    def _cycle(self, command: ActuatorFrame | None) -> None:
        if self._began is None:
            self._began = time.monotonic()
        for telemetry in self._link.telemetry():
            for observer in self._observers:
                observer.telemetry(telemetry)
        if command is not None:
            for observer in self._observers:
                observer.command(command)
        # A controller that took over since the frame went out could not answer it.
        self._robot.advance(command, expected=self._asked is not None and self._asked == self._link.holder)
        self._publish()
        self._world.cycle_done()

    def _publish(self) -> None:
        frame, truth = self._robot.frame, self._robot.truth()
        self._asked = self._link.holder
        self._link.publish_sensors(frame)
        self._link.publish_truth(truth)
        for observer in self._observers:
            observer.sensors(frame, truth)
        self._tell()

    def _tell(self) -> None:
        """Pass on what the robot says of its world."""
        for notice in self._robot.take_notices():
            self._link.publish_notice(notice)
            for observer in self._observers:
                observer.notice(notice)
