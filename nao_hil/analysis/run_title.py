"""Which run a recording is of, in a line."""

from __future__ import annotations

from pathlib import Path

from nao_hil.runs.run import Run


def run_title(run: Run) -> str:
    """Robot, wear, gait and seed, as far as they are recorded; empty when none is."""
    words = []
    for key in ("robot", "wear", "gait", "seed"):
        if run.config.get(key) not in (None, ""):
            name = Path(str(run.config[key])).name  # of a file without its folder
            words.append(name if key == "robot" else f"{key} {name}")
    return ", ".join(words)
