"""The live page in a headless browser: `make browser-test`, which needs Chromium on the machine."""

from __future__ import annotations

import math
import re
import shutil
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest
from playwright.sync_api import Locator, Page, sync_playwright

from bridge.body import load_body
from bridge.recording.playback import read_recording
from bridge.recording.recorder import Recorder
from emulator.robot import EmulatedRobot
from nao_hil.drive.driver import SPEED_STEPS
from nao_hil.runs.config import RunConfig
from nao_hil.view.server import open_server
from tests.loops import until
from tests.ports import free_endpoint
from tests.proxy import proxy
from walker.planning import gait_parameters

Start = Callable[..., Any]

TIMEOUT = 120_000
"""ms: a browser that draws in software beside a robot on two cores takes its time."""
SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
COARSE = "?fixedDpr=0.5"
"""Of an address: viser draws a quarter of the pixels, for a browser without a graphics card."""
STOPS = 200
"""Cycles from Stop to a stand: `omni` slows down over some steps of 0.25 s."""
CHART = ".uplot canvas"
OWN = ("http://127.0.0.1:", "blob:http://127.0.0.1:", "data:")
"""Beginnings of addresses that the page may ask for."""

pytestmark = pytest.mark.browser


@pytest.fixture
def errors() -> list[str]:
    """What the page complained of."""
    return []


@pytest.fixture
def browser_page(errors: list[str]) -> Iterator[Page]:
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    assert chromium, "these tests need Chromium: apt-get install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=list(SOFTWARE))
        page = browser.new_page(viewport={"width": 900, "height": 700})
        page.set_default_timeout(TIMEOUT)
        page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("request", lambda r: None if r.url.startswith(OWN) else errors.append(r.url))
        yield page
        browser.close()


def open_page(page: Page, port: int, query: str = COARSE) -> None:
    """Open it, wait until the charts are drawn, and until the 3-D picture has a robot in it."""
    page.goto(f"http://127.0.0.1:{port}/{query}")
    page.wait_for_selector(CHART)
    wait_for(page, "no robot was drawn", lambda: drawn(page) > 300)


def picture(page: Page) -> np.ndarray[Any, Any]:
    """The 3-D picture, shape (height, width, 3)."""
    return np.asarray(iio.imread(page.locator("canvas").first.screenshot()))[:, :, :3].astype(int)


def drawn(page: Page) -> int:
    """Pixels as white as the robot's body, beside the dark of the background and the green of the ghost."""
    image = picture(page)
    return int(((image.min(axis=2) > 120) & (np.ptp(image, axis=2) < 40)).sum())


def wait_for(page: Page, what: str, true: Callable[[], bool]) -> None:
    """Wait until something is true: a browser beside other work may draw the page every few seconds."""
    for _ in range(60):
        if true():
            return
        page.wait_for_timeout(1000)
    pytest.fail(f"in a minute {what}")


def moved(now: np.ndarray[Any, Any], before: np.ndarray[Any, Any]) -> bool:
    """Whether a picture is another one."""
    return bool((np.abs(now - before).max(axis=2) > 40).sum() > 100)


def charts(page: Page) -> str:
    """The picture of the first chart."""
    picture: str = page.locator(CHART).first.evaluate("(canvas) => canvas.toDataURL()")
    return picture


def shown_time(page: Page) -> float:
    """Robot time in the headline, s."""
    found = re.search(r"· ([\d.]+) s", page.inner_text("body"))
    return float(found[1]) if found else math.nan


def press(page: Page, tab: str, button: str) -> None:
    page.get_by_role("tab", name=tab).click()
    page.get_by_role("button", name=button, exact=True).click()


