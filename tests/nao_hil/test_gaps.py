"""Gaps of a chart in a headless browser: `make browser-test`, which needs Chromium."""

from __future__ import annotations

import shutil
from io import BytesIO

import imageio.v3 as iio
import numpy as np
import pytest
from nao_hil.view.gaps import with_gaps
from playwright.sync_api import sync_playwright

from nao_hil.view.server import open_server
from tests.ports import free_port

RED = {"stroke": "#ff0000", "width": 2, "points": {"show": False}}


@pytest.mark.browser
def test_a_chart_draws_no_line_where_no_value_is_known() -> None:
    port, times = free_port(), 0.05 * np.arange(200.0)
    server = open_server("127.0.0.1", port, "chart")
    plot = server.gui.add_uplot((times, times), ({"label": "s"}, {"label": "y", **RED}), height=150)
    plot.data = with_gaps([times, np.where((times > 4.0) & (times < 6.0), np.nan, 1.0)])
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=shutil.which("chromium"), args=["--no-sandbox"]
            )
            page = browser.new_page()
            page.goto(f"http://127.0.0.1:{port}/")
            shown = page.locator(".uplot .u-over")
            page.wait_for_function("Object.values(window.__viserTestpoints?.uplots ?? {}).length")
            page.wait_for_timeout(500)
            picture = np.asarray(iio.imread(BytesIO(shown.screenshot())))[:, :, :3].astype(int)
            browser.close()
    finally:
        server.stop()
    red = (picture[:, :, 0] > 200) & (picture[:, :, 1:].max(axis=2) < 100)
    across = np.nonzero(red.any(axis=0))[0] / red.shape[1]
    assert (across < 0.35).any() and (across > 0.65).any()
    assert not ((across > 0.45) & (across < 0.55)).any()
