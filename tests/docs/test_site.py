"""The reference leaves no module out, and the navigation no page."""

from __future__ import annotations

from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]


@pytest.mark.parametrize("package", ["bridge", "emulator", "walker", "nao_hil"])
def test_every_public_module_is_in_the_reference(package: str) -> None:
    page = (REPOSITORY / "docs" / "reference" / f"{package}.md").read_text()
    assert f"::: {package}\n" in page and "show_submodules: true" in page


def test_every_page_is_in_the_navigation() -> None:
    navigation = (REPOSITORY / "mkdocs.yml").read_text()
    pages = {str(page.relative_to(REPOSITORY / "docs")) for page in (REPOSITORY / "docs").rglob("*.md")}
    assert [page for page in sorted(pages) if page not in navigation] == []