@pytest.mark.realtime
def test_the_page_shows_a_walk_and_its_push_button_moves_the_robot(
    start: Start, endpoint: str, port: int, tmp_path: Path, browser_page: Page, errors: list[str]
) -> None:
    run = tmp_path / "run"
    up = ["up", "--gait", "static", "--serve", "--view", "--port", str(port), "--json"]
    up += ["--listen", endpoint, "--out", str(run)]
    command = start(*up)
    wait_for_server(browser_page, port)
    open_page(browser_page, port)

    press(browser_page, "World", "Push")
    browser_page.wait_for_function("document.body.innerText.includes('is pushed with')")
    browser_page.wait_for_timeout(2000)

    browser_page.get_by_role("button", name="Walk", exact=True).click()
    browser_page.get_by_role("tab", name="Charts").click()
    browser_page.wait_for_function("document.body.innerText.includes('SSL')")
    browser_page.wait_for_selector(CHART)
    before, curves, time = picture(browser_page), charts(browser_page), shown_time(browser_page)
    wait_for(browser_page, "the robot did not move", lambda: moved(picture(browser_page), before))
    wait_for(browser_page, "the chart stood still", lambda: charts(browser_page) != curves)
    assert shown_time(browser_page) > time

    browser_page.get_by_role("tab", name="Walk").click()
    stops = browser_page.get_by_role("button", name="Emergency stop").bounding_box()
    browser_page.get_by_role("button", name="Let go").scroll_into_view_if_needed()
    check_in_sight(browser_page, "Walk", "Stop")
    browser_page.get_by_role("button", name="Stop", exact=True).click()  # of a walk that no key began
    browser_page.wait_for_function("document.body.innerText.includes('Closes the feet')")
    browser_page.get_by_role("button", name="Emergency stop").click()
    browser_page.get_by_role("button", name="Arm").click()
    browser_page.get_by_role("button", name="Walk", exact=True).wait_for()
    assert browser_page.get_by_role("button", name="Arm").count() == 0
    stays = browser_page.get_by_role("button", name="Emergency stop").bounding_box()
    assert stays and stops and stays["x"] == stops["x"]
    assert abs(stays["y"] - stops["y"]) < 12.0  # but for the panel's margin, which scrolls away
    assert errors == []
    command.interrupt()
    browser_page.wait_for_function("document.body.innerText.includes('The page has ended')")

    recorded = list(read_recording(run / "frames.mcap"))
    (pushed,) = [r.time for r in recorded if r.topic == "notices" and "is pushed" in r.message.text]
    angles = [(r.time, r.message.angle[0]) for r in recorded if r.topic == "sensors"]
    calm = max(abs(a) for t, a in angles if pushed - 1.0 < t < pushed)
    tilted = max(abs(a) for t, a in angles if pushed < t < pushed + 1.0)
    assert tilted > calm + math.radians(0.5)


@pytest.mark.realtime
def test_keys_and_a_gamepad_drive_once_they_may(
    start: Start, endpoint: str, port: int, tmp_path: Path, browser_page: Page, errors: list[str]
) -> None:
    run = tmp_path / "run"
    up = ["up", "--gait", "static", "--serve", "--view", "--port", str(port), "--json"]
    up += ["--listen", endpoint, "--out", str(run)]
    command = start(*up)
    browser_page.add_init_script(
        "window.pad = {buttons: [{pressed: false}], axes: [0, 0]}; navigator.getGamepads = () => [window.pad]"
    )
    wait_for_server(browser_page, port)
    open_page(browser_page, port)
    browser_page.wait_for_function("document.body.innerText.includes('· stand')")
    browser_page.keyboard.press("w")
    browser_page.get_by_role("tab", name="Walk").click()
    browser_page.get_by_label("keys, gamepad").check()
    browser_page.wait_for_selector(".keys-drive")
    assert "Walks by" not in browser_page.inner_text("body")  # of the key before

    step = gait_parameters("static").periodic_step.velocity / SPEED_STEPS
    browser_page.keyboard.press("w")
    browser_page.wait_for_function(f"document.body.innerText.includes('gait at {step:.3f} m/s')")
    browser_page.evaluate("window.pad.axes[1] = -1")
    speed = "parseFloat((document.body.innerText.match(/gait at ([\\d.]+) m/) || [0, 0])[1])"
    browser_page.wait_for_function(f"{speed} > {1.5 * step}")
    browser_page.evaluate("window.pad.axes[1] = 0")
    browser_page.keyboard.press("Space")
    browser_page.wait_for_function("document.body.innerText.includes('Closes the feet')")
    assert errors == []
    command.interrupt()


