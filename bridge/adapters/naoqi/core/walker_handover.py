"""Handover of the robot between the serving process and a walker process, in both directions.

A robot has one controller at a time. Walking methods hand it to a walker that serves the walk command; a call
that needs the joints takes it back once the robot stands. During a handover the joints keep their last target.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any, Final, Protocol

import msgspec

from bridge.adapters.naoqi.core.motion_tasks import pass_on, robot_lost
from bridge.errors import LeaseRefused, NaoHilError, NaoqiRefused, WalkRefused
from bridge.link.client import WalkClient
from bridge.messages.walk import WalkStatus
from bridge.planar import Pose2D
from bridge.realtime import leave_real_time
from bridge.types import Vec3

logger = logging.getLogger(__name__)

_POLL_INTERVAL: Final = 0.1
"""s between two queries of the walker's status."""
_FAST_POLL_INTERVAL: Final = 0.02
"""s, while a call waits for a change of the walker's state."""
_MAX_WAIT: Final = 30.0
"""s that a walker may take to start, and to stop the robot."""
_LEASE_TIMEOUT: Final = 15.0
"""s that a killed walker may hold the robot."""
_MAX_START_CYCLES: Final = 200
"""Cycles from an accepted walk to its first step."""
_WALKING: Final = ("walk", "stopping")


Order = dict[str, Any]
"""Velocity, and target (x, y, m, and yaw, rad, in the robot's frame) or distance (m), of `WalkClient.walk`."""


class StartedWalker(Protocol):
    """A walker's process."""

    @property
    def running(self) -> bool:
        """Whether the process runs."""

    def end(self) -> str:
        """End the process; its last sentence, or an empty text."""


class JointOwner(Protocol):
    """The served robot; its methods lock."""

    def give_away(self) -> None:
        """Stop the motions of the legs, end the commands, and release the lease."""

    def take_back(self) -> None:
        """Acquire the lease and hold the joints in place; raises `NaoHilError` on failure."""


