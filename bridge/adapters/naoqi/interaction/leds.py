"""ALLeds: groups of LEDs and colours, as timed commands of the DCM. Names: vendor's page on ALLeds."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Annotated, Any, Final

from bridge.adapters.naoqi.core.motion_tasks import MotionTask
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import MAX_DURATION, Duration, Range, number, offers
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
_SIDES: Final = ("Left", "Right")
_PARTS_OF_EYES: Final = {"Top": (7, 0), "Internal": (1, 2), "Bottom": (3, 4), "External": (5, 6)}
"""Part -> numbers of its LEDs, by lists of robots' users."""
MAX_GROUPS: Final = 1000
_PERIOD: Final = 0.1
"""s of one picture of random eyes (assumed)."""


def led_groups() -> dict[str, list[str]]:
    """Groups of LEDs by name (vendor's page on ALLeds); the eyes' LEDs count from 0 deg on (assumed)."""
    every = led_names()

    def having(*parts: str) -> list[str]:
        return [led for led in every if all(part in led for part in parts)]

    groups = {
        "AllLeds": list(every),
        "BrainLeds": having("Head/"),
        "EarLeds": having("Ears/"),
        "FaceLeds": having("Face/"),
        "ChestLeds": having("ChestBoard/"),
        "FeetLeds": having("Foot/"),
        **{f"AllLeds{colour}": having(f"/{colour}") for colour in _COLOURS},
        "BrainLedsFront": having("Head/", "Front/"),
        "BrainLedsMiddle": having("Head/", "Middle/"),
        "BrainLedsBack": having("Head/", "Rear/"),
    }
    for side in _SIDES:
        ear = having(f"Ears/Led/{side}/")
        groups |= {
            f"BrainLeds{side}": having("Head/", f"/{side}/"),
            f"{side}EarLeds": ear,
            f"{side}EarLedsEven": ear[::2],
            f"{side}EarLedsOdd": ear[1::2],
            f"{side}EarLedsFront": [led for led in ear if not _is_rear(led)],
            f"{side}EarLedsBack": [led for led in ear if _is_rear(led)],
            f"{side}FaceLeds": having("Face/", f"/{side}/"),
            **{f"{side}FaceLeds{colour}": having("Face/", f"/{colour}/{side}/") for colour in _COLOURS},
            f"{side}FootLeds": having(f"{side[0]}Foot/"),
            **{f"{side}EarLed{i + 1}": [led] for i, led in enumerate(ear)},
            **{f"{side}FaceLed{i + 1}": having("Face/", f"/{side}/{45 * i}Deg") for i in range(8)},
            **{f"{side}FootLeds{colour}": having(f"{side[0]}Foot/", colour) for colour in _COLOURS},
        }
    groups |= {f"FaceLeds{colour}": having("Face/", f"/{colour}/") for colour in _COLOURS}
    groups |= {f"ChestLeds{colour}": having("ChestBoard/", colour) for colour in _COLOURS}
    groups |= {f"FaceLedLeft{i}": groups[f"LeftFaceLed{i + 1}"] for i in range(8)}
    groups |= {f"FaceLedRight{i}": groups[f"RightFaceLed{8 - i}"] for i in range(8)}
    groups |= {f"FaceLed{i}": groups[f"FaceLedLeft{i}"] + groups[f"FaceLedRight{i}"] for i in range(8)}
    for part, numbers in _PARTS_OF_EYES.items():
        for side in ("", *_SIDES):
            groups[f"FaceLeds{side}{part}"] = [led for i in numbers for led in groups[f"FaceLed{side}{i}"]]
    return groups | {f"Brain{i}": [led] for i, led in enumerate(groups["BrainLeds"])}


def _is_rear(led: str) -> bool:
    """Whether an LED is on the rear half of an ear: from 180 deg on (assumed)."""
    return int(led.rpartition("/")[2].removesuffix("Deg")) >= 180


