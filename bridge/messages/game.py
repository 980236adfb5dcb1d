"""A game of the RoboCup Standard Platform League as its GameController reports it, and a robot's part in it.

The words are those of the header of the GameController, version 18, in the order of its numbers; its bytes are
in `bridge.adapters.gamecontroller.packets`.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal

import msgspec

GameState = Literal["initial", "ready", "set", "playing", "finished", "standby"]
GamePhase = Literal["normal", "penalty-shoot-out", "overtime", "timeout"]
SetPlay = Literal["none", "goal-kick", "pushing-free-kick", "corner-kick", "kick-in", "penalty-kick"]
TeamColour = Literal[
    "blue", "red", "yellow", "black", "white", "green", "orange", "purple", "brown", "gray"
]  # fmt: skip
Penalty = Literal[
    "none",
    "illegal-ball-contact",
    "player-pushing",
    "illegal-motion-in-set",
    "inactive-player",
    "illegal-position",
    "leaving-the-field",
    "request-for-pickup",
    "local-game-stuck",
    "illegal-position-in-set",
    "player-stance",
    "illegal-motion-in-standby",
    "substitute",
    "manual",
]
MAX_PLAYERS: Final = 20
"""Players of a team that a packet has room for."""

Byte = Annotated[int, msgspec.Meta(ge=0, le=255)]
Seconds = Annotated[int, msgspec.Meta(ge=-(2**15), le=2**15 - 1)]
Word = Annotated[int, msgspec.Meta(ge=0, le=2**16 - 1)]
PlayerNumber = Annotated[int, msgspec.Meta(ge=1, le=MAX_PLAYERS)]


class PlayerReport(msgspec.Struct, frozen=True):
    """A player of a team."""

    penalty: Penalty = "none"
    seconds: Byte = 0
    """Until the penalty ends, s."""


_FREE: Final = PlayerReport()


class TeamReport(msgspec.Struct, frozen=True, kw_only=True):
    """A team."""

    number: Byte
    colour: TeamColour = "blue"
    """Jersey colour of its field players."""
    goalkeeper_colour: TeamColour = "black"
    goalkeeper: Annotated[int, msgspec.Meta(ge=0, le=MAX_PLAYERS)] = 1
    """Player number of the goalkeeper; 0: there is none."""
    score: Byte = 0
    penalty_shots: Byte = 0
    """Shots so far in a penalty shoot-out; otherwise 1 for a team in fallback mode."""
    single_shots: Word = 0
    """Success of each of these, a bit each."""
    message_budget: Word = 0
    """Messages that the team may still send in the game."""
    players: Annotated[tuple[PlayerReport, ...], msgspec.Meta(min_length=MAX_PLAYERS, max_length=MAX_PLAYERS)]
    """By player number, the first has number 1."""


class RobotGame(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The game for one robot, part of the ground truth."""

    team: Byte = 0
    """Number of its team."""
    player: Annotated[int, msgspec.Meta(ge=0, le=MAX_PLAYERS)] = 0
    """Its number in the team; 0: it takes part in no game."""
    state: Literal[GameState, ""] = ""
    """Empty: no report yet."""
    set_play: SetPlay = "none"
    colour: Literal[TeamColour, ""] = ""
    """Jersey colour of its team."""
    kicking: bool = False
    """Its team has the kick-off or the set play."""
    left: bool = True
    """Its team defends the goal on the negative x axis, as the first one of a report does."""
    score: tuple[Byte, Byte] = (0, 0)
    """Goals of its team and of the other one."""
    seconds_remaining: Seconds = 0
    """Remaining time of the half, s; negative after its end."""
    penalty: Penalty = "none"
    penalty_seconds: Byte = 0
    """Until the penalty ends, s."""


NO_GAME: Final = RobotGame()


class GameReport(msgspec.Struct, frozen=True, kw_only=True):
    """The game, as the GameController sends it twice a second."""

    state: GameState = "initial"
    phase: GamePhase = "normal"
    set_play: SetPlay = "none"
    first_half: bool = True
    playoff: bool = False
    players_per_team: Byte = MAX_PLAYERS
    kicking_team: Byte | None = None
    """Number of the team that has the next kick-off or the set play; None: neither, 255 in a packet."""
    seconds_remaining: Seconds = 0
    """Remaining time of the half, s."""
    secondary_seconds: Seconds = 0
    """Remaining time of the ready state, a set play or a timeout, s."""
    teams: tuple[TeamReport, TeamReport]
    """The first one defends the goal on the negative x axis."""

    def for_player(self, team: int, player: int) -> RobotGame | None:
        """The game for a player (from 1); None: its team does not play in it."""
        numbers = [one.number for one in self.teams]
        if team not in numbers:
            return None
        place = numbers.index(team)
        own, other = self.teams[place], self.teams[1 - place]
        return RobotGame(
            team=team,
            player=player,
            state=self.state,
            set_play=self.set_play,
            colour=own.colour,
            kicking=self.kicking_team == team,
            left=place == 0,
            score=(own.score, other.score),
            seconds_remaining=self.seconds_remaining,
            penalty=own.players[player - 1].penalty,
            penalty_seconds=own.players[player - 1].seconds,
        )