class WalkerHandover:
    """Starts and ends the walker, and passes walks to it; thread-safe: its one thread does all in order."""

    def __init__(
        self,
        owner: JointOwner,
        start: Callable[[], StartedWalker],
        client: Callable[[], WalkClient],
        gait: str,
    ) -> None:
        self._owner, self._start, self._open = owner, start, client
        self._gait = gait
        self._walker: StartedWalker | None = None
        self._client: WalkClient | None = None
        self._status: WalkStatus | None = None
        self._origin = Pose2D()
        """Beginning of the present walker's plan."""
        self._holds = False
        """Whether the walker holds the robot, or is about to."""
        self._accepted = 0
        """Frame of an accepted walk that has not begun; 0: none."""
        self._stopping = False
        """Whether the walk is to end."""
        self._goal: Pose2D | None = None
        """Goal of the last order, as `position`; None: none."""
        self._ends: dict[Future[Any], bool | None] = {}
        """Calls that wait for the end of the walk, with the result of each if it is interrupted."""
        self._jobs: queue.Queue[tuple[Callable[[], Any], Future[Any]] | None] = queue.Queue()
        self._lock = threading.Lock()
        self._ordered: set[Future[Any]] = set()
        """Orders of walks not accepted yet."""
        self._waiting: list[Vec3] = []
        """The velocity of the last job, if it is a waiting velocity."""
        self._thread = threading.Thread(target=self._run, name="walker-handover", daemon=True)
        self._thread.start()

    @property
    def has_robot(self) -> bool:
        """Whether a walker holds the robot, or is about to."""
        return self._holds

    @property
    def active(self) -> bool:
        """Whether the robot walks."""
        return self._status is not None and self._status.state in _WALKING

    @property
    def active_or_ordered(self) -> bool:
        """Whether the robot walks, or has an order to."""
        return self.active or bool(self._ordered)

    def with_joints(self, work: Callable[[], Any], *, stop: bool) -> Future[Any]:
        """Take the robot back from the walker, then do `work`.

        Args:
            stop: end a walk for it; otherwise wait for a stopping walk, and refuse during another one.
        """

        def job() -> Any:
            """Take the joints back and work, or refuse."""
            if self.active and not (stop or self._stopping):
                raise NaoqiRefused(
                    "The robot walks, and the walker has its joints; call ALMotion.stopMove first."
                )
            self._take_back()
            return work()

        return self._submit(job)

    def prepare(self) -> Future[Any]:
        """Hand the robot to the walker, which takes its start pose."""
        return self._submit(self._prepare)

    def walk(self, velocity: Vec3) -> Future[Any]:
        """Walk without an end; all zeros: stand.

        The future is done when the walker has accepted it, and at once while the robot walks, so that a program
        can steer; of waiting velocities the newest counts.

        Args:
            velocity: x, y (m/s) and yaw (rad/s) in the robot's frame.
        """
        self._goal = None
        if not any(velocity):
            return self._submit(lambda: self._walk({"velocity": velocity}))
        if not self.active or self._stopping:
            return self._submit_order(lambda: self._walk({"velocity": velocity}))
        with self._lock:
            if self._waiting:
                self._waiting[0] = velocity
            else:
                self._waiting = [velocity]
                self._jobs.put((partial(self._steer, self._waiting), Future()))
        done: Future[Any] = Future()
        done.set_result(None)
        return done

    def _steer(self, waiting: list[Vec3]) -> None:
        """In the thread of walks: walk at the newest waiting velocity."""
        with self._lock:
            velocity = waiting[0]
            if self._waiting is waiting:
                self._waiting = []
        try:
            self._walk({"velocity": velocity})
        except NaoHilError as error:
            logger.warning("%s", error)

    def walk_to(self, ask: Callable[[], Order | None], *, wait: bool = True) -> Future[Any]:
        """Walk by an order, which is asked for at the beginning of this walk; None: no walk.

        The future is done at the end of the walk: true, or false after another order; without `wait` when the
        walker has accepted it.
        """
        ended: Future[Any] = Future()

        def job() -> None:
            """In the thread of walks."""
            order = ask()
            target = order.get("target") if order else None
            self._goal = self.position().pose(Pose2D(*target)) if target else None
            try:
                if order is not None:
                    self._walk(order)
            except NaoHilError as error:
                ended.set_exception(error)
            else:
                if order is None or not wait:
                    ended.set_result(True if wait else None)
                else:
                    self._ends[ended] = True

        self._submit_order(job)
        return ended

    def stop(self) -> Future[Any]:
        """Close the feet and stand; the future is done at the stand."""
        self._submit(self._stop_walk)
        return self.wait()

    def wait(self) -> Future[Any]:
        """Wait for the end of the walk."""
        ended: Future[Any] = Future()

        def job() -> None:
            if self.active:
                self._ends[ended] = None
            else:
                ended.set_result(None)

        self._submit(job)
        return ended

    def position(self) -> Pose2D:
        """Pose of the robot by the odometry of its walks since the start."""
        return self._origin.pose(Pose2D(*self._status.position)) if self._status else self._origin

    def remaining_way(self) -> Pose2D | None:
        """The way to the goal of the walk in the robot's frame, m and rad; None: it has none."""
        return None if self._goal is None else self.position().local_pose(self._goal)

    def velocity(self) -> list[float]:
        """Velocity of the planned steps: m/s, m/s, rad/s."""
        return list(self._status.velocity) if self._status else [0.0, 0.0, 0.0]

    def close(self) -> None:
        """End the walker, if there is one."""
        self._jobs.put(None)
        self._thread.join(_MAX_WAIT)

    def _submit(self, work: Callable[[], Any]) -> Future[Any]:
        done: Future[Any] = Future()
        with self._lock:
            self._waiting = []  # a later velocity counts after this
            self._jobs.put((work, done))
        return done

    def _submit_order(self, work: Callable[[], Any]) -> Future[Any]:
        done = self._submit(work)
        self._ordered.add(done)
        done.add_done_callback(self._ordered.discard)
        return done

    def _run(self) -> None:
        while True:
            try:
                job = self._jobs.get(timeout=_POLL_INTERVAL)
            except queue.Empty:
                self._poll()
                continue
            if job is None:
                break
            work, done = job
            try:
                pass_on(work(), done)
            except Exception as error:
                done.set_exception(error)
        self._end_walker()
        self._finish(robot_lost())

    def prestart(self) -> Future[Any]:
        """Start an idle walker, so that the first walk begins at once; done after the start or its failure."""

        def job() -> None:
            """Start it and wait for its first answer."""
            self._start_walker()
            self._await_walker()

        return self._submit(job)

    def _start_walker(self) -> None:
        """Start a walker's process, if there is none."""
        if self._walker is not None and self._walker.running:
            return
        self._end_walker()
        leave_real_time()
        self._walker, self._holds = self._start(), False
        self._client = self._open()

    def _ensure_walker(self) -> None:
        """Have a walker that holds the robot, or is about to."""
        if self._holds and self._walker is not None and self._walker.running:
            return
        try:
            self._start_walker()
            self._await_walker()
            self._owner.give_away()
            self._holds = True
            assert self._client is not None
            self._status = self._client.take()
        except NaoHilError as error:
            reason = self._end_walker()
            self._reclaim()
            raise NaoqiRefused(f"The walker did not start: {reason or error}") from None

    def _await_walker(self) -> None:
        """Wait until the walker's process answers."""
        assert self._client is not None and self._walker is not None
        deadline = time.monotonic() + _MAX_WAIT
        while True:
            try:
                self._client.status()
                return
            except WalkRefused:
                return
            except NaoHilError:
                if not self._walker.running or time.monotonic() > deadline:
                    raise
                time.sleep(_FAST_POLL_INTERVAL)  # it still starts

    def _prepare(self) -> None:
        """Have the walker hold the robot, and wait for the stand."""
        self._ensure_walker()
        deadline = time.monotonic() + _MAX_WAIT
        while self._status is None or self._status.state != "stand":
            assert self._client is not None and self._walker is not None
            if self._status is not None and self._status.state == "fallen":
                raise NaoqiRefused("The robot has fallen.")
            if not self._walker.running or time.monotonic() > deadline:
                raise NaoqiRefused("The walker did not bring the robot to a stand.")
            time.sleep(_FAST_POLL_INTERVAL)
            self._store_status(self._client.status())

    def _store_status(self, status: WalkStatus) -> None:
        """Store the walker's state; an accepted walk counts as one before it begins."""
        if self._accepted and status.state not in (*_WALKING, "fallen"):
            if status.seq <= self._accepted + _MAX_START_CYCLES:
                status = msgspec.structs.replace(status, state="walk")
        else:
            self._accepted = 0
        self._status = status

    def _walk(self, order: dict[str, Any]) -> None:
        if not any(order["velocity"]):
            self._stop_walk()
            return
        try:
            self._ensure_walker()
            self._interrupt()
            self._stopping = False
            assert self._client is not None
            status = self._client.walk(gait=self._gait, **order)
        except NaoHilError:
            self._goal = None
            raise
        self._accepted = status.seq
        self._store_status(status)

    def _stop_walk(self) -> None:
        if self._holds and self._client is not None:
            self._interrupt()
            self._stopping, self._accepted = True, 0
            self._status = self._client.stop()

    def _interrupt(self) -> None:
        """Note that the present walk does not reach its goal."""
        self._ends = {ended: interrupted and False for ended, interrupted in self._ends.items()}

    def _poll(self) -> None:
        """Query the walker's status; at the end of a walk waiting calls return."""
        if not self._holds or self._walker is None or self._client is None:
            return
        try:
            self._store_status(self._client.status())
        except NaoHilError as error:
            if not self._walker.running:
                reason = self._end_walker()
                self._finish(NaoqiRefused(f"The walker ended: {reason or error}"))
                self._reclaim()
            return
        assert self._status is not None
        if self._status.state == "fallen":
            self._finish(NaoqiRefused("The robot fell while it walked."))
        elif not self.active:
            self._finish(None)

    def _finish(self, error: Exception | None) -> None:
        ends, self._ends, self._goal = self._ends, {}, None
        for ended, interrupted in ends.items():
            if error is None:
                ended.set_result(interrupted)
            else:
                ended.set_exception(error)

    def _take_back(self) -> None:
        """End a walk and take the robot back, if the walker holds it; the walker stays idle."""
        if not self._holds:
            return
        if self.active and self._client is not None:
            self._stop_walk()
            deadline = time.monotonic() + _MAX_WAIT
            while self.active and time.monotonic() < deadline:
                time.sleep(_FAST_POLL_INTERVAL)
                self._store_status(self._client.status())
        self._finish(None)
        try:
            assert self._client is not None
            self._client.release()
            self._store_position()
        except NaoHilError:
            self._end_walker()
        self._reclaim()

    def _reclaim(self) -> None:
        """Take the joints back; a killed walker holds them for the time of its lease."""
        deadline = time.monotonic() + _LEASE_TIMEOUT
        while True:
            try:
                self._owner.take_back()
            except LeaseRefused:
                if time.monotonic() > deadline:
                    raise
                time.sleep(_POLL_INTERVAL)
            else:
                return

    def _store_position(self) -> None:
        """Store the robot's pose at the end of the walker's odometry."""
        self._origin, self._status = self.position(), None
        self._holds, self._accepted = False, 0

    def _end_walker(self) -> str:
        """End the walker; its last sentence, or an empty text."""
        self._store_position()
        client, self._client = self._client, None
        walker, self._walker = self._walker, None
        if client is not None:
            client.close()
        return walker.end() if walker is not None else ""
