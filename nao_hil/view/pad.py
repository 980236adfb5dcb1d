"""A pad to drag in all directions, and a strip for a turn: `page.js` writes their numbers into a field."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

from nao_hil.view.scene.lines import show

SIDE: Final = 132
"""Of the pad, pixels."""
STYLE: Final = (
    "position:relative;margin:4px auto;background:#8882;border:1px solid #8888;touch-action:none;cursor:move"
)
CROSS: Final = (
    '<i style="position:absolute;left:50%;top:0;bottom:0;border-left:1px solid #8886"></i>'
    '<i style="position:absolute;top:50%;left:0;right:0;border-top:1px solid #8886"></i>'
)
KNOB: Final = (
    '<b class="nao-knob" style="position:absolute;left:50%;top:50%;width:18px;height:18px;margin:-9px;'
    'border-radius:50%;background:#339af0;pointer-events:none"></b>'
)
WORD: Final = (
    '<span style="position:absolute;left:4px;right:4px;top:{top}px;text-align:{side};font-size:10px;'
    'opacity:0.7;pointer-events:none">{text}</span>'
)
AHEAD: Final = WORD.format(top=3, side="center", text="ahead")
TURN: Final = WORD.format(top=5, side="left", text="turn")


class Pad:
    """Numbers in a field, set by dragging or by typing.

    Args:
        gui: `viser.ViserServer.gui`.
        label: Of the field.
        most: Where the edges of the pad are: ahead, to the left; and at the end of the strip, if there is one.
        initial: Numbers at first.
        hint: What the numbers are.
        act: Told of each new triple or pair that a person set.
    """

    def __init__(
        self,
        gui: Any,
        label: str,
        most: Sequence[float],
        initial: Sequence[float],
        hint: str,
        act: Callable[[tuple[float, ...]], None],
    ) -> None:
        self._numbers, self._act = tuple(initial), act
        self._html = gui.add_html(pad_html(most))
        self._field = gui.add_text(label, initial_value=_text(initial), hint=hint)
        self._field.on_update(self._changed)

    @property
    def numbers(self) -> tuple[float, ...]:
        """The newest complete ones."""
        return self._numbers

    def show(self, visible: bool) -> None:
        """Show pad and field, or hide them."""
        for handle in (self._html, self._field):
            show(handle, visible)

    def reset(self) -> None:
        """Back to zeros, without a word to whoever is told."""
        self._numbers = (0.0,) * len(self._numbers)
        self._field.value = _text(self._numbers)

    def _changed(self, event: Any) -> None:
        if event.client is None:  # by `reset`
            return
        try:
            numbers = tuple(float(word) for word in self._field.value.replace(",", " ").split())
        except ValueError:
            return  # still being typed
        if len(numbers) == len(self._numbers) and all(abs(number) < 1e3 for number in numbers):
            self._numbers = numbers
            self._act(numbers)


def pad_html(most: Sequence[float]) -> str:
    """The pad as HTML.

    Args:
        most: As of `Pad`.
    """
    limits = " ".join(f"{value:g}" for value in most)
    place = f"{STYLE};width:{SIDE}px"
    square = f'<div class="nao-square" style="{place};height:{SIDE}px">{CROSS}{AHEAD}{KNOB}</div>'
    strip = f'<div class="nao-strip" style="{place};height:26px">{CROSS}{TURN}{KNOB}</div>'
    return f'<div class="nao-pad" data-most="{limits}">{square}{strip if len(most) > 2 else ""}</div>'


def _text(numbers: Sequence[float]) -> str:
    return " ".join(f"{number:.2f}" for number in numbers)
