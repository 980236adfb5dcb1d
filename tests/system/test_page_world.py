"""The page of a world of several robots, in a headless browser."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page

from bridge.adapters.gamecontroller.referee import Call, Schedule, Team
from bridge.link.client import GuardClient, WorldClient
from bridge.messages.world import PlaceObject
from nao_hil.view.page import world_page, world_recordings
from tests.loops import until
from tests.made_worlds import PLACES, record_world
from tests.system.pages import open_page, retry_until
from tests.system.test_worlds import until_there

Start = Callable[..., Any]

pytestmark = pytest.mark.browser
WORLD = """
[[robots]]
name = "red"
robot = "nao-v4"

[[robots]]
name = "blue"
robot = "nao-v5"
seed = 1
at = [0.9, 0.4]
yaw = 90.0
"""
OTHERS = """
() => (player.actors()[0]?.moment.others ?? [])
  .map(({ name, torso, position }) => [name, torso, position.length])
"""
"""Name, place and how many numbers of each other robot that is drawn."""


def test_all_robots_are_drawn_and_orders_go_to_the_chosen_one(
    start: Start, endpoint: str, port: int, tmp_path: Path, page: Page, errors: list[str]
) -> None:
    file = tmp_path / "world.toml"
    file.write_text(WORLD)
    start(
        *("emulate", "--world", str(file), "--scenario", "field-small", "--engine", "mujoco"),
        *("--listen", endpoint, "--out", str(tmp_path / "run")),
    )
    until_there(endpoint, 2)  # a page that finds one alone shows it
    start("view", "--connect", endpoint, "--port", str(port))
    with ExitStack() as opened:
        open_page(page, port)
        world = opened.enter_context(WorldClient("blue", endpoint))
        guards = {name: opened.enter_context(GuardClient(name, endpoint)) for name in ("red", "blue")}
        chooser = page.get_by_label("robot that is shown and gets the orders")
        until(lambda: chooser.locator("option").count() == 2, "both robots")
        assert chooser.input_value() == "blue"

        def others() -> list[str]:
            return [each[0] for each in page.evaluate(OTHERS)]

        retry_until(lambda: chooser.select_option("red"), lambda: others() == ["blue"], "the other robot")
        ((name, torso, numbers),) = page.evaluate(OTHERS)
        assert name == "blue" and numbers > 3 * 20
        assert torso[:2] == pytest.approx([0.9, 0.4], abs=0.05) and 0.2 < torso[2] < 0.4
        world.send(PlaceObject(name="ball", shape="ball", size=(0.1, 0.1, 0.1), mass=0.044, at=(1.5, 0.0)))
        objects = partial(page.evaluate, "player.runs[0].header.objects.map(({ shape }) => shape)")
        until(lambda: sorted(objects()) == [*["ball"], *["box"] * 2, *["pole"] * 4], "ball and goals")

        def choose_by_key() -> None:
            chooser.focus()
            page.keyboard.press("ArrowUp")  # the names are in alphabetical order

        retry_until(choose_by_key, lambda: page.inner_text("#title") == "robot blue", "the chosen robot")
        until(lambda: others() == ["red"], "the other one")
        escape = partial(page.keyboard.press, "Escape")  # the chooser has the focus
        retry_until(escape, lambda: guards["blue"].status().reason == "stop", "the stop of the chosen robot")
        assert guards["red"].status().armed
        stop_all = page.get_by_role("button", name="Emergency stop all", exact=True)
        retry_until(stop_all.click, lambda: not guards["red"].status().armed, "the stop of all")
        retry_until(stop_all.click, lambda: "red: " in page.inner_text("#toast"), "the answer of each")
        assert errors == []


def test_the_robot_of_a_recorded_world_is_chosen_in_the_page_with_its_game(
    tmp_path: Path, page: Page, errors: list[str]
) -> None:
    teams = (Team(number=5, colour="red"), Team(number=19, colour="blue"))
    calls = (
        Call(at=0.0, state="playing"),
        Call(at=0.0, goal=5),
        Call(at=0.0, team=5, player=1, penalty="player-pushing"),
    )
    record_world(tmp_path / "run", 40, Schedule(teams=teams, calls=calls, half=125.0))
    file = tmp_path / "page.html"
    file.write_text(world_page(world_recordings(tmp_path / "run"), "blue")[0])
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-ready=yes]")
    assert page.inner_text("#title") == "robot blue"
    game = page.inner_text("#game")
    assert all(word in game for word in ("playing", "0 : 1", "2:05", "red: player-pushing")), game
    assert "blue:" not in game
    page.get_by_label("robot that is shown and gets the orders").select_option("red")
    assert page.inner_text("#title") == "robot red"
    until(
        lambda: all(word in page.inner_text("#game") for word in ("1 : 0", "red: player-pushing")),
        "the game as red sees it, with the page's next picture",
    )
    ((name, torso, _),) = page.evaluate(OTHERS)
    assert name == "blue" and torso[:2] == pytest.approx(PLACES["blue"][1][:2], abs=0.05)
    assert errors == [file.as_uri()]  # no other address is asked for
