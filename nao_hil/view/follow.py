"""The page on a running robot: listens to it, sends rows to the browsers, and carries out their orders."""

from __future__ import annotations

import contextlib
import json
import os
import re
import threading
import time
from http import HTTPStatus
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.body import BODIES, body_of
from bridge.errors import FrameError, NaoHilError
from bridge.link import DEFAULT_ROBOT
from bridge.link.robots import LinkRobots
from bridge.link.session import in_order
from bridge.messages import Info, Notice, SensorFrame
from bridge.messages.frames import ELEMENTS
from bridge.messages.guard import GuardStatus
from bridge.messages.topics import Message
from bridge.messages.walk import WalkStatus
from bridge.messages.world import Status
from bridge.messages.world_state import WorldReply
from bridge.validation import unknown_name
from emulator.scenarios import SCENARIOS
from emulator.wear import WEAR
from nao_hil.runs.announcer import CAPTION, WALKER_ENDED
from nao_hil.runs.run import Cycle, CycleBuilder
from nao_hil.runs.supervisor import SUPERVISED
from nao_hil.view.access import Answer
from nao_hil.view.live import Commands, Subscriber, stop_all
from nao_hil.view.live_run import LiveRun
from nao_hil.view.orders import (
    Choose,
    Driving,
    Hand,
    Order,
    Orders,
    RobotOrder,
    SlowMotion,
    StopAll,
    answered,
)
from nao_hil.view.page import recorded_page
from nao_hil.view.rows import world_json
from nao_hil.view.server import HTML, PageServer
from nao_hil.view.state import describe
from walker.gaits.catalogue import GAITS, gait_parameters
from walker.gaits.learned import POLICIES, PREFIX

POLL_RATE: Final = 40.0
"""Polls for new messages per second."""
WATCH_INTERVAL: Final = 0.15
"""s between two questions for the walker's status and the world."""
NOTICE_CYCLES: Final = 500
"""Cycles of a new walker after which the end of the one before is no news."""
LOOK_INTERVAL: Final = 1.0
"""s between two looks for robots that came or went."""
LEARNED: Final = tuple(PREFIX + network.stem for network in sorted(POLICIES.glob("*.onnx")))
"""Learned gaits that are shipped with their networks."""
END_TIMEOUT: Final = 1.0
"""s that the last question may take when the page ends."""
FAULTS: Final[dict[str, tuple[str, str]]] = {
    "joint-weak": ("joint", "fraction"),
    "joint-stuck": ("joint", ""),
    "joint-limp": ("joint", ""),
    "joint-hot": ("joint", ""),
    "sensor-dead": ("sensor", ""),
    "sensor-stuck": ("sensor", ""),
    "sensor-noisy": ("sensor", "deviation"),
    "command-lost": ("", "probability"),
    "inertial-rezero": ("", ""),
    "hal-error": ("", ""),
    "power-loss": ("", ""),
}
"""Kinds of faults that the page offers: the part concerned, and the number for the severity."""


