"""The process of a world and its robots: DCM cycles in real time or in lockstep, and the queries of the link.

Both modes put the answer to frame k in force for the cycle from k to k+1 and then publish frame k+1. In real
time an answer that is not there when the wall clock reaches k+1 is missed, and the joints keep their last
target. The physics of the cycle runs at its beginning, right after frame k is out, if all drives delay requests
by a cycle or more: the controller has the whole cycle, and frame k+1 leaves on its boundary. With faster drives
(the profile `ideal`) the physics runs when the answer is there, and delays the frame. In lockstep the world
waits for the answer of every robot that a controller holds.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from bridge.guard import Guard
from bridge.host import RobotHost
from bridge.link import RobotLink
from bridge.messages import ActuatorFrame, Notice
from bridge.messages.dcm import COMMANDS
from bridge.messages.world import WORLD_COMMAND
from bridge.recording.observer import DeferredObserver, Observer
from emulator.queries import DcmQueries, WorldClock, WorldQueries
from emulator.robot import EmulatedRobot
from emulator.timing import BoundaryQueue, CycleTimer
from emulator.world.world import World

RESEND_INTERVAL = 0.2
"""s; interval at which a robot in lockstep repeats an unanswered frame."""
LONG_PAUSE = 0.5
"""s; a pause of the process of this length is reported."""
POLL_INTERVAL = 0.005
"""s; interval at which a paused world in lockstep polls for commands."""


class RobotSide:
    """A robot behind its link.

    Args:
        robot: the emulated robot.
        link: open link, robot side.
        guard: between every command and the robot.
        observers: called for each cycle, beside the physics of the next one.
        dry_run: the guard's decisions are published, and none reaches the robot.
    """

    def __init__(
        self,
        robot: EmulatedRobot,
        link: RobotLink,
        guard: Guard,
        observers: Sequence[Observer],
        *,
        dry_run: bool = False,
    ) -> None:
        self.robot, self.link = robot, link
        self._observers = DeferredObserver(observers)
        self.host = RobotHost(link, guard, [self._observers], dry_run=dry_run, emulated=True)
        self.answered = False
        """The answer to the present frame is there, in lockstep."""
        self._answer: ActuatorFrame | None = None
        self._silent = False

    def serve(self, commands: BoundaryQueue, events: BoundaryQueue, clock: WorldClock) -> None:
        """Serve the queries and announce the robot.

        Args:
            commands: where those of the DCM wait for the end of a cycle.
            events: where those of the world wait for the beginning of a cycle.
            clock: of the world.
        """
        self.link.serve(WORLD_COMMAND, WorldQueries(self.robot, events, self.host.guard, clock).answer)
        for suffix, answer in DcmQueries(self.robot, commands, self._require).handlers().items():
            self.link.serve(suffix, answer, sealed=suffix in COMMANDS)
        self.link.announce()

    def _require(self, lease: int, what: str) -> None:
        self.link.require_lease(lease, what)
        self.host.guard.accept_timed(self.robot.seq)

    @property
    def awaited(self) -> bool:
        """In lockstep the world waits for an answer."""
        return self.link.holder is not None and not self.answered and not self.host.needs_cycle

    @property
    def ready(self) -> bool:
        """In lockstep the robot has a reason for a cycle."""
        return self.answered or self.host.needs_cycle

    def receive(self, command: ActuatorFrame) -> None:
        """Keep a command that answers the present frame."""
        frame = self.robot.frame
        if command.reply_to == frame.seq:  # older ones answer an earlier copy
            # a refused answer counts too: its sender waits for the next frame
            self._answer, self.answered = self.host.admit([command], frame.seq), True

    def send_again(self) -> None:
        """Send the present frame again, if it has no answer."""
        if not self.answered:
            self.host.rest_released(self.robot.frame.seq)
            self.link.publish(self.robot.frame)

    def begin_cycle(self, *, supervised: bool) -> None:
        """Latch the command of the cycle that begins now: the answer that is there, or the newest one.

        Args:
            supervised: whether the watchdog counts.
        """
        robot, host = self.robot, self.host
        self._silent = robot.stalls()
        if self._silent:
            robot.begin_cycle(None)
            return
        answered, self.answered = self.answered, False
        command = self._answer if answered else host.admit(self.link.commands(), robot.frame.seq)
        expected = host.expected and not answered
        if (lights := self.link.leds()) is not None:
            robot.dcm.light(lights.leds)
        if robot.dcm.busy:
            host.guard.timed_waiting()
        given = host.decide(robot.frame, command, supervised=supervised and not answered)
        robot.begin_cycle(given, expected=expected)

    def end_cycle(self) -> None:
        """Publish the new frame, unless the DCM stands still."""
        if not self._silent:
            self.publish()

    def restart(self) -> None:
        """The robot has begun again, with its world or alone."""
        self.answered = False
        self.host.guard.reset()
        self.publish()

    def publish(self) -> None:
        """Publish the present frame."""
        self.host.publish(self.robot.frame, self.robot.truth)
        self.publish_notices()

    def publish_notices(self) -> None:
        """Pass on the robot's notices about its world."""
        for notice in self.robot.take_notices():
            self.host.emit(notice)

    def observe(self) -> None:
        """Call the observers for all that has happened."""
        self._observers.deliver()

    def report(self) -> None:
        """Publish the guard's status and the notices between two cycles."""
        self.host.report()
        self.publish_notices()


