"""The walker's process: everything around the controller that touches the link or the clock."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable

import msgspec

from bridge.body import Body, body_of, load_body
from bridge.errors import ConfigurationError, FrameError, LeaseRefused, LinkError, RobotSilent, WalkRefused
from bridge.guard import GuardSettings
from bridge.histogram import DurationHistogram, Percentiles
from bridge.link import ControllerLink, keys
from bridge.messages import ActuatorFrame, Info, Notice, SensorFrame, decode
from bridge.messages.frames import ORDER
from bridge.messages.guard import GuardStatus
from bridge.realtime import quiet_process
from bridge.types import Vec3
from walker.controller import Controller
from walker.gaits.catalogue import gait_kind
from walker.service import HANGS, WalkService

logger = logging.getLogger(__name__)

SILENCE_TIMEOUT = 0.5
"""s without a sensor frame after which the walker checks that the robot is there."""
_STANDBY_INTERVAL = 1.0
"""s between two checks by a standby walker that the robot is there and the same."""
_RETRY_INTERVAL = 0.2
"""s between two checks that a robot is armed, or free."""
GUARD_TAKEOVER_CYCLES = GuardSettings().watchdog.silence_cycles + GuardSettings().watchdog.hold_cycles
"""Cycles without an answer after which a guard controls the robot, whether or not its notice arrives."""
MakeController = Callable[[Body, float], Controller]
"""Body and cycle time (s) to a controller at the beginning of its order."""


class WalkResult(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a walk, as its walker knows it; the JSON of `nao-hil walk`."""

    body: str
    """Body of the robot that walked; empty: no robot."""
    state: str
    done: bool
    """The order is carried out to its end."""
    steps: int
    displacement: Vec3
    """By the odometry since the walker holds the robot: forward and to the left, m, and turn, rad."""
    fell: bool
    """By the fused torso angle."""
    fall_cause: str
    """Reason of the last fall; empty: none."""
    failure: str
    """Why the last walk ended before its order was carried out; empty: it did not."""
    late: bool
    """Stopped because answers are later than the gait permits, see `walker.monitor`."""
    interruptions: int
    """Number of walks resumed from a stand, or restarted, after too long without an answer at the robot."""
    ticks: int
    skipped: int
    """Sensor frames that arrived too fast to be answered, real time only."""
    tick_p50: float
    """Median duration of a tick, s."""
    tick_p99: float
    """Duration that 99 % of the ticks keep, s."""
    inference: Percentiles | None = None
    """Wall time of the calls of a learned gait's network; None: the gait has none."""


