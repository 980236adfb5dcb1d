"""The pad of the page in a headless browser, without a robot: `make browser-test`, which needs Chromium."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from nao_hil.view.pad import pad_html
from playwright.sync_api import Page, sync_playwright

from nao_hil import view

pytestmark = pytest.mark.browser

BODY = '<input id="before">{pad}<input id="field" value="0 0 0" oninput="window.said = (window.said || 0) + 1">'


@pytest.fixture
def page() -> Iterator[Page]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 390, "height": 844})
        page.set_content(BODY.format(pad=pad_html((0.3, 0.12, 1.2))))
        page.add_script_tag(content=Path(view.__file__).with_name("page.js").read_text())
        yield page
        browser.close()


def drag(page: Page, part: str, right: float, down: float) -> list[float]:
    """From the middle of a part to a place of it, in shares of its size; the field's numbers then."""
    box = page.locator(part).bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + right * box["width"], box["y"] + down * box["height"], steps=3)
    page.mouse.up()
    return [float(word) for word in page.locator("#field").input_value().split()]


def test_up_is_ahead_and_left_is_left_and_the_strip_turns(page: Page) -> None:
    assert drag(page, ".nao-square", 0.5, 0.0) == pytest.approx([0.3, 0.0, 0.0], abs=0.01)
    assert drag(page, ".nao-square", 0.0, 0.5) == pytest.approx([0.0, 0.12, 0.0], abs=0.01)
    assert drag(page, ".nao-strip", 0.25, 0.5) == pytest.approx([0.0, 0.12, 0.6], abs=0.02)
    assert drag(page, ".nao-square", 0.48, 0.75) == pytest.approx([-0.15, 0.0, 0.6], abs=0.01)
    assert page.evaluate("window.said") >= 4  # the page's library hears of each
    assert page.locator("#before").input_value() == ""


def test_the_knobs_are_where_the_field_says(page: Page) -> None:
    page.locator("#field").fill("0.15 -0.12 0")
    knob = page.locator(".nao-square .nao-knob")
    page.wait_for_function("document.querySelector('.nao-square .nao-knob').style.top === '25%'")
    assert knob.evaluate("(element) => element.style.left") == "100%"