class Leds(Service):
    """Methods of `ALLeds`."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._all = led_names()
        self._groups = led_groups()

    @offers("ALLeds.listLED", "ALLeds.listGroup")
    def _group(self, name: str) -> list[str]:
        """LEDs of a group, or one LED by its name (with or without `/Actuator/Value`)."""
        wanted = name.removesuffix("/Actuator/Value").removeprefix("Device/SubDeviceList/")
        if wanted in self._groups:
            return self._groups[wanted]
        if wanted in self._all:
            return [wanted]
        raise NaoqiRefused(
            f"ALLeds: {wanted!r:.60} is no LED and no group; AllLeds, FaceLeds, EarLeds, ChestLeds, FeetLeds "
            "and BrainLeds are some of listGroups()."
        )

    @offers("ALLeds.createGroup")
    def _create(self, name: str, leds: list[str]) -> None:
        members = [led for one in leds for led in self._group(one)]
        if len(self._groups) < MAX_GROUPS or name in self._groups:
            self._groups[name] = members

    @offers("ALLeds.fade")
    def fade(self, name: str, intensity: Annotated[float, Range(0.0, 1.0)], duration: Duration) -> Future[Any]:
        """Fade a group to a brightness (0 to 1) in a time (s); waits for the end."""
        return self._others.begin(
            self._run_paths([(led, [(duration, intensity)]) for led in self._group(name)])
        )

    @offers("ALLeds.fadeRGB")
    def fade_rgb(self, name: str, *arguments: Any) -> Future[Any]:
        """Fade to a colour in a time: `(red, green, blue, s)`, `(0x00RRGGBB, s)` or `(colour's name, s)`."""
        if len(arguments) == 2:
            colour: tuple[float, ...] = _colour(arguments[0])
            duration = arguments[1]
        elif len(arguments) == 4:
            colour = tuple(number(part, "ALLeds.fadeRGB: colour", 0.0, 1.0) for part in arguments[:3])
            duration = arguments[3]
        else:
            raise NaoqiRefused("ALLeds.fadeRGB takes (name, red, green, blue, s) or (name, colour, s).")
        return self._colours(name, [colour], [number(duration, "ALLeds.fadeRGB: duration", 0.0, MAX_DURATION)])

    @offers("ALLeds.fadeListRGB")
    def fade_list(self, name: str, colours: list[Any], times: list[Duration]) -> Future[Any]:
        """Fade through colours (0x00RRGGBB) at times (s); waits for the end."""
        if len(colours) != len(times):
            raise NaoqiRefused("ALLeds.fadeListRGB takes a list of colours and a list of as many times.")
        return self._colours(name, [_colour(colour) for colour in colours], times)

    def _colours(self, name: str, colours: list[tuple[float, ...]], times: list[float]) -> Future[Any]:
        paths = []
        for led in self._group(name):
            part = [i for i, colour in enumerate(_COLOURS) if f"/{colour}" in led]
            # A LED of one colour (ears, head) shows the brightest part.
            values = [colour[part[0]] if part else max(colour) for colour in colours]
            paths.append((led, list(zip(times, values, strict=True))))
        return self._others.begin(self._run_paths(paths))

    def _run_paths(self, paths: list[tuple[str, list[tuple[float, float]]]], least: float = 0.0) -> MotionTask:
        for led, points in paths:
            self._joints.put(f"{led}/Actuator/Value", points)
        last = max((points[-1][0] for _, points in paths if points), default=least)
        yield self._joints.now + round(1000.0 * last)

    def _pattern(self, method: str, seconds: Any, step: float, shade: Callable[[int, int], int]) -> Future[Any]:
        """Show pictures on both eyes, one after the other; waits for the end.

        Args:
            step: of one picture, s.
            shade: colour (0x00RRGGBB) of each of the eight places in a picture, by their numbers.
        """
        count = round(number(seconds, f"{method}: duration", 0.0, MAX_DURATION) / step)
        places = [(place, led) for place in range(8) for led in self._group(f"FaceLed{place}")]

        def task() -> MotionTask:
            for picture in range(count):
                for place, led in places:
                    part = next(i for i, name in enumerate(_COLOURS) if f"/{name}" in led)
                    self._joints.put(f"{led}/Actuator/Value", [(0.0, _colour(shade(place, picture))[part])])
                yield self._joints.now + round(1000.0 * step)

        return self._others.begin(task())

    @offers("ALLeds.randomEyes")
    def _random(self, duration: Any) -> Future[Any]:
        shades = list(_NAMED.values())
        return self._pattern("ALLeds.randomEyes", duration, _PERIOD, lambda i, n: shades[(5 * i + n * n) % 7])

    @offers("ALLeds.rotateEyes")
    def _rotate(
        self, colour: Any, turn: Annotated[float, Range(0.16, MAX_DURATION)], duration: Any
    ) -> Future[Any]:
        _colour(colour)
        shade = _NAMED[colour] if isinstance(colour, str) else colour
        step = turn / 8.0
        return self._pattern("ALLeds.rotateEyes", duration, step, lambda i, n: shade if n % 8 == i else 0)

    @offers("ALLeds.rasta")
    def _rasta(self, duration: Any) -> Future[Any]:
        shades = (_NAMED["green"], _NAMED["yellow"], _NAMED["red"])
        return self._pattern("ALLeds.rasta", duration, 0.5, lambda _, n: shades[n % 3])

    @offers("ALLeds.earLedsSetAngle")
    def _ears(
        self, degrees: Annotated[float, Range(-360.0, 360.0)], duration: Duration, leave: bool
    ) -> Future[Any]:
        """Light the ears up to an angle."""
        stays = 1.0 if leave else 0.0
        paths: list[tuple[str, list[tuple[float, float]]]] = []
        for side in _SIDES:
            for i, led in enumerate(self._group(f"{side}EarLeds")):
                on = 36.0 * i <= abs(degrees)
                at = duration * min(1.0, 36.0 * i / max(1.0, abs(degrees)))
                paths.append((led, [(at, 1.0), (duration + 0.01, stays)] if on else [(0.0, 0.0)]))
        return self._others.begin(self._run_paths(paths, duration))

    @offers("ALLeds.getIntensity")
    def intensity(self, name: str) -> float:
        """Mean brightness of a group, 0 to 1."""
        leds = [f"{led}/Actuator/Value" for led in self._group(name)]
        values = self._joints.dcm.read(leds, self._joints.frame.position)
        return sum(values) / len(values)

    @offers("ALLeds.on", "ALLeds.reset", intensity=1.0)
    @offers("ALLeds.off", intensity=0.0)
    def _switch(self, name: str, *, intensity: float) -> Any:
        return self.fade(name, intensity, 0.0)

    @offers("ALLeds.setIntensity")
    def _set_intensity(self, name: str, intensity: Annotated[float, Range(0.0, 1.0)]) -> Any:
        return self.fade(name, intensity, 0.0)

    _list_groups = offers("ALLeds.listGroups")(lambda self: list(self._groups))
    _list_leds = offers("ALLeds.listLEDs")(lambda self: list(self._all))


def _colour(colour: Any) -> tuple[float, float, float]:
    value = _NAMED.get(colour, colour) if isinstance(colour, str) else colour
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 0xFFFFFF:
        raise NaoqiRefused(f"{colour!r:.40} is no colour; 0x00RRGGBB or one of {', '.join(_NAMED)} is.")
    return (value >> 16 & 255) / 255.0, (value >> 8 & 255) / 255.0, (value & 255) / 255.0