class WalkerProcess:
    """Runs a controller against whatever robot is at the other end of the link.

    Args:
        link: open link, controller side.
        make_controller: called for each start of the robot.
        body: name the robot must have; None takes the robot's word.
        stop: becomes true when the process is to end; a walk under way closes its feet first.
        priority: SCHED_FIFO priority to ask for against a robot in real time; None: none.
        service: source of orders while the controller runs; None: no orders.
    """

    def __init__(
        self,
        link: ControllerLink,
        make_controller: MakeController,
        body: str | None,
        stop: Callable[[], bool],
        priority: int | None = None,
        service: WalkService | None = None,
    ) -> None:
        self._priority = priority
        self._service = service
        self._link, self._make, self._body, self._stop = link, make_controller, body, stop
        self._controller: Controller | None = None
        self._ticks = DurationHistogram()
        self._skipped = self._interruptions = 0
        self._seq = -1
        self._late = self._dry_run = self._walked = self._closes = False
        self._boot: int | None = None
        self._found_boot: int | None = None
        """Boot of the robot that the log names."""
        self._body_name = ""
        """Name of the robot's body."""
        self._taken = False
        """The guard, or another controller, interrupted the walk."""
        self._last: ActuatorFrame | None = None
        self._warned_at = -math.inf
        self._lost_at: float | None = None
        """Time at which the robot disappeared; monotonic, s."""
        self._refusal = ""
        """Reason of the last refusal of the lease."""

    def run(self) -> WalkResult:
        """Walk until the order is done or the process is stopped. After an error, `result` has what was walked.

        Raises:
            ConfigurationError: the robot is another body, or cannot walk the gait.
            LeaseRefused: another controller holds the robot; a walker that serves waits until it is free.
            FrameError: the robot speaks another version of the contract.
            LinkError: the robot is stopped during the walk.
            WalkRefused: it hangs.
        """
        logger.info("waiting for robot `%s` at %s", self._link.robot, self._link.endpoint)
        while not self._stop():
            info = self._link.wait_robot(self._stop)
            if info is None:
                break
            if info.boot != self._boot:
                self._boot = info.boot
                self._controller = self._make(self._check_body(info), info.cycle)
                self._seq = -1
            if not self._taken and self._found_boot != info.boot:
                self._found_boot = info.boot
                logger.info("robot `%s` found: %s, %s", info.robot, info.body, info.mode)
            if info.mode == "real-time":
                quiet_process(
                    self._priority
                )  # it takes some cycles, which would be missed with the lease in hand
            if not self._wait_wanted() or not self._wait_armed():
                continue
            if self._taken:
                logger.warning("the robot had been taken from the walk, which restarts")
                self._taken = False
            if not self._acquire():
                continue
            if self._lost_at is not None:
                logger.warning("the robot is back after %.1f s", time.monotonic() - self._lost_at)
                self._lost_at = None
            if self._serve(lockstep=info.mode == "lockstep"):
                self._link.release()
                break
        return self.result()

    def _wait_wanted(self) -> bool:
        """Whether to hold the robot; a standby walker waits for that."""
        return self._service is None or self._service.wait_wanted(_STANDBY_INTERVAL)

    def _wait_armed(self) -> bool:
        """Wait until the robot takes commands; False when the process is stopped meanwhile.

        Raises:
            LinkError: it is stopped during the walk. Arming it again does not resume that walk.
        """
        warned = False
        while not self._stop():
            try:
                status = decode(self._link.query(keys.GUARD), GuardStatus)
            except LinkError:
                return True  # no guard that could be asked
            self._dry_run = status.dry_run
            if status.dry_run:
                logger.warning(
                    "the robot's side only watches (--dry-run); what is asked of the joints is not done"
                )
            if status.armed:
                return True
            if self._walked and self._service is None:
                raise LinkError(f"{status.text} The walk has ended; arm the robot and walk again.")
            if not warned:
                logger.warning("%s Waiting for that.", status.text)
            warned = True
            time.sleep(_RETRY_INTERVAL)
        return False

    def _acquire(self) -> bool:
        """Request the lease; False when the robot disappears meanwhile.

        A walker that serves also returns False, after a moment, while another controller holds the robot.
        """
        try:
            self._link.acquire()
        except RobotSilent:
            return False
        except LeaseRefused as error:
            if self._service is None:
                raise
            if str(error) != self._refusal:
                logger.warning("%s The walker takes the robot when it is free.", error)
                self._refusal = str(error)
            self._service.lose_robot(self._refusal)
            time.sleep(_RETRY_INTERVAL)
            return False
        self._refusal = ""
        return True

    def _serve(self, *, lockstep: bool) -> bool:
        """Answer frames until the order is done (True), or the robot is lost or the process stopped (False)."""
        controller = self._controller
        assert controller is not None
        receive = self._link.next if lockstep else self._link.latest
        ran = time.monotonic()
        while not self._may_leave():
            if self._service is not None and not self._service.wanted:
                self._link.release()
                self._boot = None
                self._service.note_released()
                return False
            if self._process_notices():
                self._interruptions += 1
                self._boot, self._taken = None, True
                return False
            try:
                frame = receive(SILENCE_TIMEOUT)
            except FrameError as error:
                self._warn(str(error))  # from a foreign sender; the robot's own version is checked
                continue
            now = time.monotonic()
            if (stalled := now - ran - SILENCE_TIMEOUT) > SILENCE_TIMEOUT:
                self._warn(
                    f"this process stood still for {stalled:.1f} s (suspended, or starved by other work)"
                )
            ran = now
            if not self._link.lease:
                if not self._stop():
                    logger.warning("the robot is gone; waiting for it to come back")
                    self._lost_at = time.monotonic()
                return False
            if frame is None:
                # a keepalive, so that a robot that pauses does not give the lease away
                if not self._acquire() and self._closes:
                    return False
                ran = time.monotonic()
            elif not lockstep and 0 <= self._seq < frame.seq - GUARD_TAKEOVER_CYCLES:
                logger.warning(
                    "no frame of the robot for %d cycles, in which its guard took it over; the walk restarts",
                    frame.seq - self._seq,
                )
                self._interruptions += 1
                self._boot = None
                return False
            elif frame.seq > self._seq:
                self._answer(controller, frame, lockstep)
                if controller.done:
                    return True
            elif frame.seq < self._seq:
                logger.warning("the robot restarted; so does the walk")
                self._boot = None
                return False
            elif lockstep and self._last is not None:
                self._link.send(self._last)  # the robot repeats its frame: an old lease lost the answer
        return False

    def _may_leave(self) -> bool:
        """Whether to leave the robot now: the process is asked to end, and the feet are closed."""
        controller = self._controller
        if not self._stop():
            return False
        if controller is None or controller.state not in ("walk", "stopping"):
            return True
        if not self._closes:
            logger.info("closing the feet; a second Ctrl-C leaves the robot at once")
            controller.stop()
            self._closes = True
        return False

    def _answer(self, controller: Controller, frame: SensorFrame, lockstep: bool) -> None:
        if self._seq >= 0:
            self._skipped += frame.seq - self._seq - 1
        self._seq, self._walked = frame.seq, True
        if self._service is not None and not self._closes:
            self._service.before(controller, frame.seq)
        self._take_upper_body(controller)
        before, state, failure = controller.interruptions, controller.state, controller.failure
        began = time.perf_counter()
        self._last = controller.tick(frame)
        tick = time.perf_counter() - began
        self._ticks.add(tick)
        if self._service is None and state == "approach" and controller.state == "walk" and controller.airborne:
            raise WalkRefused(HANGS)
        if controller.state == "fallen" != state:
            logger.warning("the robot falls: %s", controller.fall_cause)
        if controller.failure and not failure:
            logger.warning("the walk ends: %s; the robot moves to its stand", controller.failure)
        if controller.interruptions > before:
            self._interruptions += 1
            logger.warning(
                "no answer reached the robot for over %.0f ms, more than the walk bears in mid-step: it goes "
                "on from a stand",
                1e3 * controller.walk.parameters.max_gap,
            )
        if not lockstep:
            self._check_delay(controller)
        if self._service is not None:
            self._service.after(controller, frame.seq)
            for text in self._service.take_notes():
                self._link.publish(Notice(seq=frame.seq, level="info", code=ORDER, text=text))
        telemetry = controller.telemetry
        if lockstep:
            # First, so that it is there when the robot acts on the answer.
            self._link.publish(telemetry)
            self._link.send(self._last)
        else:
            self._link.send(self._last)
            self._link.publish(msgspec.structs.replace(telemetry, tick=tick))

    def _take_upper_body(self, controller: Controller) -> None:
        try:
            order = self._link.upper_body()
        except FrameError as error:
            self._warn(str(error))
            return
        if order is not None:
            controller.upper_body.take(order)

    def _check_delay(self, controller: Controller) -> None:
        """Close the feet on a link that is worse than a walk bears."""
        max_delay = gait_kind(controller.walk.gait.name).max_delay
        if not self._dry_run and controller.delay > max_delay and controller.state in ("approach", "walk"):
            self._late = True
            controller.stop()
            self._warn(
                f"answers reach the robot {1e3 * controller.delay:.0f} ms late, a walk bears "
                f"{1e3 * max_delay:.0f} ms: the feet are closed"
            )

    def _warn(self, sentence: str) -> None:
        now = time.monotonic()
        if now - self._warned_at >= 1.0:
            self._warned_at = now
            logger.warning("%s", sentence)

    def _process_notices(self) -> bool:
        """Log the robot's notices; True when the walk must end: its guard or another controller took over."""
        taken = False
        for notice in self._link.notices():
            logger.log(logging.DEBUG if notice.routine else logging.WARNING, "the robot says: %s", notice.text)
            taken = taken or notice.code in ("guard-crouch", "guard-sit", "guard-rest")
            if notice.code == "no-lease" and not taken:
                # another controller may hold the lease since this process was suspended
                taken = not self._acquire()
        return taken

    def _check_body(self, info: Info) -> Body:
        body = load_body(self._body) if self._body else body_of(info.body, info.sheet)
        self._body_name = info.body
        if body.name != info.body:
            raise ConfigurationError(
                f"The robot at {self._link.endpoint} is a {info.body}, not a {body.name}; leave --robot out to "
                "walk whatever is there."
            )
        return body

    def result(self) -> WalkResult:
        """The walk so far."""
        ticks = self._ticks.percentiles()
        controller = self._controller
        return WalkResult(
            body=self._body_name,
            state=controller.state if controller else "waiting",
            steps=controller.telemetry.step if controller else 0,
            displacement=controller.odometry_pose if controller else (0.0, 0.0, 0.0),
            late=self._late,
            fell=controller is not None and controller.state == "fallen",
            fall_cause=controller.fall_cause if controller else "",
            failure=controller.failure if controller else "",
            done=controller is not None and controller.done and not self._late and not controller.failure,
            ticks=ticks.count,
            interruptions=self._interruptions,
            skipped=self._skipped,
            tick_p50=ticks.p50,
            tick_p99=ticks.p99,
            inference=controller.inference if controller else None,
        )
