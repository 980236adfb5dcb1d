"""`nao-hil up`: both sides at once, watched."""

from __future__ import annotations

import json
import math
import threading
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from bridge.errors import ConfigurationError, LinkError, NaoHilError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from lab.cli import options
from lab.cli.console import open_console
from lab.cli.progress import WalkProgress
from lab.cli.signals import on_signals
from lab.cli.walk import controller_maker
from lab.config import RunConfig, run_config
from lab.monitor import Monitor
from lab.rundir import RunDirectory
from lab.supervisor import Child, Outcome
from lab.view.child import LivePage
from lab.view.server import DEFAULT_PORT

GRACE = 5.0
"""s a side has to end by itself after it was asked to."""


def up(
    robot: options.Body = None,
    wear: options.Wear = None,
    scenario: options.Scenario = None,
    gait: options.Gait = None,
    torso: options.Torso = None,
    admittance: options.Admittance = None,
    mode: options.Mode = None,
    steps: options.Steps = None,
    duration: options.Duration = None,
    seed: options.Seed = None,
    serve: options.Serve = False,
    view: options.View = False,
    port: options.Port = DEFAULT_PORT,
    name: options.Name = DEFAULT_ROBOT,
    listen: options.Listen = DEFAULT_ENDPOINT,
    config: options.Config = None,
    out: options.Out = None,
    as_json: options.Json = False,
) -> int:
    """Start the robot and the walker as two processes and watch them walk.

    Example: nao-hil up --robot nao-v4 --steps 20 --mode lockstep --seed 1

    With --serve both run until Ctrl-C, and the robot walks as it is told to (`nao-hil drive`, or the page).
    """
    settings = run_config(
        config,
        robot=robot,
        wear=wear,
        scenario=scenario,
        gait=gait,
        torso=torso,
        admittance=admittance,
        mode=mode,
        steps=steps,
        duration=duration,
        seed=seed,
    )
    controller_maker(settings)  # refuses what the walker would, before anything has begun
    directory = RunDirectory(out)
    if directory.clear():
        open_console().print(f"the run that was in {directory.path} is replaced", highlight=False)
    directory.write_config(settings)
    file = str(directory.config)
    stop = threading.Event()
    on_signals(stop.set)
    common = ["--name", name, "--config", file, "--json"]
    emulator = Child(
        "robot", ["emulate", "--listen", listen, "--out", str(directory.path), *common], directory.path
    )
    serving = ["--serve"] if serve else []
    walker = Child("walker", ["walk", "--connect", listen, *serving, *common], directory.path)
    page = LivePage(name, listen, port, directory.path) if view else None
    console = open_console()
    try:
        with Monitor(name, listen) as monitor, WalkProgress(settings, console) as progress:
            while not stop.is_set() and emulator.running and walker.running:
                stop.wait(0.2)
                progress.show(monitor)
                if page is not None:
                    page.tell(console)
    finally:
        if page is not None:
            page.ask_to_end()
        # Both at once; a walker that ended by itself has brought the robot to a stand before.
        walker.ask_to_end()
        emulator.ask_to_end()
        walker_result = walker.end(GRACE)
        robot_result = emulator.end(GRACE)
        if page is not None:
            page.end(GRACE)
    code = _conclude(settings, directory, robot_result, walker_result, stop.is_set(), as_json)
    if page is not None and code != 130 and robot_result.result is not None:
        recording = directory.last_recording(robot_result.result["resets"])
        console.print(f"look at it again: nao-hil view --replay {recording}", highlight=False, soft_wrap=True)
        if not serve:
            console.print("walk it, push it: nao-hil up --serve --view", highlight=False)
    return 0 if serve and code == 130 else code  # a walker that serves has no other end


def _conclude(
    settings: RunConfig,
    directory: RunDirectory,
    robot: Outcome,
    walker: Outcome,
    interrupted: bool,
    as_json: bool,
) -> int:
    """Summary, JSON and exit code of a run."""
    console = open_console()
    if interrupted and (robot.result is None or walker.result is None):
        return 130  # before both sides had begun
    failed = [
        (name, outcome)
        for name, outcome in (("robot", robot), ("walker", walker))
        if outcome.code not in (0, 1, 130) or outcome.result is None
    ]
    if failed:
        # A side that ended because the other failed has no result either: the one with the reason speaks.
        raise _failure(*max(failed, key=lambda side: (side[1].code == 2, side[1].code not in (0, 1, 130))))
    assert robot.result is not None
    recording = directory.last_recording(robot.result["resets"])
    told = _diagnosis(recording) if robot.result["fell"] else None
    summary = robot.result | {"walker": walker.result, "diagnosis": told}
    directory.write_summary(summary)
    _show(summary, recording, console, interrupted)
    if as_json:
        print(json.dumps(summary), flush=True)
    if summary["fell"] or walker.code == 1:
        return 1
    return 130 if interrupted else 0


def _diagnosis(recording: Path) -> str | None:
    from lab.diagnosis import diagnose  # imported late: most runs end well, and need no SciPy here

    diagnosis = diagnose(recording)
    return diagnosis.sentence if diagnosis is not None else None


def _failure(name: str, outcome: Outcome) -> NaoHilError:
    error: NaoHilError
    sentence = f"the {name}'s process failed: {outcome.error}"
    error = ConfigurationError(outcome.error) if outcome.code == 2 else LinkError(sentence)
    return error


def _show(summary: dict[str, Any], recording: Path, console: Console, interrupted: bool) -> None:
    ending = "The robot fell" if summary["fell"] else "Interrupted" if interrupted else "The robot stands"
    table = Table(title=ending, show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    table.add_row("steps", str(summary["steps"]))
    table.add_row("distance", f"{summary['distance']:.3f} m")
    table.add_row("speed over ground", f"{summary['speed']:.4f} m/s")
    table.add_row("largest torso tilt", f"{math.degrees(summary['torso_max']):.2f} deg")
    table.add_row("real-time factor", f"{summary['real_time_factor']:.2f}")
    table.add_row("cycles", f"{summary['cycles']}, {summary['cycles_missed']} missed")
    table.add_row("recording", str(recording))
    console.print(table)
    if summary["diagnosis"] is not None:
        console.print(summary["diagnosis"], highlight=False)