def wait_for_server(page: Page, port: int) -> None:
    for _ in range(120):
        try:
            socket.create_connection(("127.0.0.1", port), 1.0).close()
            return
        except OSError:
            page.wait_for_timeout(500)
    pytest.fail("the page was never served")


def test_a_recorded_fall_is_explained_on_the_page(
    start: Start, port: int, tmp_path: Path, browser_page: Page, errors: list[str]
) -> None:
    scenario = tmp_path / "push.toml"
    scenario.write_text("[[pushes]]\ntime = 2.0\nimpulse = 5.0\ndirection = 90.0\n")
    run = tmp_path / "run"
    walk = [
        "up",
        "--gait",
        "static",
        "--mode",
        "lockstep",
        "--scenario",
        str(scenario),
        "--listen",
        free_endpoint(),
    ]
    assert start(*walk, "--out", str(run), "--json").wait() == 1
    start("view", "--replay", str(run / "frames.mcap"), "--port", str(port))
    wait_for_server(browser_page, port)
    open_page(browser_page, port, f"{COARSE}&t=1.5")
    browser_page.wait_for_function("document.body.innerText.includes('· 1.5 s')")
    browser_page.get_by_role("button", name="Play", exact=True).wait_for()

    press(browser_page, "Timeline", "To what went wrong first")
    browser_page.wait_for_function("!document.body.innerText.includes('· 1.5 s')")
    browser_page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    browser_page.get_by_role("button", name="Copy a link to this moment").click()
    browser_page.get_by_role("button", name="Copied").wait_for()
    linked = browser_page.evaluate("navigator.clipboard.readText()")
    address, _, time = linked.partition("&t=")
    assert address == f"http://127.0.0.1:{port}/{COARSE}"
    assert float(time) == pytest.approx(shown_time(browser_page), abs=0.06)  # the headline has tenths
    assert browser_page.url == linked
    with browser_page.expect_download() as download:
        browser_page.get_by_role("button", name="Download the recording").click()
    assert Path(download.value.path()).read_bytes() == (run / "frames.mcap").read_bytes()
    browser_page.get_by_role("tab", name="Charts").click()
    browser_page.wait_for_function("document.body.innerText.includes('What went wrong first')")
    assert "is pushed with 5 N s" in browser_page.inner_text("body")
    check_zoom(browser_page)
    browser_page.get_by_role("button", name="Play", exact=True).click()
    time = shown_time(browser_page)
    browser_page.wait_for_function(f"parseFloat(document.body.innerText.match(/· ([\\d.]+) s/)[1]) > {time}")
    assert errors == []


def check_zoom(page: Page) -> None:
    """A chart marks what went wrong, tells the values under the pointer, and dragging goes nearer."""
    image = np.asarray(iio.imread(page.locator(CHART).first.screenshot()))[:, :, :3].astype(int)
    assert ((image[:, :, 0] > 200) & (image[:, :, 1:] < 110).all(axis=2)).sum() > 30  # a red line
    box = page.locator(CHART).first.bounding_box()
    assert box is not None
    y = box["y"] + 0.5 * box["height"]

    def seconds(share: float) -> float:
        """Under the pointer."""
        page.mouse.move(box["x"] + share * box["width"], y)
        value = page.locator(".u-legend .u-value").first
        page.wait_for_timeout(300)
        return float(value.inner_text())

    before = seconds(0.8) - seconds(0.4)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], y, steps=4)
    page.mouse.up()
    assert 0.0 < seconds(0.8) - seconds(0.4) < 0.6 * before