class Follower:
    """Shows one robot while it is chosen; a walk that the page ordered goes on behind another robot's page.

    Args:
        robot: Id of the robot.
        link: Of the robot, with the page's server.
    """

    def __init__(self, robot: str, link: LinkFollower) -> None:
        self._robot, self._link = robot, link
        self._server, self._endpoint = link.server, link.endpoint
        self._folder, self._stop = link.folder, link.stop
        self._subscriber: Subscriber | None = None
        self._builder = CycleBuilder()
        self._commands = Commands(robot, self._endpoint)
        self._driving = Driving(self._commands.walker, lambda: self._server.absence)
        self._run: LiveRun | None = None
        self._orders: Orders | None = None
        self._hand: Hand | None = None
        self._last_frame_at = time.monotonic()
        self._guard: GuardStatus | None = None
        self._walk: WalkStatus | None = None
        self._world: WorldReply | None = None
        self._terrain_pending = False
        """The terrain, which is sent with the run, arrived after its beginning."""
        self._walker_ended: Notice | None = None
        """Notice that `nao-hil up` lost its walker."""
        self._state = self._describe(0.0)
        """As the browsers have it: a run that begins before the first poll has ended shows it, too."""
        self._watcher: threading.Thread | None = None

    def poll(self) -> None:
        """Show the messages since the last call.

        Raises:
            ConfigurationError: not an endpoint.
        """
        if self._subscriber is None:
            self._subscriber = Subscriber(self._robot, self._endpoint)
            self._last_frame_at = time.monotonic()
        for message in self._subscriber.take():
            self._process(message)
            if isinstance(message, GuardStatus):  # the next one may follow before the next look
                self._publish_state(0.0)
        if self._terrain_pending and self._run is not None:
            self._terrain_pending = False
            self._server.feed(self._packed, self._link.carry_out, self._file)
        self._publish_state(time.monotonic() - self._last_frame_at)

    def hide(self) -> None:
        """Another robot is shown: listen no more."""
        if self._subscriber is not None:
            self._subscriber.close()
        self._subscriber, self._builder = None, CycleBuilder()
        self._run = self._guard = self._walk = self._world = self._walker_ended = None
        self._state = self._describe(0.0)

    @property
    def known(self) -> bool:
        """Whether the robot answered once."""
        return self._orders is not None

    @property
    def running(self) -> LiveRun | None:
        """The run that is shown; None: none yet."""
        return self._run

    def begin_again(self) -> None:
        """Begin the run again with the next frame: other robots are there."""
        self._run = None

    def execute(self, order: RobotOrder) -> str:
        """Carry out an order to this robot; as `Orders.execute`."""
        if self._orders is None:
            raise FrameError(f"Robot `{self._robot}` did not answer yet.")
        return self._orders.execute(order)

    def release(self) -> None:
        """Drop the target of its walk: it is stopped."""
        self._driving.release()

    def _process(self, message: Message) -> None:
        if isinstance(message, GuardStatus):
            self._guard = message
            return
        if isinstance(message, SensorFrame):
            self._last_frame_at = time.monotonic()
            if not self._known(message):
                return
        if isinstance(message, Notice) and message.code == CAPTION:
            self._server.publish({"caption": message.text})
        if isinstance(message, Notice) and message.code == WALKER_ENDED:
            self._walker_ended = message
        cycle = self._builder.add(message)
        if cycle is None or self._run is None:
            return
        # A cycle that is completed by an earlier frame is the last one of the run before.
        if isinstance(message, SensorFrame) and message.seq >= cycle.sensors.seq:
            for part in self._run.take(cycle):
                self._server.publish(part)

    def _publish_state(self, silent: float) -> None:
        """Send the state where it has changed; `silent` as in `_describe`."""
        state = self._describe(silent)
        if state != self._state:
            self._state = state
            self._server.publish({"state": state})

    def _describe(self, silent: float) -> dict[str, Any]:
        """The state now; `silent`: time since the last frame, s."""
        newest, world = self._run.newest if self._run else None, self._world
        if world is not None and self._link.time_scale < 1.0:  # which pauses the world between its steps
            world = msgspec.structs.replace(world, paused=False)
        state = describe(newest, self._guard, self._walk, world, silent)
        state["holds"] = self._hand is not None and self._hand.holds
        state["notice"] = self._notice(newest)
        state["time_scale"] = self._link.time_scale
        return state

    def _notice(self, newest: Cycle | None) -> str:
        """Notice of the walker's end, until another one has held the robot for `NOTICE_CYCLES`."""
        ended, walk = self._walker_ended, newest.walk if newest is not None else None
        if ended is not None and walk is not None and walk.seq > ended.seq + NOTICE_CYCLES:
            self._walker_ended = None
        return self._walker_ended.text if self._walker_ended is not None else ""

    def end(self) -> None:
        """Leave the robot free, and its network."""
        self.hide()
        if self._orders is not None:
            with contextlib.suppress(NaoHilError):
                self._orders.end()
        if self._watcher is not None:
            self._watcher.join(END_TIMEOUT)
        self._commands.close()

    def _known(self, frame: SensorFrame) -> bool:
        """Whether it is known which robot that is; asks at the first frame, and when the robot began again."""
        newest = self._run.newest if self._run is not None else None
        if self._run is not None and (newest is None or frame.seq >= newest.sensors.seq):
            return True
        info = self._commands.info()
        if info is not None:
            self._begin(info)
        return self._run is not None

    def _begin(self, info: Info) -> None:
        """A robot that is new, or began again."""
        emulated = info.side == "emulator"
        self._world = None
        if self._guard is None:  # it reports changes only
            with contextlib.suppress(NaoHilError):
                self._guard = self._commands.guard()
        if self._walker_ended is not None:
            self._walker_ended = msgspec.structs.replace(self._walker_ended, seq=0)  # frames count from 0 again
        if emulated:
            with contextlib.suppress(NaoHilError):
                self._world = self._commands.world(Status(terrain=True))
        others = {name: robot for name, robot in self._link.robots.update().items() if name != self._robot}
        self._run = LiveRun(info, f"robot {self._robot}", self._world, others)
        if self._orders is None or self._orders.body.name != info.body:
            body = body_of(info.body, info.sheet)
            self._hand = Hand(body, self._robot, self._endpoint, self._notify) if emulated else None
            supervised = SUPERVISED in os.environ and self._folder is not None
            config = (lambda: self._runs()[-1] / "config.toml") if supervised else None
            slow = self._link.slow_motion(self._commands, body.cycle)
            self._orders = Orders(self._commands, self._driving, self._hand, body, config, slow)
        self._server.feed(self._packed, self._link.carry_out, self._file)
        if self._watcher is None:
            self._watcher = threading.Thread(target=self._watch, name="watch", daemon=True)
            self._watcher.start()

    def _packed(self) -> bytes | None:
        run, orders = self._run, self._orders
        if run is None or orders is None:
            return None
        return run.packed(
            self._robot,
            emulated=run.info.side == "emulator",
            supervised=orders.supervised,
            saves=self._folder is not None,
            state=self._state,
            gaits={gait: gait_parameters(gait).limits is not None for gait in (*GAITS, *LEARNED)},
            robots=list(BODIES),
            wears=list(WEAR),
            scenarios=list(SCENARIOS),
            faults=FAULTS,
            sensors=[*ELEMENTS, *(f"fsr.{cell}" for cell in ELEMENTS["fsr"])],
            buttons=list(ELEMENTS["touch"]),
        )

    def _notify(self, sentence: str) -> None:
        self._server.publish({"answer": sentence, "done": True})

    def _watch(self) -> None:
        """Ask walker and world, apart from the drawing."""
        while not self._stop.wait(WATCH_INTERVAL):
            self._driving.keep_alive()
            if self._orders is not None:
                self._orders.keep_alive(self._server.absence)
            run = self._run
            if run is None:
                continue
            try:
                walks = run.newest is not None and run.newest.walk is not None
                self._walk = self._commands.walker().status() if walks else None
            except NaoHilError:
                self._walk = None
            if run.info.side == "emulator":
                self._ask_world(run)

    def _ask_world(self, run: LiveRun) -> None:
        with contextlib.suppress(NaoHilError):
            known = run.rows.world is not None
            before, world = self._world, self._commands.world(Status(terrain=not known))
            if self._run is not run:
                return  # another robot is shown, or this one began again
            self._world = world
            run.set_world(world)
            self._terrain_pending |= not known and world.terrain is not None
            if before is None or (before.objects, before.floor) != (world.objects, world.floor):
                self._server.publish({"world": world_json(run.rows.world)})

    def _runs(self) -> list[Path]:
        """Folders of the session's runs, in their order."""
        assert self._folder is not None
        restart = re.compile(rf"{re.escape(self._folder.name)}-(\d+)")
        found = (restart.fullmatch(path.name) for path in self._folder.parent.iterdir())
        later = sorted(int(each[1]) for each in found if each)
        return [self._folder, *(self._folder.with_name(f"{self._folder.name}-{number}") for number in later)]

    def _file(self, path: str) -> Answer | None:
        """Recordings of the session: their names as JSON, each as MCAP, and each as a page."""
        if self._folder is None:
            return None
        files = {
            f"{run.name}/{file.stem}": file for run in self._runs() for file in sorted(run.glob("frames*.mcap"))
        }
        if path == "/recordings":
            sizes = json.dumps({name: files[name].stat().st_size for name in in_order(files)}).encode()
            return Answer(HTTPStatus.OK, sizes, (("Content-Type", "application/json"),))
        name, _, kind = path.lstrip("/").rpartition(".")
        if name not in files or kind not in ("mcap", "html"):
            return None
        content = files[name].read_bytes() if kind == "mcap" else recorded_page([files[name]])[0].encode()
        content_type = HTML if kind == "html" else (("Content-Type", "application/octet-stream"),)
        disposition = f'attachment; filename="{name.replace("/", "-")}.{kind}"'
        return Answer(HTTPStatus.OK, content, (*content_type, ("Content-Disposition", disposition)))


