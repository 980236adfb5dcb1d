"""The site's search from the disk, in a headless browser: `make browser-test`, which needs Chromium."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

from tests.loops import TIMEOUT

REPOSITORY = Path(__file__).parents[2]
SITE = """
INHERIT: {repository}/mkdocs.yml
docs_dir: docs
site_dir: {folder}/site
hooks: []
plugins: [search, offline]
nav: [index.md, drives.md]
"""


@pytest.mark.browser
def test_search_finds_a_page_from_the_disk(tmp_path: Path) -> None:
    shutil.copytree(REPOSITORY / "docs" / "javascripts", tmp_path / "docs" / "javascripts")
    (tmp_path / "docs" / "index.md").write_text("# Home\n\nA robot.\n")
    (tmp_path / "docs" / "drives.md").write_text("# Drives\n\nThey have backlash.\n")
    (tmp_path / "mkdocs.yml").write_text(SITE.format(repository=REPOSITORY, folder=tmp_path))
    subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--quiet"], cwd=tmp_path, check=True, timeout=TIMEOUT
    )
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page()
        page.goto((tmp_path / "site" / "index.html").as_uri())
        page.get_by_placeholder("Search").click()
        page.get_by_placeholder("Search").press_sequentially("backlash")
        page.locator(".md-search-result__item", has_text="Drives").first.wait_for()
        browser.close()
