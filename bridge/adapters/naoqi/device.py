"""A connection to a real robot's NAOqi: its memory in, timed commands of the DCM out.

Reads follow the robot's clock, not this machine's: `DCM/Time` comes with the sensors, and each read is placed
where the robot's cycle ends. Commands carry their time: that of the
frame they answer plus a look-ahead, so that what the network does to them within it moves no joint.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

from bridge.adapters.naoqi.frame_reader import FrameReader
from bridge.adapters.naoqi.names import actuator
from bridge.adapters.naoqi.qi_library import load_qi
from bridge.adapters.naoqi.sensors import GYROSCOPE_KEYS, OLD_GYROSCOPE_KEYS
from bridge.body import Body, load_body
from bridge.body.joints import INDEX
from bridge.dcm.actuators import driven_joints
from bridge.dcm.clock import wrapped
from bridge.errors import ConfigurationError, LinkError
from bridge.messages import ActuatorFrame
from bridge.messages.dcm import PREFIX

TIMEOUT: Final = 2.0
"""s that connecting or a call may take."""
_LOOK: Final = 0.0003
"""s between two looks at the robot's clock when a read came too early."""
_CREEP: Final = 2e-5
"""s by which each read comes earlier in the robot's cycle, until one is too early: so reads stay behind the
end of the robot's cycle, however the clocks drift apart."""
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
    """One look at the robot's memory."""

    moment: int
    """The DCM's clock, ms."""
    cycles: int
    """Cycles of the robot since the last reading; 1 unless some were left out."""
    fields: Mapping[str, Any]
    """Of a `SensorFrame`."""


class _Sent(NamedTuple):
    """A command on its way."""

    reply_to: int
    """Frame that it answers; -1: stiffnesses, which go before the positions of the same frame."""
    due: int
    """Time that it carries, the DCM's clock, ms."""
    asked: float
    """When the robot was read for it, this machine's clock, s."""
    done: Any
    """Future of the call."""


class NaoqiDevice:
    """An open connection; close it.

    Args:
        url: of the robot's NAOqi, `tcp://HOST:9559`.
        body: Data sheet; None: by what the robot says it is.
        look_ahead: s from a frame to the time of the command that answers it.

    Raises:
        LinkError: nobody is there, qi is not installed, or a module is missing.
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
        """When the next cycle's values will be there, by this machine's clock."""
        self._asked = 0.0
        self._stiffness: tuple[float, ...] | None = None
        self._pending: deque[_Sent] = deque()
        self._arrived: deque[_Sent] = deque()
        self.late = 0
        """Commands that were not at the robot by the cycle of their time."""
        self.in_force = -1
        """Frame whose answer was in force in the cycle before the last reading: it had arrived, and its time
        had come; -1: none yet."""

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
            what = "with" if hands else "without"
            raise ConfigurationError(
                f"The robot at {self._url} says it is a {version} {what} hands, of which there is no data "
                "sheet; name the nearest with --robot."
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
        """The robot's next cycle, waiting for it.

        Raises:
            LinkError: the connection has ended, or the robot's clock stands still or went back.
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
            raise LinkError(f"The clock of the robot at {self._url} went back: its NAOqi was started anew.")
        if self._due is not None:
            # At most a cycle from here, so that a clock that was held up and hurries is followed, too.
            ahead = self._due + passed / 1000.0 - _CREEP
            self._due = min(ahead, self._asked + self._cycle / 1000.0)
        self._moment = moment
        self._check_pending()
        while self._arrived and wrapped(moment - self._arrived[0].due) >= self._cycle:
            sent = self._arrived.popleft()
            self.in_force = sent.reply_to
            # In force a cycle before already, had it been there.
            self.late += wrapped(moment - sent.due) - passed >= self._cycle
        return Reading(moment, max(1, round(passed / self._cycle)), self._reader.fields(values))

    @property
    def spare(self) -> float:
        """Time until the next cycle is to be read, s."""
        return max(0.0, self._due - time.monotonic()) if self._due is not None else 0.0

    def _await_cycle(self) -> float:
        """Look at the robot's clock until it goes on; when that was seen."""
        deadline = time.monotonic() + TIMEOUT
        while time.monotonic() < deadline:
            asked = time.monotonic()
            if self._call(self._memory.getListData, ["DCM/Time"])[0] != self._moment:
                return asked
            time.sleep(_LOOK)
        raise LinkError(f"The clock of the robot at {self._url} has stood still for {TIMEOUT:g} s.")

    def write(self, moment: int, seq: int, command: ActuatorFrame) -> None:
        """Command all joints for the time of the answered reading plus the look-ahead; does not wait.

        Args:
            moment: of the newest reading.
            seq: number of its frame.
            command: one that answers an older frame has the less time left.

        Raises:
            LinkError: the robot refused an earlier command, or the connection has ended.
        """
        self._check_pending()
        wanted = tuple(command.stiffness[slot] for slot in self._slots)
        if wanted != self._stiffness:
            self._put(_STIFFNESSES, "ClearAll", moment, wanted, -1)
            self._stiffness = wanted
        # What was sent before and is not reached yet stays: the joints follow each command at its time.
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
        """Leave the robot."""
        self._session.close()


def connected(url: str, timeout: float = TIMEOUT) -> Any:
    """A session of qi; close it.

    Args:
        url: of a NAOqi.
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
        if state.endswith("Running") or not session.isConnected():  # connected also while nobody answers
            raise RuntimeError("no answer")
    except RuntimeError as error:
        raise LinkError(f"No NAOqi answers at {url} ({_first_line(error)}).") from None
    return session


def _first_line(error: object) -> str:
    lines = str(error).splitlines()
    return lines[0].rstrip(".") if lines else "no reason given"
