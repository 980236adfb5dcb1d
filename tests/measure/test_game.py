"""A game of walkers and a LoLA program, short, in lockstep."""

from pathlib import Path

from tests.measure.game import PLACES, play


def test_a_game_in_lockstep_is_the_same_twice(tmp_path: Path) -> None:
    games = []
    for turn in ("first", "second"):
        (tmp_path / turn).mkdir()
        games.append(play(2.0, "lockstep", "mujoco", tmp_path / turn))
    for name in PLACES:
        first, second = (game[name] for game in games)
        assert first["sensors_sha256"] == second["sensors_sha256"]
        assert first["cycles_missed"] == 0
        assert first["cycles"] > 150
