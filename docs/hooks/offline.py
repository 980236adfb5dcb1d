"""Refuses a page that would load anything from elsewhere: fonts, scripts, styles, pictures."""

from __future__ import annotations

import re
from typing import Any

from mkdocs.exceptions import PluginError

FOREIGN = re.compile(r"<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=\"?(?:https?:)?//[^\" >]*")


def on_post_page(output: str, *, page: Any, **_: Any) -> str:
    """Look at a finished page."""
    if found := FOREIGN.search(output):
        raise PluginError(f"{page.file.src_path} would load something from elsewhere: {found[0]}")
    return output
