"""ALMotion's walking, carried out by a walker in a process of its own.

The robot has one holder at a time. `moveInit` and the moves give it to a walker that serves the walk command;
a call that needs the joints takes it back when the walker stands. In between the joints keep their last target.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Final, Protocol

from bridge.errors import NaoHilError, NaoqiRefused
from bridge.link.walk_client import WalkClient
from bridge.messages import Vec3
from bridge.naoqi.arguments import number
from bridge.naoqi.tasks import gone
from bridge.realtime import leave_real_time
from bridge.walk import GaitName, WalkStatus

POLL: Final = 0.1
"""s between two looks at what the walker does."""
PATIENCE: Final = 30.0
"""s a walker has to start, and to bring the robot to a stand."""
MOVING: Final = ("walk", "stopping")


class Walker(Protocol):
    """A walker's process."""

    @property
    def running(self) -> bool:
        """Whether it has not ended."""

    def end(self) -> str:
        """Ask it to end, and wait for that; the sentence it ended with, or nothing."""


class Robot(Protocol):
    """What walking needs of the served robot; its methods lock for themselves."""

    def give_away(self) -> None:
        """Stop all motions, command no more, and release the lease."""

    def take_back(self) -> None:
        """Ask for the lease and hold the joints where they are; raises `NaoHilError` when that fails."""


