"""The reference leaves no module out, and the navigation no page."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]


def modules(package: str) -> set[str]:
    """Public modules and packages below one, but for packages that only say what is in them."""
    found = set()
    for file in (REPOSITORY / package).rglob("*.py"):
        parts = file.relative_to(REPOSITORY).with_suffix("").parts
        if parts[-1] == "__init__":
            parts = parts[:-1]
        if len(parts) > 1 and not any(part.startswith("_") for part in parts):
            found.add(".".join(parts))
    return found


@pytest.mark.parametrize("package", ["bridge", "emulator", "walker"])
def test_every_public_module_is_in_the_reference(package: str) -> None:
    pages = "".join(page.read_text() for page in (REPOSITORY / "docs" / "reference").glob("*.md"))
    listed = re.findall(rf"^::: ({package}\.\S+)$", pages, re.MULTILINE)
    assert len(listed) == len(set(listed))
    assert set(listed) == modules(package)


def test_every_page_is_in_the_navigation() -> None:
    navigation = (REPOSITORY / "mkdocs.yml").read_text()
    pages = {str(page.relative_to(REPOSITORY / "docs")) for page in (REPOSITORY / "docs").rglob("*.md")}
    assert [page for page in sorted(pages) if page not in navigation] == []
