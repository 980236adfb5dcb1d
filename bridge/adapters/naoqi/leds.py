"""ALLeds: groups of LEDs and colours, as timed commands of the DCM. Names: vendor's page on ALLeds."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.arguments import MAX_DURATION, number, text
from bridge.adapters.naoqi.joints import Joints
from bridge.adapters.naoqi.motion_tasks import MotionTask, MotionTasks
from bridge.dcm.actuators import led_names
from bridge.errors import NaoqiRefused

_COLOURS: Final = ("Red", "Green", "Blue")
_NAMED: Final = {
    "white": 0xFFFFFF,
    "red": 0xFF0000,
    "green": 0x00FF00,
    "blue": 0x0000FF,
    "yellow": 0xFFFF00,
    "magenta": 0xFF00FF,
    "cyan": 0x00FFFF,
}
_PARTS: Final = {
    "AllLeds": "",
    "FaceLeds": "Face/",
    "EarLeds": "Ears/",
    "ChestLeds": "ChestBoard/",
    "BrainLeds": "Head/",
    "FeetLeds": "Foot/",
    "LeftFaceLeds": "/Left/",
    "RightFaceLeds": "/Right/",
    "LeftEarLeds": "Ears/Led/Left/",
    "RightEarLeds": "Ears/Led/Right/",
    "LeftFootLeds": "LFoot/",
    "RightFootLeds": "RFoot/",
}


class Leds:
    """Methods of `ALLeds`; not thread-safe, the caller locks.

    Args:
        joints: whose DCM has the LEDs.
        tasks: for calls that end when the fade does.
    """

    def __init__(self, joints: Joints, tasks: MotionTasks) -> None:
        self._joints, self._tasks = joints, tasks
        self._all = led_names()

    def _group(self, name: Any) -> list[str]:
        """LEDs of a group, or the one of that name (with or without `/Actuator/Value`)."""
        wanted = text(name, "LED name").removesuffix("/Actuator/Value").removeprefix("Device/SubDeviceList/")
        part = _PARTS.get(wanted, wanted)
        found = [led for led in self._all if part in led]
        if wanted in ("LeftFaceLeds", "RightFaceLeds"):
            found = [led for led in found if led.startswith("Face/")]
        if not found or (wanted not in _PARTS and wanted not in self._all):
            raise NaoqiRefused(f"ALLeds: {wanted!r:.60} is no LED and no group; groups: {', '.join(_PARTS)}.")
        return found

    def fade(self, name: Any, intensity: Any, duration: Any) -> Future[Any]:
        """All LEDs of a group to one brightness (0 to 1) in a time (s); waits for the end."""
        value = number(intensity, "ALLeds: intensity", 0.0, 1.0)
        seconds = number(duration, "ALLeds: duration", 0.0, MAX_DURATION)
        return self._tasks.begin(self._go([(led, [(seconds, value)]) for led in self._group(name)]))

    def fade_rgb(self, name: Any, *arguments: Any) -> Future[Any]:
        """To a colour in a time: `(red, green, blue, s)`, `(0x00RRGGBB, s)` or `(colour's name, s)`."""
        if len(arguments) == 2:
            colour: tuple[float, ...] = _colour(arguments[0])
            duration = arguments[1]
        elif len(arguments) == 4:
            colour = tuple(number(part, "ALLeds.fadeRGB: colour", 0.0, 1.0) for part in arguments[:3])
            duration = arguments[3]
        else:
            raise NaoqiRefused("ALLeds.fadeRGB takes (name, red, green, blue, s) or (name, colour, s).")
        return self._colours(name, [colour], [number(duration, "ALLeds.fadeRGB: duration", 0.0, MAX_DURATION)])

    def fade_list(self, name: Any, colours: Any, times: Any) -> Future[Any]:
        """Through colours (0x00RRGGBB) at times (s); waits for the end."""
        if not isinstance(colours, list) or not isinstance(times, list) or len(colours) != len(times):
            raise NaoqiRefused("ALLeds.fadeListRGB takes a list of colours and a list of as many times.")
        moments = [number(time, "ALLeds.fadeListRGB: time", 0.0, MAX_DURATION) for time in times]
        return self._colours(name, [_colour(colour) for colour in colours], moments)

    def _colours(self, name: Any, colours: list[tuple[float, ...]], times: list[float]) -> Future[Any]:
        paths = []
        for led in self._group(name):
            part = [i for i, colour in enumerate(_COLOURS) if f"/{colour}" in led]
            # A LED of one colour (ears, head) shows the brightest part.
            values = [colour[part[0]] if part else max(colour) for colour in colours]
            paths.append((led, list(zip(times, values, strict=True))))
        return self._tasks.begin(self._go(paths))

    def _go(self, paths: list[tuple[str, list[tuple[float, float]]]]) -> MotionTask:
        for led, points in paths:
            self._joints.put(f"{led}/Actuator/Value", points)
        last = max((points[-1][0] for _, points in paths if points), default=0.0)
        yield self._joints.now + round(1000.0 * last)

    def intensity(self, name: Any) -> float:
        """Mean brightness of a group, 0 to 1."""
        leds = [f"{led}/Actuator/Value" for led in self._group(name)]
        values = self._joints.dcm.read(leds, self._joints.frame.position)
        return sum(values) / len(values)

    def methods(self) -> dict[str, Callable[..., Any]]:
        """Methods of the service."""
        return {
            "on": lambda name: self.fade(name, 1.0, 0.0),
            "off": lambda name: self.fade(name, 0.0, 0.0),
            "reset": lambda name: self.fade(name, 1.0, 0.0),
            "setIntensity": lambda name, intensity: self.fade(name, intensity, 0.0),
            "getIntensity": self.intensity,
            "fade": self.fade,
            "fadeRGB": self.fade_rgb,
            "fadeListRGB": self.fade_list,
            "listGroups": lambda: list(_PARTS),
            "listGroup": self._group,
            "listLEDs": lambda: list(self._all),
        }


def _colour(colour: Any) -> tuple[float, float, float]:
    value = _NAMED.get(colour, colour) if isinstance(colour, str) else colour
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 0xFFFFFF:
        raise NaoqiRefused(f"{colour!r:.40} is no colour; 0x00RRGGBB or one of {', '.join(_NAMED)} is.")
    return (value >> 16 & 255) / 255.0, (value >> 8 & 255) / 255.0, (value & 255) / 255.0