class Moving:
    """Walking methods of `ALMotion`; thread-safe.

    Args:
        robot: gives and takes the joints.
        start: starts a walker that serves.
        client: opens a client of its command.
        gait: to walk in.
        speed: of that gait, m/s: what `moveToward` calls 1, and how fast `moveTo` walks.
    """

    def __init__(
        self,
        robot: Robot,
        start: Callable[[], Walker],
        client: Callable[[], WalkClient],
        gait: GaitName,
        speed: float,
    ) -> None:
        self._robot, self._start, self._open = robot, start, client
        self._gait: GaitName = gait
        self._speed = speed
        self._walker: Walker | None = None
        self._client: WalkClient | None = None
        self._status: WalkStatus | None = None
        self._origin: Vec3 = (0.0, 0.0, 0.0)
        self._ends: list[Future[Any]] = []
        self._jobs: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="moving", daemon=True)
        self._thread.start()

    @property
    def has_robot(self) -> bool:
        """Whether a walker holds the robot, or is about to."""
        return self._walker is not None

    @property
    def active(self) -> bool:
        """Whether the robot walks."""
        return self._status is not None and self._status.state in MOVING

    def submit(self, work: Callable[[], Any]) -> Future[Any]:
        """Have something done between two looks at the walker, in order."""
        done: Future[Any] = Future()
        self._jobs.put((work, done))
        return done

    def with_joints(self, work: Callable[[], Any], *, stop: bool) -> Future[Any]:
        """Take the robot back from the walker, then do `work`.

        Args:
            work: commands the joints.
            stop: end a walk for it; otherwise it is refused while the robot walks.
        """

        def do() -> Any:
            """Take the joints and work, or refuse."""
            if self.active and not stop:
                raise NaoqiRefused(
                    "The robot walks, and the walker has its joints; call ALMotion.stopMove first."
                )
            self.back()
            return work()

        return self.submit(do)

    def move_init(self) -> Future[Any]:
        """Hand the robot to the walker, which takes the pose to walk from."""
        return self.submit(self._ensure)

    def move(self, x: Any, y: Any, theta: Any, *_: Any) -> Future[Any]:
        """Walk at a velocity, m/s and rad/s; returns when the walker has accepted it."""
        velocity = _velocity("ALMotion.move", x, y, theta)
        return self.submit(lambda: self._walk(velocity, None))

    def move_toward(self, x: Any, y: Any, theta: Any, *_: Any) -> Future[Any]:
        """Walk at a share of the gait's speed, -1 to 1."""
        method = "ALMotion.moveToward"
        share = number(x, f"{method}: x", -1.0, 1.0)
        _require_straight(
            method, number(y, f"{method}: y", -1.0, 1.0), number(theta, f"{method}: theta", -1.0, 1.0)
        )
        return self.submit(lambda: self._walk((share * self._speed, 0.0, 0.0), None))

    def move_to(self, x: Any, y: Any = 0.0, theta: Any = 0.0, *_: Any) -> Future[Any]:
        """Walk a way, m; waits for the end. Also as one list `[x, y, theta]`."""
        if isinstance(x, list):
            x, y, theta = (*x, 0.0, 0.0, 0.0)[:3]
        way, side, turn = _velocity("ALMotion.moveTo", x, y, theta)
        _require_straight("ALMotion.moveTo", side, turn)
        ended: Future[Any] = Future()

        def begin() -> None:
            """Walk; the call ends with the walk, or with its refusal."""
            if way == 0.0:
                ended.set_result(None)
                return
            try:
                self._walk((math.copysign(self._speed, way), 0.0, 0.0), abs(way))
            except NaoHilError as error:
                ended.set_exception(error)
            else:
                self._ends.append(ended)

        self.submit(begin)
        return ended

    def stop(self) -> Future[Any]:
        """Close the feet and stand; returns when the walker has accepted it."""

        def do() -> None:
            if self._client is not None:
                self._status = self._client.stop()

        return self.submit(do)

    def wait(self) -> Future[Any]:
        """Wait until the robot does not walk."""
        ended: Future[Any] = Future()
        self.submit(lambda: self._ends.append(ended) if self.active else ended.set_result(None))
        return ended

    def position(self, *_: Any) -> list[float]:
        """Where the robot is by the plan of its walks since the start: x, y, yaw; m and rad."""
        here = self._status.position if self._status else (0.0, 0.0, 0.0)
        x, y, yaw = self._origin
        return [
            x + math.cos(yaw) * here[0] - math.sin(yaw) * here[1],
            y + math.sin(yaw) * here[0] + math.cos(yaw) * here[1],
            yaw + here[2],
        ]

    def velocity(self) -> list[float]:
        """Of the steps that are planned now: m/s, m/s, rad/s."""
        return list(self._status.velocity) if self._status else [0.0, 0.0, 0.0]

    def close(self) -> None:
        """End the walker, if there is one; the robot stays where it is."""
        self._jobs.put(None)
        self._thread.join(PATIENCE)

    def _run(self) -> None:
        while True:
            try:
                job = self._jobs.get(timeout=POLL)
            except queue.Empty:
                self._look()
                continue
            if job is None:
                break
            work, done = job
            try:
                _pass_on(work(), done)
            except Exception as error:
                done.set_exception(error)
        self._end_walker()
        self._finish(gone())

    def _ensure(self) -> None:
        """A walker that stands and holds the robot."""
        if self._walker is not None and self._walker.running:
            return
        self._robot.give_away()
        leave_real_time()
        self._walker = self._start()
        try:
            self._client = self._open()
            self._await_stand()
        except NaoHilError as error:
            said = self._end_walker()
            self._robot.take_back()
            raise NaoqiRefused(f"The walker did not start: {said or error}") from None

    def _await_stand(self) -> None:
        deadline = time.monotonic() + PATIENCE
        while self._status is None or self._status.state != "stand":
            if self._walker is None or not self._walker.running or time.monotonic() > deadline:
                raise NaoqiRefused("it did not come to a stand.")
            time.sleep(0.02)
            try:
                self._status = self._client.status() if self._client else None
            except NaoHilError:
                continue  # it is not up yet
            if self._status is not None and self._status.state == "fallen":
                raise NaoqiRefused("the robot has fallen.")

    def _walk(self, velocity: Vec3, distance: float | None) -> None:
        if not any(velocity):
            if self._client is not None:
                self._status = self._client.stop()
            return
        self._ensure()
        assert self._client is not None
        status = self._client.walk(velocity, distance=distance, gait=self._gait)
        began = status.seq
        deadline = time.monotonic() + PATIENCE
        # The order is accepted before the first step begins; until then the walker still stands.
        while status.state not in (*MOVING, "fallen") and time.monotonic() < deadline:
            time.sleep(0.02)
            status = self._client.status()
            if status.seq > began + 200:
                break
        self._status = status

    def _look(self) -> None:
        """What the walker does now; whoever waits for the end of a walk hears of it."""
        if self._walker is None or self._client is None:
            return
        try:
            self._status = self._client.status()
        except NaoHilError as error:
            if not self._walker.running:
                said = self._end_walker()
                self._finish(NaoqiRefused(f"The walker ended: {said or error}"))
                self._robot.take_back()
            return
        if self._status.state == "fallen":
            self._finish(NaoqiRefused("The robot fell while it walked."))
        elif not self.active:
            self._finish(None)

    def _finish(self, error: Exception | None) -> None:
        ends, self._ends = self._ends, []
        for ended in ends:
            if error is None:
                ended.set_result(None)
            else:
                ended.set_exception(error)

    def back(self) -> None:
        """End a walk and the walker, and take the robot back; does nothing when there is no walker."""
        if self._walker is None:
            return
        if self.active and self._client is not None:
            self._status = self._client.stop()
            deadline = time.monotonic() + PATIENCE
            while self.active and time.monotonic() < deadline:
                time.sleep(0.02)
                self._status = self._client.status()
        self._finish(None)
        self._end_walker()
        self._robot.take_back()

    def _end_walker(self) -> str:
        x, y, yaw = self.position()
        self._origin, self._status = (x, y, yaw), None
        client, self._client = self._client, None
        walker, self._walker = self._walker, None
        if client is not None:
            client.close()
        return walker.end() if walker is not None else ""

    def methods(self) -> dict[str, Callable[..., Any]]:
        """Methods of `ALMotion` that walk, and that tell of the walk."""
        return {
            "moveInit": self.move_init,
            "walkInit": self.move_init,
            "move": self.move,
            "moveToward": self.move_toward,
            "setWalkTargetVelocity": lambda x, y, theta, *_: self.move_toward(x, y, theta),
            "moveTo": self.move_to,
            "walkTo": self.move_to,
            "stopMove": self.stop,
            "stopWalk": self.stop,
            "killMove": self.stop,
            "killWalk": self.stop,
            "moveIsActive": lambda: self.active,
            "walkIsActive": lambda: self.active,
            "waitUntilMoveIsFinished": self.wait,
            "waitUntilWalkIsFinished": self.wait,
            "getRobotPosition": self.position,
            "getNextRobotPosition": self.position,
            "getRobotVelocity": self.velocity,
        }


def _velocity(method: str, x: Any, y: Any, theta: Any) -> Vec3:
    return (
        number(x, f"{method}: x", -1e4, 1e4),
        number(y, f"{method}: y", -1e4, 1e4),
        number(theta, f"{method}: theta", -1e4, 1e4),
    )


def _require_straight(method: str, y: float, theta: float) -> None:
    if y or theta:
        raise NaoqiRefused(
            f"{method}: y is {y:g} and theta is {theta:g}, but the gaits walk straight only; both must be 0."
        )


def _pass_on(result: Any, done: Future[Any]) -> None:
    """Give a result on; one that is still to come when it comes."""
    if not isinstance(result, Future):
        done.set_result(result)
        return

    def copy(ended: Future[Any]) -> None:
        error = ended.exception()
        if error is None:
            done.set_result(ended.result())
        else:
            done.set_exception(error)

    result.add_done_callback(copy)
