"""An exported run in a headless browser, from the disk: `make browser-test`, which needs Chromium."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest
from playwright.sync_api import Page, sync_playwright

from bridge.messages import TruthFrame
from bridge.recording.playback import read_recording
from nao_hil.cli.main import run
from nao_hil.view.video import SOFTWARE
from tests.loops import until
from tests.system.pages import TIMEOUT

pytestmark = pytest.mark.browser

WALK = ["up", "--mode", "in-process", "--gait", "static"]
SIZES = [(1280, 800), (390, 844)]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fall of a robot that is pushed after two seconds."""
    folder = tmp_path_factory.mktemp("run")
    scenario = folder / "push.toml"
    scenario.write_text("[[pushes]]\ntime = 2.0\nimpulse = 5.0\ndirection = 90.0\n")
    assert run([*WALK, "--scenario", str(scenario), "--out", str(folder / "walk")]) == 1
    return folder / "walk"


@pytest.fixture(scope="module")
def exported(recording: Path) -> Path:
    file = recording / "walk.html"
    assert run(["export", str(recording), "--html", str(file)]) == 0
    return file


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(SOFTWARE))
        yield browser
        browser.close()


@pytest.fixture
def complaints() -> list[str]:
    return []


def blank_page(chromium: Any, complaints: list[str], width: int = 1280, height: int = 800) -> Page:
    """A page; what it complains of comes into `complaints`."""
    page: Page = chromium.new_page(viewport={"width": width, "height": height})
    page.set_default_timeout(TIMEOUT)
    page.on("console", lambda m: complaints.append(m.text) if m.type in ("error", "warning") else None)
    return page


@pytest.fixture
def open_run(chromium: Any, exported: Path, complaints: list[str]) -> Iterator[Callable[..., Page]]:
    pages = []

    def begin(width: int, height: int, moment: str = "") -> Page:
        page = blank_page(chromium, complaints, width, height)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on(
            "request", lambda r: complaints.append(r.url) if not r.url.startswith(("file:", "data:")) else None
        )
        page.goto(f"file://{exported}{moment}")
        page.wait_for_selector("body[data-ready=yes]")
        pages.append(page)
        return page

    yield begin
    for page in pages:
        page.close()


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_an_exported_run_plays_from_the_disk(
    open_run: Callable[..., Page], complaints: list[str], width: int, height: int
) -> None:
    page = open_run(width, height)
    until(lambda: page.evaluate("player.time > player.first"), "it to play by itself")
    page.get_by_label("speed").select_option("0.1")
    page.evaluate("player.goTo(player.first)")  # however far it has come: it is not over before it is paused
    page.get_by_role("button", name="Play").click()
    page.get_by_role("button", name="Pause").click()
    still = page.evaluate("player.time")
    page.wait_for_timeout(200)
    assert page.evaluate("player.time") == still
    page.get_by_role("button", name="Play").click()
    until(lambda: page.evaluate("player.time") > still, "it to play")
    page.keyboard.press("Space")
    page.get_by_role("button", name="Play").wait_for()
    assert complaints == []


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_a_linked_moment_shows_where_the_robot_was(
    open_run: Callable[..., Page], recording: Path, complaints: list[str], width: int, height: int
) -> None:
    truth = [r.message for r in read_recording(recording / "frames.mcap") if isinstance(r.message, TruthFrame)]
    fell = next(frame for frame in truth if frame.fell)
    page = open_run(width, height, f"#t={fell.time + 0.02:.2f}")
    shown = page.evaluate(f"player.runs[0].moment({fell.time}).position.slice(0, 3)")
    np.testing.assert_allclose(shown, fell.torso_position, atol=2e-3)
    until(lambda: "It fell at" in page.inner_text("#fell"), "the verdict")
    first = page.inner_text("#fell").split("What went wrong first: ")[1].split(". ")[0]
    page.get_by_role("tab", name="Events").click()
    events = page.inner_text("#events")
    assert all(part in events for part in first.split(", then "))
    assert "is pushed with 5 N s" in page.inner_text("#events")
    robot, controls = page.locator("#scene").bounding_box(), page.locator("footer").bounding_box()
    assert robot and controls and robot["height"] > 0.45 * height
    assert controls["y"] >= robot["y"] + robot["height"] - 1.0  # the controls do not cover the robot
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert complaints == []


