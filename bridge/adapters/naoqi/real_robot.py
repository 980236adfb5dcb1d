"""A bridge from a real V3 to V5 to `nao/<robot>`: ALMemory as sensor frames, guarded commands to its DCM."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

from bridge.adapters.naoqi.core.joints import actuator
from bridge.adapters.naoqi.core.sensor_keys import (
    ACCELEROMETER_KEYS,
    ANGLE_KEYS,
    BATTERY_KEYS,
    FSR_KEYS,
    GYROSCOPE_KEYS,
    JOINT_KEYS,
    OLD_GYROSCOPE_KEYS,
    OLD_GYROSCOPE_STEP,
    SONAR_KEYS,
    TOUCH_KEYS,
)
from bridge.adapters.naoqi.qi_library import load_qi
from bridge.adapters.robot_bridge import BridgeCounts, BridgeSettings, Retry, hosted
from bridge.adapters.signs import KILOGRAM, NAOQI, with_signs
from bridge.body import Body, load_body
from bridge.body.joints import INDEX, JOINTS, N_JOINTS
from bridge.body.quantities import absent_joints
from bridge.dcm.actuators import driven_joints
from bridge.dcm.requests import wrapped
from bridge.errors import ConfigurationError, LinkError
from bridge.host import RobotHost
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.dcm import PREFIX


class FrameReader:
    """Reads sensor frames from a NAOqi robot's memory.

    Args:
        old_gyroscope: The robot has NAOqi 1.14's names of the gyroscope.
    """

    def __init__(self, body: Body, old_gyroscope: bool = False) -> None:
        absent = set(absent_joints(body))
        self._joints = [joint for joint in JOINTS if joint not in absent]
        self._old = old_gyroscope
        gyroscope = OLD_GYROSCOPE_KEYS if old_gyroscope else GYROSCOPE_KEYS[: body.inertial_unit.gyroscope_axes]
        self._axes = len(gyroscope)
        self._touch = [i for i, key in enumerate(TOUCH_KEYS) if "LHand" not in absent or "Hand" not in key]
        groups: list[Sequence[str]] = [
            ["DCM/Time"],
            *([PREFIX + f"{j}/{end}" for j in self._joints] for end in JOINT_KEYS.values()),
            *(
                [PREFIX + key for key in keys]
                for keys in (FSR_KEYS, ACCELEROMETER_KEYS, gyroscope, ANGLE_KEYS, BATTERY_KEYS, SONAR_KEYS)
            ),
            [PREFIX + TOUCH_KEYS[i] for i in self._touch],
        ]
        self._sizes = [len(group) for group in groups]
        self._lacking: set[int] | None = None
        """Places of the sensors that the robot lacks; None before the first reading."""
        self.keys = [key for group in groups for key in group]
        """Keys for `ALMemory.getListData`."""

    def time(self, values: Sequence[Any]) -> int:
        """The DCM's clock among the values, ms.

        Raises:
            LinkError: it is no number, or there are not as many values as keys.
        """
        clock = values[0] if len(values) == len(self.keys) else None
        if not isinstance(clock, int | float) or not math.isfinite(clock):
            raise LinkError("The robot's ALMemory gives no time of the DCM, or not one value for each key.")
        return int(clock)

    def fields(self, values: Sequence[Any]) -> Mapping[str, Any]:
        """Fields of a `SensorFrame` from the values of `keys`, in order.

        A sensor without a value in the first reading is lacking and always reads 0; later such values are NaN.

        Raises:
            LinkError: names the joint without an angle in the first reading.
        """
        if self._lacking is None:
            for joint, value in zip(self._joints, values[1:], strict=False):
                if not isinstance(value, int | float):
                    raise LinkError(
                        f"The robot's ALMemory has no angle of {joint} ({value!r:.40}); is it another body? "
                        "Give its own with --robot."
                    )
            self._lacking = {i for i, value in enumerate(values) if not isinstance(value, int | float)}
        numbers = [float(value) if isinstance(value, int | float) else math.nan for value in values]
        for i in self._lacking:
            numbers[i] = 0.0
        groups, at = [], 0
        for size in self._sizes:
            groups.append(numbers[at : at + size])
            at += size
        _, *joints, fsr, accelerometer, gyroscope, angle, battery, sonar, touch = groups
        rate = [*gyroscope, *[0.0] * (3 - self._axes)]
        if self._old:
            rate = [value * OLD_GYROSCOPE_STEP for value in rate]
        pressed = [0.0] * len(TOUCH_KEYS)
        for i, value in zip(self._touch, touch, strict=True):
            pressed[i] = value
        return dict(zip(JOINT_KEYS, map(self._by_slot, joints), strict=True)) | {
            "fsr": tuple(value * KILOGRAM for value in fsr),
            "accelerometer": with_signs(accelerometer, NAOQI.accelerometer),
            "gyroscope": with_signs(rate, NAOQI.gyroscope),
            "angle": tuple(angle),
            "battery": tuple(battery),
            "sonar": tuple(sonar),
            "touch": tuple(pressed),
        }

    def _by_slot(self, values: Sequence[float]) -> tuple[float, ...]:
        slots = [0.0] * N_JOINTS
        for joint, value in zip(self._joints, values, strict=True):
            slots[INDEX[joint]] = value
        return tuple(slots)


TIMEOUT: Final = 5.0
"""s that connecting or a call may take."""
_CLOCK_INTERVAL: Final = 0.0003
"""s between two readings of the robot's clock after an early one."""
_READ_ADVANCE: Final = 2e-5
"""s by which each reading is earlier in the robot's cycle than the last, until one is too early: readings thus
follow the end of the robot's cycle in spite of the clocks' drift."""
_POSITIONS: Final = "NaoHilPositions"
_STIFFNESSES: Final = "NaoHilStiffnesses"
BODIES: Final = {
    ("V32", True): "nao-v3.2",
    ("V33", True): "nao-v3.3",
    ("V40", True): "nao-v4",
    ("V50", True): "nao-v5",
    ("V60", True): "nao-v6",
    ("V32", False): "nao-v3",
    ("V33", False): "nao-v3",
}
"""Data sheet by `RobotConfig/Body/BaseVersion`, and whether there are hands."""