def test_the_page_fits_a_phone_and_is_shared_with_nobody(
    start: Start, port: int, tmp_path: Path, browser_page: Page, errors: list[str]
) -> None:
    file = tmp_path / "frames.mcap"
    with EmulatedRobot(load_body("nao-v3"), seed=0) as robot, Recorder(file, RunConfig()) as recorder:
        for _ in range(20):
            recorder.sensors(robot.frame, robot.truth())
            robot.advance(None)
    start("view", "--replay", str(file), "--port", str(port))
    wait_for_server(browser_page, port)
    for width in (420, 900):
        browser_page.set_viewport_size({"width": width, "height": 800})
        browser_page.goto(f"http://127.0.0.1:{port}/")
        browser_page.wait_for_selector(CHART)
        assert browser_page.locator("button:has(.tabler-icon-share)").count() == 0
    assert errors == []


FIELD = """
const follows = (pad, input) => pad.compareDocumentPosition(input) & Node.DOCUMENT_POSITION_FOLLOWING;
const field = (pad) => [...document.querySelectorAll("input")].find((input) => follows(pad, input));
"""
TYPE = f"""(pad, text) => {{
  {FIELD}
  Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(field(pad), text);
  field(pad).dispatchEvent(new Event("input", {{ bubbles: true }}));
}}"""


def typed(page: Page) -> list[float]:
    """The numbers of the pad that is shown."""
    text: str = page.locator(".nao-pad:visible").evaluate(f"(pad) => {{ {FIELD} return field(pad).value }}")
    return [float(word) for word in text.split()]


def drag(page: Page, part: str, right: float, down: float) -> None:
    """From the middle of a pad to a place of it, in shares of its size."""
    shown = page.locator(f"{part}:visible")  # a tab that was left stays in the document, hidden
    shown.hover()  # waits until it is in sight and has stopped moving: its tab has just been opened
    box = shown.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + right * box["width"], box["y"] + down * box["height"], steps=4)
    page.mouse.up()
    page.wait_for_timeout(500)


IN_SIGHT = """
(element) => {
  const { left, top, width, height } = element.getBoundingClientRect();
  const there = document.elementFromPoint(left + width / 2, top + height / 2);
  return element.contains(there) || element === there;
}
"""


def check_in_sight(page: Page, *buttons: str) -> None:
    """What must never be covered: the emergency stop, these buttons, and the tabs."""
    for name in ("Emergency stop", *buttons):
        wait_until_in_sight(page.get_by_role("button", name=name, exact=True), name)
    for tab in page.get_by_role("tab").all():
        wait_until_in_sight(tab, tab.inner_text())


def wait_until_in_sight(shown: Locator, name: str) -> None:
    """The page's script pins rows three times a second."""
    for _ in range(30):
        if shown.evaluate(IN_SIGHT):
            return
        shown.page.wait_for_timeout(100)
    pytest.fail(f"{name} is covered")


