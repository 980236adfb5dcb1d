"""`nao-hil export RUN`: a recorded run as one file to share."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from bridge.errors import ConfigurationError
from bridge.recording.playback import recorded_config
from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.files import write_text


def export_run(
    recordings: options.Recordings,
    page: Annotated[
        Path | None,
        typer.Option("--html", help="Write a page that any browser plays from the disk.", metavar="FILE"),
    ] = None,
    video: Annotated[
        Path | None,
        typer.Option("--video", help="Write a video (.webm); Chromium draws it.", metavar="FILE"),
    ] = None,
    begin: options.Begin = 0.0,
    end: options.End = None,
    speed: Annotated[
        float, typer.Option("--speed", help="Of the video: robot time per second.", min=0.01, max=100.0)
    ] = 1.0,
    as_json: options.Json = False,
) -> int:
    """Write a recorded run as one file: robot, charts, events. The page has a timeline and slow motion.

    Of two recordings the page has two robots side by side, and their charts over each other.

    --from, --to and --speed are the video's; the page always has the whole run.

    Example: nao-hil export runs/20260101T120000Z --html walk.html

    Example: nao-hil export walk.mcap --video fall.webm --from 10 --to 14 --speed 0.25
    """
    if page is None and video is None:
        raise ConfigurationError("Say what to write: --html FILE, --video FILE, or both.")
    if video is not None and video.suffix != ".webm":
        raise ConfigurationError(
            f"{video}: the video is a .webm; `ffmpeg -i run.webm run.mp4` makes another format of it."
        )
    if page is not None and page.suffix not in (".html", ".htm"):
        raise ConfigurationError(f"{page}: the page is an .html file; give it such a name.")
    if video is None and (begin, end, speed) != (0.0, None, 1.0):
        raise ConfigurationError(
            "--from, --to and --speed are the video's, the page has the whole run; give --video FILE, or leave "
            "them out."
        )
    options.check_stretch(begin, end)
    for file in (page, video):
        if file is not None and not file.parent.is_dir():
            raise ConfigurationError(f"{file}: there is no folder {file.parent}; give another place.")
    written: dict[str, Path] = {}
    if page is not None:
        from nao_hil.view.page import recorded_page

        write_text(page, recorded_page(recordings)[0])
        written["html"] = page
    if video is not None:
        from nao_hil.view.video import write_video

        write_video(recordings[0], video, begin, end, speed)
        written["video"] = video
    for file in written.values():
        size = 1e-6 * file.stat().st_size
        open_console().print(f"written to {file}, {size:.1f} MB", highlight=False, soft_wrap=True)
    if as_json:
        files = {kind: {"file": str(file), "bytes": file.stat().st_size} for kind, file in written.items()}
        print(json.dumps({**files, "config": recorded_config(recordings[0])}), flush=True)
    return 0
