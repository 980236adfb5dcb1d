"""`nao-hil up` and `demo`: both sides at once, watched."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from bridge.body import load_body
from bridge.config import from_dict
from bridge.errors import ConfigurationError, LinkError, NaoHilError, WalkFailed
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.session import check_free
from bridge.motion import get_up_motions
from bridge.recording.recorder import Recorder
from nao_hil.cli import options
from nao_hil.cli.added_options import takes_run
from nao_hil.cli.console import Answer, chosen_engine, open_console, own_command
from nao_hil.cli.progress import WalkProgress, conclude
from nao_hil.cli.signals import loading, stop_event
from nao_hil.runs.config import RunConfig, run_config
from nao_hil.runs.demo import GAIT, ROBOT, Demo
from nao_hil.runs.folder import RunDirectory, robot_scene
from nao_hil.runs.monitor import Monitor
from nao_hil.runs.sides import END_TIMEOUT, Sides
from nao_hil.runs.supervisor import ChildResult
from nao_hil.view.child import DEFAULT_PORT, LivePage

if TYPE_CHECKING:
    from rich.console import Console


@takes_run()
def up(
    settings: RunConfig,
    serve: options.Serve = False,
    recover: options.Recover = None,
    view: options.View = False,
    port: options.Port = DEFAULT_PORT,
    name: options.Name = DEFAULT_ROBOT,
    listen: options.Listen = DEFAULT_ENDPOINT,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
) -> Answer:
    """Start the robot and the walker as two processes and watch them walk.

    Example: nao-hil up --robot nao-v4 --steps 20 --mode lockstep --seed 1

    With --serve both run until Ctrl-C, and the robot walks by command (`nao-hil drive`, or the page).
    Then, or where it begins lying, the robot gets up by itself, unless --no-recover is given; and a walker
    that ends before is started again, at most three times in a minute.
    """
    # imported late: the walk needs SciPy, which help and completion need not wait for
    with loading():
        from emulator.scenarios import load_scenario
        from nao_hil.runs.build import configuration_warnings

        settings = chosen_engine(settings)
    lies = (settings.start or load_scenario(settings.scenario).start.pose).startswith("lie-")
    if recover is None:
        recover = serve or settings.recover or lies
    if recover and lies and "back" not in get_up_motions(load_body(settings.robot)):
        raise ConfigurationError(f"{settings.robot} has no motion to get up; --no-recover lets it lie.")
    settings = msgspec.structs.replace(settings, recover=recover)
    for warning in configuration_warnings(settings):
        open_console().print(warning)
    if settings.mode == "in-process" and (serve or view):
        raise ConfigurationError("mode in-process has no link; --serve and --view need real-time or lockstep.")
    linked = settings.mode != "in-process"
    directory = new_folder(settings, out, listen if linked else None, overwrite=overwrite, waits=serve)
    if not linked:
        return _in_process(settings, directory)
    shown = port if view else None
    return both_sides(settings, directory, name, listen, serve=serve, port=shown)


def new_folder(
    settings: RunConfig, out: Path | None, listen: str | None = None, *, overwrite: bool, waits: bool = True
) -> RunDirectory:
    """The folder of a run, with its configuration.

    Args:
        settings: Of the run.
        out: The folder; None: a new one by the time.
        listen: Zenoh endpoint that must be free; None: none is needed.
        overwrite: A run that it holds is replaced.
        waits: The walker waits for orders.

    Raises:
        ConfigurationError: it cannot be made or holds a run, or the run could not begin; the folder
            keeps its content then.
        LinkError: a robot is at the endpoint.
    """
    from nao_hil.runs.build import check_run  # imported late: as in `up`

    check_run(settings, waits=waits)
    if listen is not None:
        check_free(listen)
    directory = RunDirectory(out)
    directory.clear(overwrite=overwrite)
    directory.write_config(settings)
    return directory


def both_sides(
    settings: RunConfig,
    directory: RunDirectory,
    name: str,
    listen: str,
    *,
    serve: bool,
    port: int | None,
    demo: Demo | None = None,
) -> Answer:
    """Robot and walker as two processes until one ends, a signal comes, or the demo is over.

    A serving walker that ends is started again (`nao_hil.runs.sides`); then only the robot's end is one.

    Args:
        settings: Of the run.
        directory: Its folder.
        name: Id of the robot.
        listen: Zenoh endpoint of the robot.
        serve: The walker waits for commands.
        port: Of the page; None: no page.
        demo: Commands the walker.

    Returns:
        Summary and exit code.

    Raises:
        NaoHilError: a side failed.
    """
    stop, console = stop_event(), open_console()
    page = LivePage(name, listen, port, directory.path) if port is not None else None
    run, first = 1, directory.path
    while True:
        sides = Sides(directory, name, listen, serve=serve)
        again: tuple[RunConfig, RunDirectory] | None = None
        try:
            with Monitor(name, listen) as monitor, WalkProgress(console) as progress:
                while not stop.is_set() and sides.running and not (demo and demo.done) and again is None:
                    stop.wait(0.2)
                    progress.show(monitor)
                    if sentence := sides.restart_walker(monitor.sensors):
                        console.print(sentence)
                    if page is not None:
                        page.report(console)
                        folder = directory.path.parent / f"{first.name}-{run + 1}"
                        again = _asked(page, settings, folder)
                    if demo is not None:
                        demo.advance(monitor.sensors, monitor.telemetry.state if monitor.telemetry else "")
        finally:
            if page is not None and again is None:
                page.ask_to_end()
            walker_result, robot_result = sides.end()
            if page is not None and again is None:
                page.end(END_TIMEOUT)
        if again is None:
            walker = None if sides.given_up else walker_result
            answer = _conclude(settings, directory, robot_result, walker, stop.is_set())
            break
        run += 1
        settings, directory = again
    if page is not None and answer.code != 130 and robot_result.result is not None:
        _print_next(console, directory.last_recording(robot_result.result["resets"]), serve)
    return answer._replace(code=0) if serve and answer.code == 130 else answer  # serving has no other end


def _print_next(console: Console, recording: Path, serve: bool) -> None:
    """Print commands that follow a run on the page."""
    console.print(f"look at it again: {own_command()} view --replay {recording}", soft_wrap=True)
    if not serve:
        console.print(f"walk it, push it: {own_command()} up --serve --view")


def _asked(page: LivePage, settings: RunConfig, folder: Path) -> tuple[RunConfig, RunDirectory] | None:
    """Settings and folder of another run that the page asks for; None: it asks for none that can be had."""
    changes = page.restart()
    if changes is None:
        return None
    try:
        again = from_dict(msgspec.to_builtins(settings) | changes, "the page", RunConfig)
        if again.mode == "in-process":
            raise ConfigurationError("mode in-process has no link")
        return again, new_folder(again, folder, overwrite=True)
    except NaoHilError as error:
        open_console().print(f"the page's run cannot begin: {error}")
        return None


def _in_process(settings: RunConfig, directory: RunDirectory) -> Answer:
    """Robot and walker in this process, as fast as they compute."""
    from emulator.scenarios import load_scenario
    from nao_hil.runs.in_process import walk_in_process

    directory.write_scenario(load_scenario(settings.scenario))
    stop, console = stop_event(), open_console()
    scene = robot_scene(load_body(settings.robot))
    with Recorder(directory.recording, settings, scene) as recorder, console.status("walking in this process"):
        summary = walk_in_process(settings, [recorder], stop.is_set)
    interrupted = stop.is_set()
    data = msgspec.to_builtins(summary) | {"config": msgspec.to_builtins(settings)}
    data = conclude(data, directory, interrupted=interrupted, target=settings.target)
    return _judged(data, interrupted)


def _conclude(
    settings: RunConfig,
    directory: RunDirectory,
    robot: ChildResult,
    walker: ChildResult | None,
    interrupted: bool,
) -> Answer:
    """Summary, JSON and exit code of a run; without a walker: given up, which is reported already."""
    if interrupted and (robot.result is None or (walker is not None and walker.result is None)):
        return Answer(None, code=130)  # before both sides had begun
    failed = [
        (name, outcome)
        for name, outcome in (("robot", robot), ("walker", walker))
        if outcome is not None and not _ended_well(outcome)
    ]
    if failed:
        # A side that ended because the other failed has no result either: the one with the reason speaks.
        raise _failure(*max(failed, key=lambda side: (side[1].code == 2, side[1].code not in (0, 1, 130))))
    assert robot.result is not None
    inference = walker.result["inference"] if walker is not None and walker.result else None
    summary = robot.result | {"walker": walker.result if walker is not None else None, "inference": inference}
    summary = conclude(summary, directory, interrupted=interrupted, target=settings.target)
    if walker is None:
        return Answer(summary, code=3)
    return _judged(summary, interrupted, fell=walker.code == 1)


def _judged(summary: dict[str, Any], interrupted: bool, *, fell: bool = False) -> Answer:
    """Summary, exit code and error of a run: 1 if the robot lies at its end, or never stood up."""
    lies = not (summary["stands"] or summary["steps"] or interrupted)
    fell = fell or lies or summary["falls"] > summary["recoveries"]
    failure = summary["failure"]
    error = WalkFailed(f"The walk ended: {failure}. The robot stands.") if failure and not fell else None
    return Answer(summary, code=1 if fell else 130 if interrupted else 0, error=error)


def _ended_well(outcome: ChildResult) -> bool:
    """Whether a side carried its task out, or its walk ended by a failure that its result names."""
    if outcome.result is None:
        return False
    return outcome.code in (0, 1, 130) or bool(outcome.result.get("failure"))


def _failure(name: str, outcome: ChildResult) -> NaoHilError:
    error: NaoHilError
    sentence = f"the {name}'s process failed: {outcome.error}"
    error = ConfigurationError(outcome.error) if outcome.code == 2 else LinkError(sentence)
    return error


def demo(
    view: options.View = True,
    port: options.Port = DEFAULT_PORT,
    engine: options.Engine = None,
    mode: options.Mode = None,
    seed: options.Seed = None,
    listen: options.Listen = DEFAULT_ENDPOINT,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
) -> Answer:
    """Show a walk in all directions, a push and a stop in under a minute, with captions.

    Example: nao-hil demo --seed 3
    """
    settings = run_config(None, robot=ROBOT, gait=GAIT, engine=engine, mode=mode, seed=seed, steps=0)
    settings = chosen_engine(settings)
    # a robot that is there already would be commanded by the demo
    directory = new_folder(settings, out, listen, overwrite=overwrite)
    with Demo(DEFAULT_ROBOT, listen) as play:
        answer = both_sides(
            settings,
            directory,
            DEFAULT_ROBOT,
            listen,
            serve=True,
            port=port if view else None,
            demo=play,
        )
    open_console().print(
        f"walk it, push it: {own_command()} up --serve --view --robot {ROBOT} --gait {GAIT}\n"
        f"the thesis' experiments: {own_command()} experiment all --out DIR"
    )
    return answer
