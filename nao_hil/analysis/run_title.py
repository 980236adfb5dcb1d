"""Which run a recording is of, in a line."""

from __future__ import annotations

from pathlib import Path

from bridge.recording.playback import recorded_config


def run_title(recording: str | Path) -> str:
    """Robot, wear, gait and seed, as far as they are recorded; empty when none is.

    Raises:
        ConfigurationError: not a recording.
    """
    config = recorded_config(recording)
    if not isinstance(config, dict):
        return ""
    words = []
    for key in ("robot", "wear", "gait", "seed"):
        if config.get(key) not in (None, ""):
            name = Path(str(config[key])).name  # of a file without its folder
            words.append(name if key == "robot" else f"{key} {name}")
    return ", ".join(words)