class Reading(NamedTuple):
    """One reading of the robot's memory."""

    moment: int
    """The DCM's clock, ms."""
    cycles: int
    """Cycles of the robot since the last reading; 1 unless some are left out."""
    fields: Mapping[str, Any]
    """Fields of a `SensorFrame`."""


class _Sent(NamedTuple):
    """A command on its way."""

    reply_to: int
    """Frame that it answers; -1: stiffnesses, which precede the positions of the same frame."""
    due: int
    """Time of the command, the DCM's clock, ms."""
    asked: float
    """Time of the answered reading, this machine's clock, s."""
    done: Any
    """Future of the call."""


class NaoqiDevice:
    """An open connection; close it.

    Args:
        url: of the robot's NAOqi, `tcp://HOST:9559`.
        body: Data sheet; None: by the robot's own version.
        look_ahead: s from a frame to the time of the command that answers it.

    Raises:
        LinkError: no answer, qi is not installed, or a module is missing.
        ConfigurationError: a body without a data sheet.
    """

    def __init__(self, url: str, body: str | None, look_ahead: float) -> None:
        self._url = url
        self._look_ahead = round(1000.0 * look_ahead)
        self._session = connected(url)
        try:
            self._memory, self._dcm = self._service("ALMemory"), self._service("DCM")
            old = self._value(PREFIX + GYROSCOPE_KEYS[0]) is None and (
                self._value(PREFIX + OLD_GYROSCOPE_KEYS[0]) is not None
            )
            self.body = load_body(body or self._body_name())
            self._reader = FrameReader(self.body, old)
            self._make_aliases(self.body)
        except BaseException:
            self._session.close()
            raise
        self._cycle = 1000.0 * self.body.cycle
        self._moment: int | None = None
        self._due: float | None = None
        """Time of the next cycle's values, this machine's clock, s."""
        self._asked = 0.0
        self._stiffness: tuple[float, ...] | None = None
        self._pending: deque[_Sent] = deque()
        self._arrived: deque[_Sent] = deque()
        self.late = 0
        """Commands that missed the cycle of their time."""
        self.in_force = -1
        """Frame whose answer was in force in the cycle before the last reading; -1: none yet."""

    def _service(self, name: str) -> Any:
        try:
            return self._session.service(name)
        except RuntimeError as error:
            raise LinkError(
                f"The robot at {self._url} has no module {name} ({_first_line(error)}); NAOqi 2.8 and later "
                "have no DCM, a V6 is reached with `nao-hil bridge lola`."
            ) from None

    def _body_name(self) -> str:
        version = self._value("RobotConfig/Body/BaseVersion")
        hands = self._value(f"{PREFIX}LHand/Position/Sensor/Value") is not None
        name = BODIES.get((str(version), hands))
        if name is None:
            suffix = "with" if hands else "without"
            raise ConfigurationError(
                f"The robot at {self._url} reports a {version} {suffix} hands, which has no data sheet; "
                "name the nearest with --robot."
            )
        return name

    def _make_aliases(self, body: Body) -> None:
        joints = driven_joints(body)
        self._slots = [INDEX[joint] for joint in joints]
        for alias, kind in ((_POSITIONS, "Position"), (_STIFFNESSES, "Hardness")):
            names = [actuator(joint, kind) for joint in joints]
            _, known = self._call(self._dcm.createAlias, [alias, names])
            missing = [name for name, there in zip(names, known, strict=True) if not there]
            if missing:
                raise ConfigurationError(
                    f"The robot at {self._url} has no actuator {missing[0]}; is it a {body.name}? Name its "
                    "data sheet with --robot."
                )

    def read(self) -> Reading:
        """Wait for the robot's next cycle and read it.

        Raises:
            LinkError: the connection has ended, or the robot's clock does not advance or was reset.
        """
        if self._due is not None:
            time.sleep(max(0.0, self._due - time.monotonic()))
        self._asked = time.monotonic()
        values = self._call(self._memory.getListData, self._reader.keys)
        if self._reader.time(values) == self._moment:
            self._due = self._asked = self._await_cycle()
            values = self._call(self._memory.getListData, self._reader.keys)
        moment = self._reader.time(values)
        passed = self._cycle if self._moment is None else wrapped(moment - self._moment)
        if passed < 0:
            raise LinkError(f"The clock of the robot at {self._url} was reset: its NAOqi restarted.")
        if self._due is not None:
            # At most a cycle from now, also for a clock that catches up.
            ahead = self._due + passed / 1000.0 - _READ_ADVANCE
            self._due = min(ahead, self._asked + self._cycle / 1000.0)
        self._moment = moment
        self._check_pending()
        while self._arrived and wrapped(moment - self._arrived[0].due) >= self._cycle:
            sent = self._arrived.popleft()
            self.in_force = sent.reply_to
            # Due a cycle before: late if it had not arrived.
            self.late += wrapped(moment - sent.due) - passed >= self._cycle
        return Reading(moment, max(1, round(passed / self._cycle)), self._reader.fields(values))

    @property
    def spare(self) -> float:
        """Time until the next reading, s."""
        return max(0.0, self._due - time.monotonic()) if self._due is not None else 0.0

    def _await_cycle(self) -> float:
        """Read the robot's clock until it advances; the time of that reading."""
        deadline = time.monotonic() + TIMEOUT
        while time.monotonic() < deadline:
            asked = time.monotonic()
            if self._call(self._memory.getListData, ["DCM/Time"])[0] != self._moment:
                return asked
            time.sleep(_CLOCK_INTERVAL)
        raise LinkError(f"The clock of the robot at {self._url} has not advanced for {TIMEOUT:g} s.")

    def write(self, moment: int, seq: int, command: ActuatorFrame) -> None:
        """Command all joints for the time of the answered reading plus the look-ahead; does not wait.

        Args:
            seq: number of its frame.
            command: an answer to an older frame has less time left.

        Raises:
            LinkError: the robot refused an earlier command, or the connection has ended.
        """
        self._check_pending()
        wanted = tuple(command.stiffness[slot] for slot in self._slots)
        if wanted != self._stiffness:
            self._put(_STIFFNESSES, "ClearAll", moment, wanted, -1)
            self._stiffness = wanted
        # Future commands stay: the joints follow each command at its time.
        left = max(0, self._look_ahead - round((seq - command.reply_to) * self._cycle))
        angles = tuple(command.position[slot] for slot in self._slots)
        self._put(_POSITIONS, "ClearAfter", wrapped(moment + left), angles, command.reply_to)

    def _put(self, alias: str, update: str, moment: int, values: Sequence[float], reply_to: int) -> None:
        command = [alias, update, "time-separate", 0, [moment], [[value] for value in values]]
        try:
            done = self._dcm.setAlias(command, _async=True)
        except RuntimeError as error:
            raise self._ended(error) from None
        self._pending.append(_Sent(reply_to, moment, self._asked, done))

    def _check_pending(self) -> None:
        now = time.monotonic()
        while self._pending and (self._pending[0].done.isFinished() or now - self._pending[0].asked > TIMEOUT):
            sent = self._pending.popleft()
            if not sent.done.isFinished():
                raise LinkError(f"The robot at {self._url} has not answered for {TIMEOUT:g} s.")
            if sent.done.hasError():
                raise LinkError(f"The robot at {self._url} refused a command: {_first_line(sent.done.error())}")
            if sent.reply_to >= 0:
                self._arrived.append(sent)

    def _value(self, key: str) -> Any:
        return self._call(self._memory.getListData, [key])[0]

    def _call(self, method: Any, *arguments: Any) -> Any:
        try:
            future = method(*arguments, _async=True)
            if str(future.wait(round(1000.0 * TIMEOUT))).endswith("Running"):
                raise LinkError(f"The robot at {self._url} has not answered for {TIMEOUT:g} s.")
            return future.value()
        except RuntimeError as error:
            raise self._ended(error) from None

    def _ended(self, error: RuntimeError) -> LinkError:
        return LinkError(f"The connection to {self._url} has ended: {_first_line(error)}.")

    def close(self) -> None:
        """End the connection."""
        self._session.close()


