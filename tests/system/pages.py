"""The live page in a headless browser, for tests."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from playwright.sync_api import Error, Page, sync_playwright

from nao_hil.view.video import SOFTWARE
from tests.loops import repeat_while, until

TIMEOUT = 120_000
"""ms: a browser that draws in software beside a robot on two cores takes its time."""
OWN = ("http://127.0.0.1:", "ws://127.0.0.1:", "data:")
"""Beginnings of addresses that the page may ask for."""
WATCH = """
() => {
  const parts = ["state", "fell"].map((id) => document.getElementById(id));
  const text = (part) => (part.hidden ? "" : part.textContent);
  window.states = [];
  const note = () => window.states.push([0.001 * Date.now(), player.last, parts.map(text).join(" ")]);
  const observer = new MutationObserver(note), kinds = { childList: true, characterData: true, subtree: true };
  for (const part of parts) observer.observe(part, { ...kinds, attributes: true });
}
"""


@contextmanager
def browser_page(errors: list[str]) -> Iterator[Page]:
    """An empty page; what it complains of, and addresses of others that it asks for, come into `errors`."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    assert chromium, "these tests need Chromium: apt-get install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=list(SOFTWARE))
        opened = browser.new_page(viewport={"width": 1280, "height": 800})
        opened.set_default_timeout(TIMEOUT)
        opened.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        opened.on("pageerror", lambda error: errors.append(str(error)))
        opened.on("request", lambda r: None if r.url.startswith(OWN) else errors.append(r.url))
        yield opened
        browser.close()


def open_page(page: Page, port: int) -> None:
    """Open it as soon as it is served, and wait until it shows a robot."""

    def opened() -> bool:
        try:
            page.goto(f"http://127.0.0.1:{port}/")
        except Error:
            page.wait_for_timeout(500)
            return False
        return True

    until(opened, "the page")
    page.wait_for_selector("body[data-ready=yes]")


def state(page: Page, words: str) -> None:
    """Wait until the robot's state is this."""
    until(lambda: words in page.inner_text("#state"), f"the state `{words}`")


def watch_states(page: Page) -> None:
    """Keep each state and headline of a fall that the page shows: one may be over before anybody looks."""
    page.evaluate(WATCH)


def shown_states(page: Page) -> list[tuple[float, float, str]]:
    """Those since `watch_states`: time, s since 1970; robot time up to which the page had the run, s; words."""
    return [(at, time, text) for at, time, text in page.evaluate("window.states")]


def retry_until(act: Callable[[], object], condition: Callable[[], Any], what: str) -> None:
    """Repeat an action until it has its effect: an order is lost where the page has no connection."""

    def done() -> Any:
        act()
        deadline = time.monotonic() + 10.0
        for _ in repeat_while(lambda: time.monotonic() < deadline, limit=1000):
            if value := condition():
                return value
            time.sleep(0.05)
        return None

    until(done, what)


def press(page: Page, tab: str, button: str) -> None:
    page.get_by_role("tab", name=tab).click()
    page.get_by_role("button", name=button, exact=True).click()


def velocity(page: Page) -> list[float]:
    """Numbers of the velocity's pad."""
    numbers: list[float] = page.evaluate("player.live.velocity.pad.values()")
    return numbers