def test_two_runs_are_shown_side_by_side_with_their_charts_over_each_other(
    chromium: Any, recording: Path, tmp_path: Path, complaints: list[str]
) -> None:
    file = tmp_path / "two.html"
    assert run(["export", str(recording), str(recording), "--html", str(file)]) == 0
    page = blank_page(chromium, complaints)
    page.goto(f"file://{file}#t=1.0")
    page.wait_for_selector("body[data-ready=yes]")
    first, second = page.evaluate("player.actors().map(({moment, shift}) => moment.position[1] + shift[1])")
    assert first - second == pytest.approx(0.6)
    until(lambda: page.locator("#labels span").count() == 2, "the names of both")
    until(lambda: "/" in page.locator(".chart").first.inner_text(), "values of both")
    page.get_by_role("tab", name="Differences").click()
    assert "The configurations are the same." in page.inner_text("section[data-name=Differences]")
    assert page.locator("section[data-name=Differences] li").count() == 0
    assert complaints == []
    page.close()


def test_two_runs_that_differ_name_it_and_draw_the_difference_up_to_the_fall(
    chromium: Any, recording: Path, tmp_path: Path, complaints: list[str]
) -> None:
    other, file = tmp_path / "other", tmp_path / "two.html"
    assert run([*WALK, "--seed", "1", "--torso", "thesis", "--duration", "3", "--out", str(other)]) == 0
    assert run(["export", str(recording), str(other), "--html", str(file)]) == 0
    page = blank_page(chromium, complaints)
    page.goto(f"file://{file}#t=1.5")
    page.wait_for_selector("body[data-ready=yes]")
    until(lambda: page.locator(".less").first.inner_text().startswith("second less first"), "the difference")
    by_page, by_hand = page.evaluate(
        "(() => { const [a, b] = player.runs, d = player.difference, t = 1.5, k = a.signal['torso pitch'];"
        "return [d.value(d.row(t), k), b.value(b.row(t), k) - a.value(a.row(t), k)] })()"
    )
    assert by_page == pytest.approx(by_hand, abs=1e-3)
    end = page.evaluate("player.difference.time(player.difference.count - 1)")
    assert end == pytest.approx(page.evaluate("player.runs[0].header.fall.time"), abs=0.03)
    page.get_by_role("tab", name="Differences").click()
    shown = page.inner_text("section[data-name=Differences]")
    assert "seed\t0\t1" in shown and "controller.switches.torso\trobust\tthesis" in shown
    assert "Only in walk" in shown and "is pushed with 5 N s" in shown
    assert complaints == []
    page.close()


def test_any_signal_gets_a_chart_and_the_estimate_is_off_until_it_is_wanted(
    open_run: Callable[..., Page], complaints: list[str]
) -> None:
    page = open_run(1280, 800, "#t=1.0")
    assert not page.evaluate("player.overlays.estimate") and page.locator("#labels span").count() == 0
    page.get_by_role("button", name="Legend").click()
    page.get_by_label("estimated pose").check()
    page.get_by_text("estimated pose", exact=True).first.wait_for()
    apart = page.evaluate(
        "(() => { const [{run, moment}] = player.actors(), e = run.estimate(moment);"
        "return Math.max(...e.position.map((x, i) => Math.abs(x - moment.position[i]))) })()"
    )
    assert apart < 0.02  # it stands: the outline is at the robot's place
    charts = page.locator(".chart").count()
    page.get_by_label("chart of another signal").select_option("current LKneePitch")
    assert page.locator(".chart").count() == charts + 1
    assert complaints == []


SEEK = """
(to) => new Promise((done, failed) => {
  const video = document.querySelector("video");
  const seek = () => { video.onseeked = done; video.currentTime = to; };
  video.onerror = () => failed(video.error);
  if (video.readyState > 0) seek(); else video.onloadedmetadata = seek;
})
"""


def test_a_video_lasts_as_long_as_its_stretch_and_can_be_wound(
    start: Callable[..., Any], chromium: Any, recording: Path
) -> None:
    file = recording / "fall.webm"
    stretch = ["--from", "1.9", "--to", "2.4", "--speed", "0.5"]
    assert start("export", str(recording), "--video", str(file), *stretch).wait() == 0
    (recording / "video.html").write_text('<video src="fall.webm" muted>')
    page = blank_page(chromium, [])
    page.goto(f"file://{recording / 'video.html'}")

    def picture() -> Any:
        return iio.imread(page.locator("video").screenshot())[:, :, :3].astype(int)

    page.evaluate(SEEK, 0.9)
    tipped = picture()
    page.evaluate(SEEK, 0.1)
    # the player may show a picture some time after it has found it
    until(lambda: (np.abs(picture() - tipped).max(axis=2) > 40).sum() > 5000, "the robot before it has tipped")
    last = "(([v]) => [v.duration, v.videoWidth, v.videoHeight])(document.querySelectorAll('video'))"
    assert page.evaluate(last) == pytest.approx([1.0, 1280, 720], abs=0.02)
    page.close()