class LinkFollower:
    """Shows the robots of a link, one of them chosen, and takes the page's orders to them.

    Args:
        server: Serves the page.
        robot: Id of the robot that is chosen first; where the default one is not there, the first of the link.
        connect: Zenoh endpoint of the link.
        stop: Ends it.
        folder: Of the run, where it is on this machine: its recordings can be saved.
    """

    def __init__(
        self, server: PageServer, robot: str, connect: str, stop: threading.Event, folder: Path | None = None
    ) -> None:
        self.server, self.endpoint, self.stop, self.folder = server, connect, stop, folder
        self.robots = LinkRobots(connect)
        self._chosen = robot
        self._lock = threading.Lock()
        self._followers: dict[str, Follower] = {}
        self._slow: SlowMotion | None = None

    def run(self) -> None:
        """Show until `stop` is set.

        Raises:
            ConfigurationError: not an endpoint.
        """
        due, shown = time.monotonic(), self.follower(self._chosen)
        threading.Thread(target=self._look, name="robots", daemon=True).start()
        try:
            while not self.stop.is_set():
                chosen = self.follower(self._chosen)
                if chosen is not shown:
                    shown.hide()
                    shown = chosen
                shown.poll()
                self._settle(shown)
                due = max(due + 1.0 / POLL_RATE, time.monotonic())
                self.stop.wait(due - time.monotonic())
        finally:
            for follower in self._followers.values():
                follower.end()
            self.robots.close()

    def follower(self, robot: str) -> Follower:
        """The follower of a robot, whether it is there or not."""
        with self._lock:
            if robot not in self._followers:
                self._followers[robot] = Follower(robot, self)
            return self._followers[robot]

    def slow_motion(self, commands: Commands, cycle: float) -> SlowMotion:
        """The one slow motion of the world, whichever robot it is ordered through."""
        if self._slow is None:
            self._slow = SlowMotion(commands.world, cycle)
        return self._slow

    @property
    def time_scale(self) -> float:
        """Robot time over time of the clock, by the slow motion."""
        return self._slow.speed if self._slow is not None else 1.0

    def _look(self) -> None:
        """Look for robots that came or went, apart from the drawing."""
        while not self.stop.wait(LOOK_INTERVAL):
            with contextlib.suppress(NaoHilError):
                self.robots.update()

    def _settle(self, shown: Follower) -> None:
        """Act on robots that came or went."""
        names = list(self.robots.found)
        if self._chosen == DEFAULT_ROBOT and names and self._chosen not in names:
            self._chosen = names[0]
        run = shown.running
        if run is not None and self._chosen in names and {self._chosen, *run.others} != set(names):
            shown.begin_again()

    def carry_out(self, text: str | bytes) -> tuple[str, bool]:
        """Carry out an order of the page; a sentence, and whether it is carried out."""
        return answered(text, self._execute)

    def _execute(self, order: Order) -> str:
        names, robot = list(self.robots.found), order.robot or self._chosen
        if isinstance(order, StopAll):
            known = {name: follower for name, follower in list(self._followers.items()) if follower.known}
            for follower in known.values():
                follower.release()  # also one that the stop does not reach: its walk ends by itself
            return stop_all({*names, *known}, self.endpoint)
        if isinstance(order, Choose):
            if robot not in names:
                raise FrameError(unknown_name("robot", robot, names))
            self._chosen = robot
            return f"The page shows {robot}."
        # also to one that seems to be gone: an emergency stop is sent whatever the list says
        sentence = self.follower(robot).execute(order)
        return f"{robot}: {sentence}" if len(names) > 1 and sentence else sentence
