"""A robot of the link as a node of ROS 2: it publishes its sensors, and takes orders for its walker."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial
from typing import Any, Final

import zenoh

from bridge.adapters.naoqi.core.cameras import DrawnCameraFeed
from bridge.adapters.ros.messages import CAMERA_INFO, DESCRIPTION, IMAGE, TYPES, RosMessages
from bridge.adapters.ros.orders import Orders, RosCounts
from bridge.adapters.ros.wire import Listening, Publisher, RosNode
from bridge.body import Body, body_of
from bridge.errors import FrameError
from bridge.link import keys
from bridge.link.mailbox import Mailbox
from bridge.link.query import ask
from bridge.link.session import Search, subscribe, try_client
from bridge.messages import Info, Notice, SensorFrame, WalkTelemetry, decode, encode
from bridge.realtime import quiet_process

logger = logging.getLogger(__name__)

_RETRY_INTERVAL: Final = 0.05
"""s between two attempts to find the robot."""
_PRIORITY: Final = 30
"""SCHED_FIFO priority to ask for: below the robot and its controller."""
_FRAME_TIMEOUT: Final = 0.5
"""s between two checks of the stop event."""
_QUEUE_SIZE: Final = 64
RGB: Final = 11
"""NAOqi's number of the colour space of ROS's `rgb8`."""
CAMERAS: Final = {"camera/top": 0, "camera/bottom": 1}
_PICTURE_WIDTH: Final = 320


class RosBridge:
    """Bridges one robot until it is stopped.

    Args:
        robot: id of the robot.
        connect: Zenoh endpoint of the robot.
        node: of the ROS graph.
        description: URDF of a body.
        picture_rate: pictures a second of each camera with listeners.
        stop: set when it is to end.
    """

    def __init__(
        self,
        robot: str,
        connect: str,
        node: RosNode,
        description: Callable[[Body], str],
        picture_rate: float,
        stop: threading.Event,
    ) -> None:
        self._robot, self._endpoint, self._node = keys.check_name("Robot id", robot), connect, node
        self._describe, self._period, self._stop = description, 1.0 / picture_rate, stop
        self._received: Mailbox[tuple[bool, bytes]] = Mailbox(_QUEUE_SIZE)
        self._publishers: dict[str, Publisher] = {}
        self._reported: frozenset[Listening] = frozenset()
        self.counts = RosCounts()

    def run(self) -> RosCounts:
        """Bridge until stopped; waits for the robot.

        Raises:
            ConfigurationError: not an endpoint, or no such body.
        """
        search = Search(self._robot, self._endpoint)
        while not self._stop.is_set():
            session = try_client(self._endpoint, "controller")
            if session is None:
                search.failed(None)
                self._stop.wait(_RETRY_INTERVAL)
                continue
            try:
                info = self._ask_info(session, search)
                if info is not None:
                    self._serve(session, info)
            finally:
                session.close()
        return self.counts

    def _ask_info(self, session: zenoh.Session, search: Search) -> Info | None:
        while not self._stop.is_set():
            payload = ask(session, keys.key(self._robot, keys.INFO), b"", 1.0, FrameError)
            if payload is not None:
                return decode(payload, Info)
            search.failed(session)
            self._stop.wait(_RETRY_INTERVAL)
        return None

    def _serve(self, session: zenoh.Session, info: Info) -> None:
        body = body_of(info.body, info.sheet)
        messages = RosMessages(body, self._node.store)
        for topic, type_name in TYPES.items():
            if topic not in self._publishers:
                self._publishers[topic] = self._node.publisher(topic, type_name, latched=topic == DESCRIPTION)
        self._publish(*messages.description(self._describe(body)))
        subscribers = [
            subscribe(session, keys.topic_key(self._robot, kind), partial(self._put, kind is SensorFrame))
            for kind in (SensorFrame, WalkTelemetry)
        ]
        orders = Orders(self._robot, self._endpoint, session, self._node, self.counts)
        pictures = threading.Thread(target=self._send_pictures, args=(messages, info), name="pictures")
        pictures.start()
        logger.info("robot `%s` (%s) is on ROS 2", info.robot, info.body)
        if info.mode == "real-time":
            quiet_process(_PRIORITY)
        try:
            self._cycle(session, messages)
        finally:
            self._stop.set()
            pictures.join()
            orders.close()
            for subscriber in subscribers:
                subscriber.undeclare()

    def _put(self, sensors: bool, payload: bytes) -> None:
        self._received.put((sensors, payload))

    def _cycle(self, session: zenoh.Session, messages: RosMessages) -> None:
        seq = -1
        while not self._stop.is_set():
            first = self._received.take(_FRAME_TIMEOUT)
            for sensors, payload in ([first] if first is not None else []) + self._received.drain():
                try:
                    if not sensors:
                        messages.telemetry(decode(payload, WalkTelemetry))
                        continue
                    frame = decode(payload, SensorFrame)
                except FrameError:
                    continue  # from another program
                if frame.seq == seq:
                    continue  # repeated by a robot in lockstep
                seq = frame.seq
                self.counts.frames += 1
                for found in messages.of_frame(frame, frame.wall or time.time_ns()):
                    self._publish(*found)
            self._report_listeners(session, max(seq, 0))

    def _publish(self, topic: str, message: Any) -> None:
        self._publishers[topic].publish(message)
        self.counts.messages += 1

    def _report_listeners(self, session: zenoh.Session, seq: int) -> None:
        """Report the nodes that listen to the robot, in the log and by notices."""
        pictures = (f"{c}/{name}" for c in CAMERAS for name in ("image_raw", "camera_info"))
        ours = set(map(self._node.full, (*self._publishers, *pictures)))
        now = frozenset(one for one in self._node.listening if one.topic in ours)
        for one in now ^ self._reported:
            verb = "listens" if one in now else "no longer listens"
            text = f"ROS 2: {one.node} {verb} to /{one.topic}."
            logger.info("%s", text)
            notice = Notice(seq=seq, level="info", code="ros", text=text)
            session.put(keys.topic_key(self._robot, Notice), encode(notice))
        self._reported = now

    def _send_pictures(self, messages: RosMessages, info: Info) -> None:
        """Send pictures of the cameras with listeners."""
        if info.side != "emulator":
            return
        feed = DrawnCameraFeed(info.robot, self._endpoint)
        publishers = {
            name: (
                self._node.publisher(f"{name}/image_raw", IMAGE),
                self._node.publisher(f"{name}/camera_info", CAMERA_INFO),
            )
            for name in CAMERAS
        }
        due, asked = time.monotonic(), dict[str, Future[Any]]()
        while not self._stop.wait(max(0.0, due - time.monotonic())):
            due = max(due + self._period, time.monotonic())
            heard = {one.topic for one in self._node.listening}
            for name, camera in CAMERAS.items():
                picture = asked.get(name)
                if picture is not None and picture.done():
                    self._send_picture(name, picture, publishers[name], messages)
                if picture is None or picture.done():
                    asked.pop(name, None)
                    if {self._node.full(f"{name}/{part}") for part in ("image_raw", "camera_info")} & heard:
                        asked[name] = feed.picture(camera, _PICTURE_WIDTH, 3 * _PICTURE_WIDTH // 4, RGB)
        feed.close()

    def _send_picture(
        self, name: str, picture: Future[Any], publishers: Sequence[Publisher], messages: RosMessages
    ) -> None:
        if (error := picture.exception()) is not None:
            logger.warning("no picture of %s: %s", name, error)
            return
        moment, pixels = picture.result()
        image = messages.image(CAMERAS[name], _PICTURE_WIDTH, pixels, round(1e9 * moment))
        for publisher, message in zip(publishers, image, strict=True):
            publisher.publish(message)
        self.counts.pictures += 1
