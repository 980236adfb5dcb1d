"""Which run a recording is of, in a line."""

from __future__ import annotations

from pathlib import Path

from bridge.recording.playback import recorded_config


def run_title(recording: str | Path) -> str:
    """Robot, wear, gait and seed, as far as they were recorded; empty when nothing was.

    Raises:
        ConfigurationError: not a recording.
    """
    config = recorded_config(recording)
    if not isinstance(config, dict):
        return ""
    words = [str(config["robot"])] if config.get("robot") else []
    words += [f"{key} {config[key]}" for key in ("wear", "gait", "seed") if config.get(key) not in (None, "")]
    return ", ".join(words)
