"""A bridge from a real V3 to V5 to `nao/<robot>`: ALMemory as sensor frames, guarded commands to its DCM."""

from __future__ import annotations

import logging
import threading
from typing import Final

from bridge.adapters.naoqi.device import NaoqiDevice
from bridge.adapters.robot_bridge import BridgeCounts, BridgeSettings, Retry, hosted
from bridge.body import load_body
from bridge.errors import ConfigurationError, LinkError
from bridge.host import RobotHost
from bridge.messages import SensorFrame

logger = logging.getLogger(__name__)

LOOK_AHEAD: Final = 0.010
"""s; see `nao-hil bridge naoqi --look-ahead`."""
_MAX_LOOK_AHEAD: Final = 0.2
"""s; no gait survives a longer one."""


class NaoqiCounts(BridgeCounts, kw_only=True):
    """Counts of a bridge; the JSON of `nao-hil bridge naoqi`."""

    frames: int = 0
    late: int = 0
    """Commands that were not at the robot by the cycle of their time."""


class NaoqiBridge:
    """Connects, bridges, and connects again.

    Args:
        url: of the robot's NAOqi.
        look_ahead: from a frame to the time of the command that answers it, s.
        settings: of the bridge.
        stop: set when it is to end.

    Raises:
        ConfigurationError: no such body, or a look-ahead that is not possible.
    """

    def __init__(self, url: str, look_ahead: float, settings: BridgeSettings, stop: threading.Event) -> None:
        if not 0.0 <= look_ahead <= _MAX_LOOK_AHEAD:
            raise ConfigurationError(
                f"A look-ahead of {look_ahead:g} s is not possible; 0 to {_MAX_LOOK_AHEAD:g} s is."
            )
        if settings.body is not None:
            load_body(settings.body)  # a misspelt name is told before anyone waits for a robot
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
