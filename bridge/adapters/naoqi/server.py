"""A server of NAOqi, with cycle and lease: any robot on `nao/<robot>` appears as a NAOqi robot."""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from bridge.adapters.naoqi.core.cameras import CameraFeed, DrawnCameraFeed
from bridge.adapters.naoqi.core.robot_facts import RobotConfig
from bridge.adapters.naoqi.core.served import ServedRobot
from bridge.adapters.naoqi.core.walker_handover import StartedWalker, WalkerHandover
from bridge.adapters.naoqi.core.walking import WalkingMethods
from bridge.adapters.naoqi.qi_server import QiServer
from bridge.adapters.naoqi.services import Services
from bridge.body import Body, body_of
from bridge.errors import FrameError, LeaseRefused, LinkError, NaoqiRefused, RobotSilent
from bridge.link import ControllerLink
from bridge.link.client import WalkClient
from bridge.messages import Info, LedFrame, SensorFrame
from bridge.messages.frames import N_LEDS
from bridge.realtime import quiet_process
from bridge.recording.observer import NoticeHandler, log_notice
from bridge.types import Vec3

logger = logging.getLogger(__name__)

_FRAME_TIMEOUT: Final = 0.5
"""s without a sensor frame after which the server checks for the robot."""


class NaoqiServer:
    """Serves one robot.

    Args:
        full: speed of that gait, see `WalkingMethods`.
        stop: true when the server is to end.
        home: folder that stands for the robot's `/home/nao`; made at the first file.
        priority: SCHED_FIFO priority to ask for against a robot in real time; None: none.

    Raises:
        ConfigurationError: not an address.
        LinkError: it cannot be listened on.
    """

    def __init__(
        self,
        link: ControllerLink,
        url: str,
        gait: str,
        full: Vec3,
        start_walker: Callable[[], StartedWalker],
        stop: Callable[[], bool],
        home: Path,
        priority: int | None = None,
    ) -> None:
        self._priority = priority
        self._link, self._url, self._stop = link, url, stop
        self._gait, self._full, self._start_walker = gait, full, start_walker
        self._home = home
        self._lock = threading.RLock()
        self._commanding = False
        """Whether this side commands the joints, not the walker."""
        self._leds = (0,) * N_LEDS
        """Sent last."""
        self._services: Services | None = None
        self._call_server: QiServer | None = None

    @property
    def calls(self) -> int:
        """Answered so far."""
        return self._call_server.calls if self._call_server is not None else 0

    def run(self) -> None:
        """Serve until stopped, also over restarts of the robot.

        Raises:
            LeaseRefused: another controller holds the robot.
            LinkError: qi cannot listen.
        """
        logger.info("waiting for robot `%s` at %s", self._link.robot, self._link.endpoint)
        log, handler = logging.getLogger(__package__), NoticeHandler(self._link.publish)
        log.addHandler(handler)
        try:
            while not self._stop():
                info = self._link.wait_robot(self._stop)
                if info is not None and self._acquire():
                    self._serve_robot(info)
        finally:
            log.removeHandler(handler)
            self._commanding = False
            self._link.release()
            if self._call_server is not None:
                self._call_server.close()

    def _acquire(self) -> bool:
        try:
            self._link.acquire()
        except RobotSilent:
            return False
        return True

    def _serve_robot(self, info: Info) -> None:
        """Serve one boot of the robot."""
        receive = self._link.next if info.mode == "lockstep" else self._link.latest
        frame = self._first_frame(receive)
        if frame is None:
            return
        priority = self._priority if info.mode == "real-time" else None
        feed = self._camera_feed(info)
        services, handover = self._begin(body_of(info.body, info.sheet), frame, feed)
        if info.mode == "real-time":
            quiet_process(priority)
        self._send(services)
        prestarted, reported = handover.prestart(), False
        try:
            while not self._stop() and self._cycle(services, receive):
                if prestarted.done() and not reported:  # the first move of a program has a walker
                    reported = True
                    if self._call_server is None:
                        self._call_server = QiServer(self._url, services.names(), self._call)
                    logger.info("robot `%s` (%s) is served at %s", info.robot, info.body, self._url)
        finally:
            handover.close()
            if feed is not None:
                feed.close()
            with self._lock:
                services.abandon()

    def _camera_feed(self, info: Info) -> DrawnCameraFeed | None:
        """Cameras of an emulated robot."""
        if info.side != "emulator":
            return None
        feed = DrawnCameraFeed(info.robot, self._link.endpoint)
        feed.start()
        return feed

    def _cycle(self, services: Services, receive: Callable[[float], SensorFrame | None]) -> bool:
        """Answer a frame; False after a loss or a restart of the robot."""
        try:
            frame = receive(_FRAME_TIMEOUT)
        except FrameError as error:
            logger.warning("%s", error)
            return True
        if not self._link.robot_alive:
            logger.warning("the robot is gone; waiting for it to come back")
            return False
        self._read_notices()
        if frame is None:
            self._renew_lease()
        elif frame.seq > services.joints.frame.seq:
            with self._lock:
                services.cycle(frame)
                if not self._commanding:
                    services.hold()  # the walker moves them: they hold the last command
            self._send(services)
        elif frame.seq < services.joints.frame.seq:
            logger.warning("the robot restarted")
            return False
        else:
            self._send(services)  # a repeated frame: the answer was lost
        return True

    def _first_frame(self, receive: Callable[[float], SensorFrame | None]) -> SensorFrame | None:
        while not self._stop() and self._link.robot_alive:
            frame = receive(_FRAME_TIMEOUT)
            if frame is not None:
                return frame
        return None

    def _begin(
        self, body: Body, frame: SensorFrame, feed: CameraFeed | None
    ) -> tuple[Services, WalkerHandover]:
        """Services for a new boot of a robot; a running qi server keeps its methods."""
        link = self._link
        handover = WalkerHandover(
            self, self._start_walker, lambda: WalkClient(link.robot, link.endpoint), self._gait
        )
        robot = ServedRobot(
            RobotConfig(body, link.robot),
            frame,
            self._lock,
            WalkingMethods(handover, self._full),
            self._publish,
            self._home,
            feed,
            lambda event: self._call_server is not None and self._call_server.has_signal(event),
        )
        services = Services(robot, self._require_lease, self._answer_again)
        with contextlib.suppress(LinkError):  # the robot has gone: its next boot is served
            services.hold(link.held())
        with self._lock:
            self._services = services
            self._commanding = True
        return services, handover

    def _send(self, services: Services) -> None:
        with self._lock:
            leds = services.joints.dcm.leds or (0,) * N_LEDS
            if leds != self._leds:
                self._leds = leds
                self._link.publish(LedFrame(leds=leds))
            if self._commanding:
                self._link.send(services.joints.answer())
            elif services.handover.has_robot:
                walks = services.handover.active
                self._link.publish(services.upper_body.order(walks=walks))

    def _answer_again(self) -> None:
        """Answer the newest frame again after a call: the robot takes the newest answer."""
        if self._services is not None:
            self._send(self._services)

    def _renew_lease(self) -> None:
        """Renew the lease, so that a paused robot does not withdraw it.

        While another controller has it, each commanding call requests it again, and is refused.
        """
        with self._lock:
            if not self._commanding:
                return
            try:
                self._acquire()
            except LeaseRefused as error:
                logger.warning("%s", error)
                self._commanding = False
                if self._services is not None:
                    self._services.motion.end_all()

    def _read_notices(self) -> None:
        for notice in self._link.notices():
            log_notice(logger, notice)
            if notice.code == "no-lease":
                self._renew_lease()

    def give_away(self) -> None:
        """Stop the motions of the legs, end the commands, and release the lease to the walker."""
        with self._lock:
            if self._services is not None:
                self._services.give_away()
            self._commanding = False
        self._link.release()

    def take_back(self) -> None:
        """Acquire the lease and hold the joints in place.

        Raises:
            NaoHilError: another controller holds the robot, or it is lost.
        """
        self._link.acquire()
        targets = self._link.held()
        with self._lock:
            if self._services is not None:
                self._services.hold(targets)
                self._services.upper_body.taken.clear()
            self._commanding = True

    def _require_lease(self) -> None:
        if not self._commanding:
            self.take_back()

    def _call(self, service: str, method: str, arguments: list[Any]) -> Any:
        services = self._services
        if services is None or not self._link.robot_alive:
            raise NaoqiRefused(f"{service}.{method}: the robot is not there; waiting for it to come back.")
        return services.call(service, method, arguments)

    def _publish(self, event: str, value: Any, callbacks: list[list[Any]]) -> None:
        if self._call_server is not None:
            self._call_server.publish(event, value, callbacks)