class WorldProcess:
    """Runs the robots of a world behind their links.

    Args:
        sides: all robots of the world.
        stop: set by a signal handler to end the run.
    """

    def __init__(self, sides: Sequence[RobotSide], stop: threading.Event) -> None:
        self._sides, self._stop = sides, stop
        self._began: float | None = None
        self._repeated = 0.0
        """Monotonic time at which the frames of a pause were sent, s."""
        self._commands, self._events = (BoundaryQueue(wake=self._wake) for _ in range(2))
        self._clock = WorldClock()
        self._observer_thread = ThreadPoolExecutor(1)
        for side in sides:
            side.serve(self._commands, self._events, self._clock)

    def _wake(self) -> None:
        for side in self._sides:
            side.link.wake()

    @property
    def _world(self) -> World:
        """Another one after a reset."""
        return self._sides[0].robot.world

    @property
    def wall_seconds(self) -> float:
        """Wall-clock time since the first cycle began, s."""
        return time.monotonic() - self._began if self._began is not None else 0.0

    def real_time(self, timer: CycleTimer) -> None:
        """Cycle by the wall clock until stopped."""
        cycle_time = self._sides[0].robot.body.cycle
        for side in self._sides:
            side.publish()
        while not self._stop.is_set():
            self._run_events()
            runs = not self._clock.paused
            if runs:
                self._run_ahead()
            self._observe()
            before = timer.skipped
            timer.wait()
            if runs and timer.skipped - before >= LONG_PAUSE / cycle_time:
                self._notify_pause((timer.skipped - before) * cycle_time)
            self._commands.run()
            if runs:
                self._cycle(lambda side: side.host.supervised)
        self._end()

    def _run_ahead(self) -> None:
        """Run the physics ahead, and the observers in another thread: MuJoCo's steps leave Python's lock."""
        observed = self._observer_thread.submit(self._observe)
        self._world.run_ahead()
        observed.result()

    def _end(self) -> None:
        self._observer_thread.shutdown()
        self._observe()
        self._clock.end_steps("The robot's process ended.")

    def _observe(self) -> None:
        for side in self._sides:
            side.observe()

    def _notify_pause(self, seconds: float) -> None:
        text = (
            f"The robot's process stood still for {seconds:.1f} s of wall clock (suspended, or starved by "
            "other work); the robot goes on where it was."
        )
        for side in self._sides:
            side.host.emit(Notice(seq=side.robot.seq, level="warning", code="paused", text=text))

    def lockstep(self) -> None:
        """Cycle by the controllers' answers until stopped; answers that are here by then are still served."""
        sides = self._sides
        for side in sides:
            side.publish()
        while not self._stop.is_set():
            self._run_events()
            self._commands.run()
            self._observe()
            if self._clock.paused:
                self._pause_lockstep()
            elif not self._cycle_if_due():
                waits = next((side for side in sides if side.awaited), sides[0])
                command = waits.link.wait_command(RESEND_INTERVAL)
                if command is not None:
                    waits.receive(command)
                else:
                    for side in sides:
                        side.send_again()
        # So that a run that its controllers ended has the same frames, however fast the stop follows.
        for side in sides:
            for last in side.link.commands()[-1:]:
                side.receive(last)
        if any(side.answered for side in sides):
            self._cycle_if_due()
        self._end()

    def _pause_lockstep(self) -> None:
        """Wait a moment; controllers that take their robot meanwhile need a frame."""
        now = time.monotonic()
        if now > self._repeated + RESEND_INTERVAL:
            self._repeated = now
            for side in self._sides:
                side.send_again()
        self._stop.wait(POLL_INTERVAL)

    def _cycle_if_due(self) -> bool:
        """Run a cycle if there is a reason for it and no answer is awaited; whether it ran."""
        due = self._clock.steps or any(side.ready for side in self._sides)
        if not due or any(side.awaited for side in self._sides):
            return False
        self._cycle(lambda side: side.link.leases.abandoned)
        return True

    def _run_events(self) -> None:
        """Carry out the events of robots and world between two cycles."""
        self._events.run()
        restarted, self._clock.restarted = self._clock.restarted, []
        for side in self._sides:
            if side.robot.name in restarted:
                side.restart()
            side.report()

    def _cycle(self, supervised: Callable[[RobotSide], bool]) -> None:
        """One cycle of all robots.

        Args:
            supervised: whether a robot's watchdog counts.
        """
        if self._began is None:
            self._began = time.monotonic()
        for side in self._sides:
            side.begin_cycle(supervised=supervised(side))
        self._world.end_cycle()
        for side in self._sides:
            side.end_cycle()
        self._clock.cycle_done()
