"""Buttons that give a recording to the browser, also one that is still being written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from bridge.errors import NaoHilError
from nao_hil.view.export.page import exported_page


def add_downloads(
    gui: Any,
    newest: Callable[[], Path],
    say: Callable[[str], None],
    before_reset: Callable[[], Path] | None = None,
) -> None:
    """Add them.

    Args:
        gui: `viser.ViserServer.gui`.
        newest: The recording; asked when a button is pressed.
        say: Told why there is none.
        before_reset: The recording that ended with the last reset; None: no button for it.
    """

    def give(
        event: Any, name: str, content: Callable[[Path], bytes], which: Callable[[], Path] = newest
    ) -> None:
        try:
            file = which()
            event.client.send_file_download(name.format(file.stem), content(file), save_immediately=True)
        except (NaoHilError, OSError) as error:
            say(f"There is no recording yet: {error}")

    recording = gui.add_button("Download the recording", hint="MCAP: for Foxglove, PlotJuggler and nao-hil")
    page = gui.add_button("Download as a page", hint="one file that plays in any browser, from the disk")
    if before_reset is not None:
        before = gui.add_button("Recording before the reset", hint="MCAP of what ended with the last reset")
        before.on_click(lambda event: give(event, "{}.mcap", Path.read_bytes, before_reset))
    recording.on_click(lambda event: give(event, "{}.mcap", Path.read_bytes))
    page.on_click(lambda event: give(event, "{}.html", lambda file: exported_page(file).encode()))


def latest_recording(folder: Path, resets: int = 0) -> Path:
    """The recording of a run that was begun last, or so many resets before. Raises OSError without one."""
    files = sorted(folder.glob("frames*.mcap"), key=lambda file: file.stat().st_mtime)
    if len(files) <= resets:
        raise FileNotFoundError(f"{folder} has none" if not files else "the run was not reset")
    return files[-1 - resets]
