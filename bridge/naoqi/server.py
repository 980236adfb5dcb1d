"""A robot of the contract posing as a NAOqi robot: its cycle, its lease, and the front that speaks qi."""

from __future__ import annotations

import logging
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Final

from bridge.datasheet import Body, load_body
from bridge.errors import FrameError, LinkError, NaoHilError, NaoqiRefused, RobotSilent
from bridge.link import ControllerLink
from bridge.link.walk_client import WalkClient
from bridge.messages import Info, SensorFrame
from bridge.naoqi.address import require_free
from bridge.naoqi.config import RobotConfig
from bridge.naoqi.moving import Moving, Walker
from bridge.naoqi.pipe import Pipe, Unsendable
from bridge.naoqi.services import Services
from bridge.realtime import quiet_process
from bridge.walk import GaitName

logger = logging.getLogger(__name__)

SILENCE: Final = 0.5
"""s without a sensor frame after which the server looks whether the robot is still there."""
START: Final = 30.0
"""s the front has to listen."""


class Server:
    """Serves one robot.

    Args:
        link: open link, controller side.
        url: where the front listens.
        gait: for `moveTo` and its like.
        speed: of that gait on a body, m/s.
        start_walker: starts a walker that serves.
        stop: becomes true when the server is to end.
        priority: SCHED_FIFO priority to ask for against a robot in real time; None: none.

    Raises:
        ConfigurationError: not an address.
        LinkError: it cannot be listened on.
    """

    def __init__(
        self,
        link: ControllerLink,
        url: str,
        gait: GaitName,
        speed: Callable[[Body], float],
        start_walker: Callable[[], Walker],
        stop: Callable[[], bool],
        priority: int | None = None,
    ) -> None:
        require_free(url)
        self._priority = priority
        self._link, self._url, self._stop = link, url, stop
        self._gait, self._speed, self._start_walker = gait, speed, start_walker
        self._lock = threading.RLock()
        self._commanding = False
        """Whether actuator frames are sent: this side has the joints, not the walker."""
        self._services: Services | None = None
        self._moving: Moving | None = None
        self._pipe: Pipe | None = None
        self._front: subprocess.Popen[bytes] | None = None
        self.calls = 0
        """Answered so far."""

    def run(self) -> None:
        """Serve until stopped, also over restarts of the robot.

        Raises:
            LeaseRefused: another controller holds the robot.
            LinkError: the front could not listen.
        """
        logger.info("waiting for robot `%s` at %s", self._link.robot, self._link.endpoint)
        try:
            while not self._stop():
                info = self._link.wait_robot(self._stop)
                if info is not None and self._acquire():
                    self._serve_robot(info)
        finally:
            self._close()

    def _acquire(self) -> bool:
        try:
            self._link.acquire()
        except RobotSilent:
            return False
        return True

    def _serve_robot(self, info: Info) -> None:
        """Serve one start of the robot."""
        receive = self._link.next if info.mode == "lockstep" else self._link.latest
        frame = self._first_frame(receive)
        if frame is None:
            return
        priority = self._priority if info.mode == "real-time" else None
        services = self._begin(load_body(info.body), frame, priority)
        if info.mode == "real-time":
            quiet_process(priority)
        self._send(services)
        logger.info("robot `%s` (%s) is served at %s", info.robot, info.body, self._url)
        try:
            self._cycle(services, receive)
        finally:
            if self._moving is not None:
                self._moving.close()
            with self._lock:
                services.abandon()

    def _cycle(self, services: Services, receive: Callable[[float], SensorFrame | None]) -> None:
        """Answer frames until stopped, or until the robot goes away or begins anew."""
        while not self._stop() and self._front_runs():
            try:
                frame = receive(SILENCE)
            except FrameError as error:
                logger.warning("%s", error)
                continue
            if not self._link.robot_alive:
                logger.warning("the robot is gone; waiting for it to come back")
                return
            self._heed_notices()
            if frame is None:
                self._show_life()
            elif frame.seq > services.joints.frame.seq:
                with self._lock:
                    services.cycle(frame)
                self._send(services)
            elif frame.seq < services.joints.frame.seq:
                logger.warning("the robot began anew")
                return
            else:
                self._send(services)  # the robot asks again: the answer was lost

    def _first_frame(self, receive: Callable[[float], SensorFrame | None]) -> SensorFrame | None:
        while not self._stop() and self._link.robot_alive:
            frame = receive(SILENCE)
            if frame is not None:
                return frame
        return None

    def _begin(self, body: Body, frame: SensorFrame, priority: int | None) -> Services:
        """Services for a robot that is new here; the front, if it runs already, keeps its table."""
        link = self._link
        moving = Moving(
            self,
            self._start_walker,
            lambda: WalkClient(link.robot, link.endpoint),
            self._gait,
            self._speed(body),
        )
        config = RobotConfig(body, link.robot)
        services = Services(
            config, frame, self._lock, moving, self._require_lease, self._answer_anew, self._publish
        )
        with self._lock:
            self._services, self._moving = services, moving
            self._commanding = True
        if self._front is None:
            self._start_front(services, priority or 0)
        return services

    def _send(self, services: Services) -> None:
        with self._lock:
            if self._commanding:
                self._link.send(services.joints.answer())

    def _answer_anew(self) -> None:
        """A call came after the newest frame was answered: the robot takes the newest answer."""
        if self._services is not None:
            self._send(self._services)

    def _show_life(self) -> None:
        """A robot that pauses must not give the lease away."""
        with self._lock:
            if self._commanding:
                self._acquire()

    def _heed_notices(self) -> None:
        for notice in self._link.notices():
            logger.warning("the robot says: %s", notice.text)
            if notice.code == "no-lease":
                self._show_life()

    def give_away(self) -> None:
        """Stop all motions, command no more, and release the lease: the walker's turn."""
        with self._lock:
            if self._services is not None:
                self._services.motion.end_all()
            self._commanding = False
        self._link.release()

    def take_back(self) -> None:
        """Ask for the lease and hold the joints where they are.

        Raises:
            NaoHilError: another controller was faster, or the robot is gone.
        """
        self._link.acquire()
        with self._lock:
            if self._services is not None:
                self._services.joints.hold()
            self._commanding = True

    def _require_lease(self) -> None:
        if not self._commanding:
            self.take_back()

    def _start_front(self, services: Services, priority: int) -> None:
        ours, theirs = socket.socketpair()
        arguments = [self._url, str(theirs.fileno()), str(priority)]
        self._front = subprocess.Popen(
            [sys.executable, "-m", "bridge.naoqi.front", *arguments],
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
            start_new_session=True,
        )
        theirs.close()
        self._pipe = Pipe(ours)
        self._pipe.send([services.names()])
        ours.settimeout(START)
        first = self._pipe.receive()
        ours.settimeout(None)
        if first is None or not first[1]:
            raise LinkError(str(first[2]) if first else f"The qi process could not listen on {self._url}.")
        threading.Thread(target=self._answer_calls, args=(self._pipe,), name="calls", daemon=True).start()

    def _front_runs(self) -> bool:
        if self._front is None or self._front.poll() is None:
            return True
        raise LinkError(
            f"The qi process ended with exit code {self._front.returncode}; start the command again."
        )

    def _answer_calls(self, pipe: Pipe) -> None:
        while (message := pipe.receive()) is not None:
            number, service, method, arguments = message
            self.calls += 1
            try:
                result = self._call(service, method, arguments)
            except Exception as error:
                _fail(pipe, number, error)
                continue
            if isinstance(result, Future):
                result.add_done_callback(_Reply(pipe, number))
            else:
                _succeed(pipe, number, result)

    def _call(self, service: str, method: str, arguments: list[Any]) -> Any:
        services = self._services
        if services is None or not self._link.robot_alive:
            raise NaoqiRefused(f"{service}.{method}: the robot is not there; waiting for it to come back.")
        return services.call(service, method, arguments)

    def _publish(self, event: str, value: Any) -> None:
        if self._pipe is not None:
            self._pipe.send([0, event, value])

    def _close(self) -> None:
        self._commanding = False
        self._link.release()
        if self._pipe is not None:
            self._pipe.close()
        if self._front is not None:
            try:
                self._front.wait(3.0)
            except subprocess.TimeoutExpired:
                self._front.kill()
                self._front.wait()


class _Reply:
    """Answers a call when its future is done."""

    def __init__(self, pipe: Pipe, number: int) -> None:
        self._pipe, self._number = pipe, number

    def __call__(self, done: Future[Any]) -> None:
        error = done.exception()
        if error is None:
            _succeed(self._pipe, self._number, done.result())
        else:
            _fail(self._pipe, self._number, error)


def _succeed(pipe: Pipe, number: int, result: Any) -> None:
    try:
        pipe.send([number, True, result])
    except Unsendable as error:
        pipe.send([number, False, f"The result cannot be passed on ({error})."])


def _fail(pipe: Pipe, number: int, error: BaseException) -> None:
    """The sentence of an error that a user can cause; anything else is a fault, and the log shows it."""
    if isinstance(error, NaoHilError):
        pipe.send([number, False, str(error)])
    else:
        logger.error("a call failed", exc_info=error)
        pipe.send([number, False, f"This is a fault of nao-hil itself: {error!r}; please report it."])
