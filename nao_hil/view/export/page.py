"""A recorded run as one HTML file that plays in any browser and asks nobody for anything."""

from __future__ import annotations

import base64
import html
import re
from pathlib import Path
from typing import Final

from nao_hil.analysis.run_title import run_title
from nao_hil.runs.folder import RECORDING
from nao_hil.view.export.contents import packed_run
from nao_hil.view.recorded_run import read_run

SCRIPTS: Final = ("scene.js", "charts.js", "video.js", "player.js")


def exported_page(recording: Path) -> str:
    """The whole file.

    Raises:
        ConfigurationError: not a recording, or an empty one.
    """
    title = recording.resolve().parent.name if recording.name == RECORDING else recording.stem
    run = packed_run(read_run(recording), title, run_title(recording))
    here = Path(__file__).parent
    fields = {
        "title": html.escape(title),
        "run": base64.b64encode(run).decode("ascii"),
        "script": "\n".join((here / name).read_text(encoding="utf-8") for name in SCRIPTS),
    }
    text = (here / "player.html").read_text(encoding="utf-8")
    return re.sub(r"@(\w+)@", lambda field: fields[field[1]], text)