@pytest.mark.realtime
@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
def test_walk_stop_push_fall_reset_and_walk_again(
    start: Start,
    endpoint: str,
    port: int,
    tmp_path: Path,
    browser_page: Page,
    errors: list[str],
    width: int,
    height: int,
) -> None:
    run = tmp_path / "run"
    up = ["up", "--serve", "--view", "--gait", "omni", "--port", str(port), "--listen", endpoint]
    start(*up, "--out", str(run))
    page = browser_page
    page.set_viewport_size({"width": width, "height": height})
    wait_for_server(page, port)
    open_page(page, port)
    page.wait_for_function("document.body.innerText.includes('· stand')")
    for notice in page.locator(".mantine-Notification-closeButton").all():
        notice.click()  # of the browser's missing graphics card
    check_in_sight(page, "Walk", "Stop")
    feet = picture(page)[: int(0.5 * height)] if width < 720 else picture(page)
    green = (feet[:, :, 1] > feet[:, :, 0] + 40) & (feet[:, :, 1] > 120)
    assert green.sum() > 50  # the bars on the feet

    page.get_by_role("button", name="Walk", exact=True).click()
    page.wait_for_function("/step ([3-9]|[1-9][0-9])/.test(document.body.innerText)")
    check_in_sight(page, "Walk", "Stop")
    page.get_by_role("button", name="Stop", exact=True).click()
    page.wait_for_function("document.body.innerText.includes('Closes the feet')")
    page.wait_for_function("document.body.innerText.includes('· stand')")

    page.get_by_role("tab", name="Walk").click()
    drag(page, ".nao-square", 0.5, 0.1)
    page.wait_for_function("/step [1-9]/.test(document.body.innerText)")
    drag(page, ".nao-strip", 0.1, 0.5)
    assert typed(page) == pytest.approx([0.8 * 0.35, 0.0, 0.8 * 1.5], abs=0.03)  # of the limits of `omni`
    page.get_by_role("button", name="Stop", exact=True).click()
    page.wait_for_function("document.body.innerText.includes('· stand')")
    for _ in range(100):  # the field hears of Stop by the server
        if typed(page) == [0.0, 0.0, 0.0]:
            break
        page.wait_for_timeout(100)
    assert typed(page) == [0.0, 0.0, 0.0]
    page.get_by_role("tab", name="Save").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Download the recording").click()
    assert sum(r.topic == "sensors" for r in read_recording(Path(download.value.path()))) > 100

    page.get_by_role("tab", name="World").click()
    page.locator(".nao-strip:visible").wait_for(state="hidden")
    page.locator(".nao-pad:visible").evaluate(TYPE, "0 5")
    page.get_by_role("button", name="Push", exact=True).click()
    page.wait_for_function("document.body.innerText.includes('It fell at')")
    check_in_sight(page, "Walk", "Stop")
    page.get_by_role("tab", name="Charts").click()
    page.get_by_role("heading", name="It fell at").wait_for()

    page.get_by_role("tab", name="World").click()
    page.get_by_role("button", name="Reset", exact=True).click()
    page.wait_for_function("document.body.innerText.includes('· stand')")
    page.get_by_role("button", name="Walk", exact=True).click()
    page.wait_for_function("/step [1-9]/.test(document.body.innerText)")
    page.get_by_role("button", name="Emergency stop").click()
    page.get_by_role("button", name="Arm").wait_for()
    check_in_sight(page, "Arm")
    assert errors == []

    told = [r.message for r in read_recording(run / "frames.mcap") if r.topic == "walk/telemetry"]
    states = [message.state for message in told]
    walking = states.index("walk")
    begun, stands = (walking + states[walking:].index(state) for state in ("stopping", "stand"))
    assert told[stands].seq - told[begun].seq <= STOPS


CONNECT = """
([address, protocol]) => new Promise((done) => {
  const socket = new WebSocket(address, [protocol]);
  socket.onopen = () => done("open");
  socket.onerror = () => done("refused");
})
"""


def test_another_site_in_the_same_browser_cannot_connect(
    start: Start, port: int, tmp_path: Path, browser_page: Page
) -> None:
    import viser

    recording = tmp_path / "frames.mcap"
    with EmulatedRobot(load_body("nao-v3"), seed=0) as robot, Recorder(recording, RunConfig()) as recorder:
        recorder.sensors(robot.frame, robot.truth())
    start("view", "--replay", str(recording), "--port", str(port))
    wait_for_server(browser_page, port)
    own = [f"ws://127.0.0.1:{port}", f"viser-v{viser.__version__}"]
    browser_page.goto(f"http://127.0.0.1:{port}/alive-not")
    assert browser_page.evaluate(CONNECT, own) == "open"  # the same words from the page's own origin
    for site in ("http://evil.example/", f"http://localhost:{port}/alive-not"):
        browser_page.route("http://evil.example/", lambda route: route.fulfill(body="<p>another site"))
        browser_page.goto(site)
        assert browser_page.evaluate(CONNECT, own) == "refused"


def test_the_page_works_under_a_path_of_a_proxy(port: int, browser_page: Page) -> None:
    server = open_server("127.0.0.1", port, "behind a proxy")
    try:
        with proxy("/nao/", port) as address, browser_page.expect_response("**/nao/alive") as alive:
            browser_page.goto(address)
            until(lambda: browser_page.wait_for_timeout(100) or server.get_clients(), "the page to connect")
        assert alive.value.status == 204
    finally:
        server.stop()