def connected(url: str, timeout: float = TIMEOUT) -> Any:
    """A session of qi; close it.

    Args:
        timeout: s.

    Raises:
        LinkError: none answers there, or qi is not installed.
    """
    try:
        qi = load_qi()
    except ImportError:
        raise LinkError("qi is not installed; pip install 'nao-hil[naoqi]'.") from None
    session = qi.Session()
    try:
        future = session.connect(url, _async=True)
        state = str(future.wait(round(1000.0 * timeout)))
        if state.endswith("Running") or not session.isConnected():  # also connected without an answer
            raise RuntimeError("no answer")
    except RuntimeError as error:
        raise LinkError(f"No NAOqi answers at {url} ({_first_line(error)}).") from None
    return session


def _first_line(error: object) -> str:
    lines = str(error).splitlines()
    return lines[0].rstrip(".") if lines else "no reason given"


logger = logging.getLogger(__name__)

LOOK_AHEAD: Final = 0.010
"""s; see `nao-hil bridge naoqi --look-ahead`."""
_MAX_LOOK_AHEAD: Final = 0.2
"""s; every gait falls with a longer one."""


class NaoqiCounts(BridgeCounts, kw_only=True):
    """Counts of a bridge; the JSON of `nao-hil bridge naoqi`."""

    frames: int = 0
    late: int = 0
    """Commands that missed the cycle of their time."""


