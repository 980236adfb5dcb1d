"""Lets mkdocstrings up to 1.0.6 highlight signatures with pymdown-extensions from 12 on.

From 12 on `pymdownx.highlight.Highlight` wants the Markdown instance first, which mkdocstrings hands on from
1.0.7 on.
"""

from __future__ import annotations

from typing import Any

from pymdownx.highlight import Highlight

_begin = Highlight.__init__


def on_startup(**_: Any) -> None:
    """Give the instance a default: without titles of blocks, which signatures have not, it is not used."""

    def begin(self: Highlight, md: Any = None, *arguments: Any, **options: Any) -> None:
        _begin(self, md, *arguments, **options)

    Highlight.__init__ = begin
