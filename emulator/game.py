"""LEDs by which a robot shows the league's game, as the league's rules want them and teams' programs set them.

Chest: the state, by the rule book as NomadZ's `led_handler.cpp` quotes it. Feet: `GameCtrl.cpp`, the library of
the GameController for NAO.
"""

from __future__ import annotations

from typing import Final

from bridge.messages.game import GameState, RobotGame, TeamColour

Rgb = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

_DARK: Final[Rgb] = (0, 0, 0)
_RED: Final[Rgb] = (255, 0, 0)
_WHITE: Final[Rgb] = (255, 255, 255)
STATES: Final[dict[GameState, Rgb]] = {
    "initial": _DARK,
    "standby": (0, 255, 255),
    "ready": (0, 0, 255),
    "set": (255, 255, 0),
    "playing": (0, 255, 0),
    "finished": _DARK,
}
"""Colour of the chest light by state of the game; red for a penalized robot."""
COLOURS: Final[dict[TeamColour, Rgb]] = {
    "blue": (0, 0, 255),
    "red": _RED,
    "yellow": (255, 255, 0),
    "black": _DARK,
    "white": _WHITE,
    "green": (0, 255, 0),
    "orange": (255, 128, 0),
    "purple": (255, 0, 255),
    "brown": (51, 26, 0),
    "gray": (51, 51, 51),
}
"""Colour of the left foot's light by colour of the team."""


def game_lights(game: RobotGame) -> dict[str, Rgb]:
    """Lights of a robot by the DCM's boards; the right foot is white before its team's kick-off."""
    kick_off = game.kicking and game.state in ("initial", "ready", "set")
    chest = _DARK if not game.state else _RED if game.penalty != "none" else STATES[game.state]
    return {
        "ChestBoard": chest,
        "LFoot": COLOURS[game.colour] if game.colour else _DARK,
        "RFoot": _WHITE if kick_off else _DARK,
    }