class NaoqiBridge:
    """Connects to NAOqi and bridges, again after each connection.

    Args:
        url: of the robot's NAOqi.
        look_ahead: from a frame to the time of the command that answers it, s.

    Raises:
        ConfigurationError: no such body, or an impossible look-ahead.
    """

    def __init__(self, url: str, look_ahead: float, settings: BridgeSettings, stop: threading.Event) -> None:
        if not 0.0 <= look_ahead <= _MAX_LOOK_AHEAD:
            raise ConfigurationError(
                f"A look-ahead of {look_ahead:g} s is not possible; 0 to {_MAX_LOOK_AHEAD:g} s is."
            )
        if settings.body is not None:
            load_body(settings.body)  # reports a misspelt name before the wait for a robot
        self._url, self._look_ahead, self._settings, self._stop = url, look_ahead, settings, stop
        self._counts = NaoqiCounts()

    def run(self) -> NaoqiCounts:
        """Bridge until stopped.

        Raises:
            ConfigurationError: a robot without a data sheet.
            LinkError: the endpoint cannot be listened on.
        """
        logger.info("waiting for NAOqi at %s", self._url)
        retry = Retry(self._stop)
        while not self._stop.is_set():
            try:
                device = NaoqiDevice(self._url, self._settings.body, self._look_ahead)
            except LinkError as error:
                retry.wait(error)
                continue
            retry.succeeded()
            try:
                with hosted(self._settings, device.body, self._counts, "naoqi") as host:
                    self._cycle(device, host)
            finally:
                self._counts.late += device.late
                device.close()
        return self._counts

    def _cycle(self, device: NaoqiDevice, host: RobotHost) -> None:
        seq = -1
        while not host.should_end(self._stop):
            reading = device.read()
            seq += reading.cycles if seq >= 0 else 1
            self._counts.frames += 1
            self._counts.left_out += reading.cycles - 1
            frame = SensorFrame(seq=seq, time=seq * device.body.cycle, **reading.fields)
            host.in_force = device.in_force
            command = host.exchange(frame, wait=device.spare)
            if command is not None:
                device.write(reading.moment, seq, command)
                self._counts.commands += 1
