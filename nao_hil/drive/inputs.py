"""Sources of keys and stick: a terminal, and the joystick device of the Linux kernel."""

from __future__ import annotations

import os
import select
import struct
import sys
import termios
import tty
from pathlib import Path
from typing import Final, NamedTuple

from bridge.errors import ConfigurationError
from nao_hil.drive.driver import keys_of

_EVENT: Final = struct.Struct("<IhBB")
"""Time in ms, value, kind, number (the kernel's joystick interface, linux/joystick.h)."""
_BUTTON, _AXIS, _INITIAL = 0x01, 0x02, 0x80
_FULL_DEFLECTION: Final = 32767.0
_FORWARD_AXIS: Final = 1
"""Axis of the left stick, up negative."""
_BUTTON_KEYS: Final = {0: " ", 1: "g", 2: "t", 3: "m"}


class Input(NamedTuple):
    """Input."""

    keys: list[str]
    stick: float | None
    """Deflection forwards, -1..1; None: not moved."""
    open: bool = True
    """False: the terminal is closed."""


class Inputs:
    """A terminal that gives keys one by one, and optionally a gamepad; use it as a context manager.

    Args:
        gamepad: joystick device; None: the keyboard alone.

    Raises:
        ConfigurationError: stdin is no terminal, or there is no such device.
    """

    def __init__(self, gamepad: Path | None = None) -> None:
        self._terminal = sys.stdin.fileno()
        if not os.isatty(self._terminal):
            raise ConfigurationError("Driving takes a terminal; from a program, use nao_hil.WalkClient.")
        self._gamepad: int | None = None
        if gamepad is not None:
            try:
                self._gamepad = os.open(gamepad, os.O_RDONLY | os.O_NONBLOCK)
            except OSError as error:
                raise ConfigurationError(
                    f"{gamepad}: no gamepad can be read there ({error.strerror}); plug one in, or leave "
                    "--gamepad out and use the keyboard."
                ) from None

    def wait(self, timeout: float) -> Input:
        """Input within `timeout` s."""
        devices = [self._terminal] + ([self._gamepad] if self._gamepad is not None else [])
        ready, _, _ = select.select(devices, [], [], timeout)
        keys: list[str] = []
        stick: float | None = None
        if self._gamepad is not None and self._gamepad in ready:
            pressed, stick = events_of(self._read(self._gamepad))
            keys += pressed
        if self._terminal in ready:
            data = self._read(self._terminal)
            if not data:
                return Input(keys, stick, open=False)
            keys += keys_of(data)
        return Input(keys, stick)

    def _read(self, device: int) -> bytes:
        try:
            return os.read(device, 512)
        except OSError:  # the terminal has hung up, or the gamepad is unplugged
            if device == self._gamepad:
                os.close(device)
                self._gamepad = None
            return b""

    def __enter__(self) -> Inputs:
        self._before = termios.tcgetattr(self._terminal)
        tty.setcbreak(self._terminal)
        return self

    def __exit__(self, *_: object) -> None:
        termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)
        if self._gamepad is not None:
            os.close(self._gamepad)


def events_of(data: bytes) -> tuple[list[str], float | None]:
    """Keys of pressed buttons, and the last deflection of the stick, from joystick events."""
    keys: list[str] = []
    stick: float | None = None
    for _, value, kind, number in _EVENT.iter_unpack(data[: len(data) // _EVENT.size * _EVENT.size]):
        if kind == _BUTTON and value and number in _BUTTON_KEYS:
            keys.append(_BUTTON_KEYS[number])
        elif kind & ~_INITIAL == _AXIS and number == _FORWARD_AXIS:
            stick = -value / _FULL_DEFLECTION
    return keys, stick
