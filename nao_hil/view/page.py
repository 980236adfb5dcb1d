"""The page as HTML: one text for the live page, a replay and an exported file."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from bridge.link.session import in_order
from nao_hil.runs.folder import RECORDING, run_name

SCRIPTS: Final = ("scene.js", "charts.js", "run.js", "compare.js", "live.js", "video.js", "player.js")
WEB: Final = Path(__file__).parent / "web"


def page(
    title: str, runs: Sequence[bytes] = (), differences: Mapping[str, Sequence[Any]] | None = None
) -> tuple[str, str]:
    """The page, and the Content-Security-Policy under which it works.

    Args:
        title: Of the browser's tab.
        runs: Packed runs that it holds; none: it asks its server for a live one.
        differences: Of two runs' configurations, both values by name.
    """
    script = "\n".join((WEB / name).read_text(encoding="utf-8") for name in SCRIPTS)
    digest = base64.b64encode(hashlib.sha256(f"\n{script}\n".encode()).digest()).decode()
    policy = (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; "
        "img-src data:; connect-src 'self'"
    )
    texts = (base64.b64encode(run).decode() for run in runs)
    data = "\n".join(f'<script type="application/octet-stream">{text}</script>' for text in texts)
    differing = json.dumps(differences or {}).replace("<", "\\u003c")  # ends no script
    fields = {"title": html.escape(title), "policy": policy, "runs": data, "differences": differing}
    fields["script"] = script
    text = (WEB / "page.html").read_text(encoding="utf-8")
    return re.sub(r"@(\w+)@", lambda field: fields[field[1]], text), policy


def world_recordings(folder: Path) -> dict[str, Path]:
    """Recordings of the robots of a world by their names, where the folder of its run holds such."""
    names = in_order(file.parent.name for file in folder.glob(f"*/{RECORDING}"))
    return {name: folder / name / RECORDING for name in names}


def world_page(recordings: Mapping[str, Path], chosen: str) -> tuple[str, str]:
    """The page of the recorded robots of one world, and its policy.

    Args:
        recordings: By the robots' names.
        chosen: Name of the robot that is shown first; one that is not there: the first of them.

    Raises:
        ConfigurationError: not a recording, or an empty one.
    """
    from nao_hil.runs.run import load
    from nao_hil.view.recorded_run import TruthTrack, recorded_rows
    from nao_hil.view.surroundings import recorded_world

    runs = {name: load(file) for name, file in recordings.items()}
    tracks = {name: TruthTrack(run) for name, run in runs.items()}
    packed = []
    for name in sorted(runs, key=lambda name: name != chosen):
        others = {other: track for other, track in tracks.items() if other != name}
        world = recorded_world(recordings[name])
        packed.append(recorded_rows(runs[name], f"robot {name}", world, others, name=name, names=list(runs)))
    return page(next(iter(recordings.values())).resolve().parents[1].name, packed)


def recorded_page(recordings: Sequence[Path]) -> tuple[str, str]:
    """The page of one recording or of several side by side, and its policy.

    Raises:
        ConfigurationError: not a recording, or an empty one.
    """
    # imported late: the analysis takes time, and the live page is served before
    from nao_hil.analysis.differences import config_differences
    from nao_hil.runs.run import load
    from nao_hil.view.recorded_run import recorded_rows
    from nao_hil.view.surroundings import recorded_world

    titles = list(map(run_name, recordings))
    runs = [
        recorded_rows(load(file), title, recorded_world(file))
        for file, title in zip(recordings, titles, strict=True)
    ]
    differences = config_differences(*recordings) if len(recordings) == 2 else None
    return page(" · ".join(titles), runs, differences)
