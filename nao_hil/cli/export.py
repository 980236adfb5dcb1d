"""`nao-hil export`: a recorded run as one file, or the calibrated robot for other simulators."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from bridge.errors import ConfigurationError
from bridge.recording.playback import recorded_config
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console
from nao_hil.files import write_text

File = Annotated[Path, typer.Option("--out", help="File to write.", metavar="FILE")]
NOTICE = """
{body} with {wear} drives, exported by nao-hil {version}.
Copyright the authors of nao-hil. Licensed under the Apache License, Version 2.0:
https://www.apache.org/licenses/LICENSE-2.0
SI units and radians. Which numbers are published and which are assumed is in the project's data sheet of the
body and in its wear profile.
"""


def mjcf(out: File, robot: options.Body = None, wear: options.Wear = None) -> Answer:
    """Write the robot as a MuJoCo model: drives with backlash, delay, rotor inertia and friction, soft soles.

    It loads in MuJoCo 3.7 or later without this project (docs/how-to/export.md).

    Example: nao-hil export mjcf --robot nao-v6 --wear worn --out nao.xml
    """
    return _export("mjcf", out, robot, wear)


def urdf(out: File, robot: options.Body = None, wear: options.Wear = None) -> Answer:
    """Write the robot as URDF: links, masses, joints and shapes; URDF can hold no more.

    Example: nao-hil export urdf --robot nao-v3 --out nao.urdf
    """
    return _export("urdf", out, robot, wear)


def folder(
    out: Annotated[
        Path, typer.Option("--out", help="Folder to write; made if it is not there.", metavar="DIR")
    ],
    robot: options.Body = None,
    wear: options.Wear = None,
) -> Answer:
    """Write the robot with its shell as MuJoCo Menagerie and robot_descriptions lay models out.

    MJCF, a scene, URDF, meshes, a picture where MuJoCo can draw, licence, README and a test.

    Example: nao-hil export folder --robot nao-v6 --out nao_v6
    """
    # imported late: MuJoCo and the walker's posture solver take time
    from importlib.metadata import distribution

    from emulator.export.folder import draw_model, model_folder

    if out.exists() and not out.is_dir():
        raise ConfigurationError(f"{out} is a file; --out names a folder.")
    texts = {form: _text(form, robot, wear) for form in ("mjcf", "urdf")}
    (body, profile, model), (_, _, urdf_text) = texts["mjcf"], texts["urdf"]
    licence = next((f for f in distribution("nao-hil").files or () if f.name == "LICENSE"), None)
    files = model_folder(body, profile, model, urdf_text, licence.read_text() if licence else NOTICE)
    for name, text in files.items():
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        write_text(out / name, text)
    picture = draw_model(out)
    open_console().print(
        f"{body.name} with {profile} drives is in {out}."
        + ("" if picture else " No picture: MuJoCo cannot draw.")
    )
    found = sorted([*files, *([picture] if picture else [])])
    return Answer({"robot": body.name, "wear": profile, "folder": str(out), "files": found})


def _export(form: str, out: Path, robot: str | None, wear: str | None) -> Answer:
    body, profile, text = _text(form, robot, wear)
    write_text(out, text)
    open_console().print(f"{body.name} with {profile} drives is in {out}.")
    return Answer({"format": form, "robot": body.name, "wear": profile, "file": str(out)})


def _text(form: str, robot: str | None, wear: str | None) -> tuple[Any, str, str]:
    """Body, name of the wear profile, and the file's text."""
    # imported late: MuJoCo and the walker's posture solver take time
    from bridge.body import load_body
    from bridge.body.postures import POSTURES
    from emulator.engine.catalogue import require_engine
    from emulator.wear import load_wear
    from nao_hil import __version__
    from nao_hil.experiments.torso_responses import one_leg_stance

    body = load_body(robot or "nao-v3")
    profile = load_wear(wear or "nominal", body)
    notice = NOTICE.format(body=body.name, wear=profile.name, version=__version__)
    if form == "mjcf":
        require_engine("mujoco")
        from emulator.export.mjcf import to_mjcf

        poses = {"stand": POSTURES["StandInit"], "one-leg": one_leg_stance(body)}
        return body, profile.name, to_mjcf(body, profile, poses, notice)
    from emulator.export.urdf import to_urdf

    return body, profile.name, to_urdf(body, profile, notice)


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
) -> Answer:
    """Write a recorded run as one file: robot, charts, events. The page has a timeline and slow motion.

    Of two recordings the page has two robots side by side, and their charts over each other.

    --from, --to and --speed are the video's; the page always has the whole run.

    Example: nao-hil export runs/20260101T120000Z --html walk.html

    Example: nao-hil export walk.mcap --video fall.webm --from 10 --to 14 --speed 0.25
    """
    _check(page, video, begin, end, speed)
    written: dict[str, Path] = {}
    if page is not None:
        from nao_hil.view.page import recorded_page

        write_text(page, recorded_page(recordings)[0])
        written["html"] = page
    if video is not None:
        from nao_hil.cli.progress import CampaignProgress
        from nao_hil.view.video import write_video

        with CampaignProgress(open_console()) as progress:
            progress.begin("video", unit="parts of half a second")
            write_video(recordings[0], video, begin, end, speed, progress)
        written["video"] = video
    for file in written.values():
        size = 1e-6 * file.stat().st_size
        open_console().print(f"written to {file}, {size:.1f} MB", soft_wrap=True)
    files = {kind: {"file": str(file), "bytes": file.stat().st_size} for kind, file in written.items()}
    return Answer({**files, "config": recorded_config(recordings[0])})


def _check(page: Path | None, video: Path | None, begin: float, end: float | None, speed: float) -> None:
    """Raises ConfigurationError for files that cannot be written, or options without the video."""
    if page is None and video is None:
        raise ConfigurationError("Name the files to write: --html FILE, --video FILE, or both.")
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
