"""`nao-hil excite`, `identify` and `compare`: the emulated robot against recordings of a real one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import typer

from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ROBOT
from nao_hil.cli import options
from nao_hil.cli.console import Answer, chosen_engine, open_console
from nao_hil.cli.progress import share_shown
from nao_hil.files import write_bytes
from nao_hil.runs.config import RunConfig, run_config
from nao_hil.runs.folder import RunDirectory, recording_of

if TYPE_CHECKING:
    from rich.console import Console

    from nao_hil.identification.excitation import ExcitationResult

RecordingOrCsv = Annotated[
    Path,
    typer.Argument(
        help="Recording (.mcap, .csv, .csv.gz; .log of B-Human, NaoTH; .mcap of HULKs), or a run's folder.",
        metavar="RECORDING",
        show_default=False,
        callback=recording_of,
    ),
]


def identify(
    recording: RecordingOrCsv,
    out: Annotated[
        Path, typer.Option("--out", help="Wear profile to write (.toml).", metavar="FILE", show_default=False)
    ],
    robot: options.Body = None,
    base: Annotated[
        str,
        typer.Option(
            "--base", help="Wear profile that gives all other values: a name, or a path.", metavar="WEAR"
        ),
    ] = "nominal",
    begin: options.Begin = 0.0,
    end: options.End = None,
    columns: options.Columns = None,
) -> Answer:
    """Fit backlash, delay, stiffness and friction to a recording of `nao-hil excite`.

    The file loads with --wear; it marks values as identified, with intervals, or as assumed. The same as JSON
    and a page with pictures are written next to it.

    Example: nao-hil identify frames.mcap --out my-robot.toml

    Example: nao-hil identify real.csv --robot nao-v5 --out my-robot.toml
    """
    # imported late: the fit and the figures are for those who identify
    from emulator.wear import load_wear
    from nao_hil.identification.identification import identify, result, write_profile
    from nao_hil.identification.identification_page import in_words, write_identification
    from nao_hil.identification.recorded import read_signals

    options.check_stretch(begin, end)
    if out.suffix != ".toml":
        raise ConfigurationError(f"--out {out}: the name of a wear profile ends with .toml.")
    console = open_console()
    recorded = read_signals(recording, robot, begin, end, columns)
    profile = load_wear(base, recorded.body)
    with console.status("fitting") as status:
        found, signals = identify(recorded, profile, lambda n: status.update(f"fitting: simulation {n}"))
    values = result(recorded, found, signals, profile, str(recording), str(out))
    write_profile(out, values, profile)
    write_bytes(out.with_suffix(".json"), msgspec.json.format(msgspec.json.encode(values)))
    page = out.with_name(f"{out.stem}-report.html")
    write_identification(page, values, found, signals)
    for note in values.notes:
        console.print(note, soft_wrap=True)
    for name, each in values.parameters.items():
        value, interval = in_words(name, each)
        console.print(f"{name:26} {value:>20}   {interval}")
    console.print(f"profile: {out}\nreport: {page}", soft_wrap=True)
    return Answer(values)


def compare(
    recording: RecordingOrCsv,
    robot: options.Body = None,
    wear: options.Wear = None,
    engine: options.Engine = None,
    scenario: options.Scenario = None,
    start: options.Start = None,
    seed: options.Seed = None,
    begin: options.Begin = 0.0,
    end: options.End = None,
    columns: options.Columns = None,
    leg_model: Annotated[
        Path | None,
        typer.Option(
            "--leg-model",
            help="Network of JointAnglePredictor (.onnx): its errors on both robots, walking; a V6.",
            metavar="FILE",
        ),
    ] = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
) -> Answer:
    """Replay a recording's commands through the emulated robot, and report the differences.

    Body, world and start are those of the recording, unless options name others; drives and sensors
    are `nominal`. Without commands only sensors are compared. The folder gets report.html and summary.json.

    Example: nao-hil compare frames.mcap --wear worn

    Example: nao-hil compare real.csv --robot nao-v5 --start hang --from 2 --to 60
    """
    # imported late: physics and figures are for those who compare
    from nao_hil.identification.comparison_page import write_comparison
    from nao_hil.identification.comparison_run import compare_recording
    from nao_hil.identification.leg_model import compare_leg_model, load_model
    from nao_hil.identification.recorded import read_signals

    options.check_stretch(begin, end)
    console = open_console()
    model = None if leg_model is None else load_model(leg_model)
    recorded = read_signals(recording, robot, begin, end, columns)
    named: dict[str, Any] = {
        name: given if given is not None else recorded.config.get(name)
        for name, given in (("robot", robot), ("scenario", scenario), ("start", start))
    }
    settings = chosen_engine(run_config(None, **named, wear=wear, engine=engine, seed=seed))
    directory = RunDirectory(out)
    directory.clear(overwrite=overwrite)
    directory.write_config(settings)
    with share_shown("replay", console) as show:
        result, replayed = compare_recording(recorded, str(recording), settings, show)
    if model is not None:
        compared = compare_leg_model(model, str(leg_model), recorded.body, recorded.signals, replayed)
        result = msgspec.structs.replace(result, leg_model=compared)
    directory.write_summary(msgspec.to_builtins(result))
    page = directory.path / "report.html"
    write_comparison(page, result, recorded.signals, replayed)
    for note in result.notes:
        console.print(note, soft_wrap=True)
    if result.leg_model is not None:
        console.print(result.leg_model.sentence, soft_wrap=True)
    console.print(f"{result.sentence}\nreport: {page}", soft_wrap=True)
    return Answer(result)


def excite(
    duration: Annotated[
        float, typer.Option("--duration", help="Of the motion, s; at least 60.", metavar="S")
    ] = 600.0,
    start: Annotated[
        str,
        typer.Option("--start", help="hang: all joints; stand: head and arms only.", metavar="hang|stand"),
    ] = "hang",
    connect: Annotated[
        str | None,
        typer.Option(
            "--connect",
            help="Zenoh endpoint of the robot; default: an emulated robot in this process.",
            metavar="ENDPOINT",
        ),
    ] = None,
    name: options.Name = DEFAULT_ROBOT,
    robot: options.Body = None,
    wear: options.Wear = None,
    engine: options.Engine = None,
    seed: options.Seed = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
) -> Answer:
    """Move joint after joint, slowly and in small steps, and record it for `nao-hil identify`.

    A robot that hangs by its shoulders moves all joints, a standing one only head and arms. The motion
    begins and ends in the present posture. --robot, --wear, --engine and --seed are for the emulated
    one.

    Example: nao-hil excite --wear worn --duration 120 --out worn

    Example: nao-hil excite --connect tcp/192.168.1.7:7447 --start hang
    """
    from nao_hil.identification.excitation import check_start  # imported late: it loads SciPy

    check_start(start, duration)
    console = open_console()
    settings = run_config(None, robot=robot, wear=wear, engine=engine, seed=seed, start=start)
    directory = RunDirectory(out)
    directory.clear(overwrite=overwrite)
    if connect is None:
        settings = chosen_engine(settings)
        directory.write_config(settings)
    result = _excite(settings, duration, connect, name, directory.recording, console)
    directory.write_summary(msgspec.to_builtins(result))
    console.print(f"{result.seconds:.1f} s of {result.robot} in {result.recording}", soft_wrap=True)
    return Answer(result)


def _excite(
    settings: RunConfig, duration: float, connect: str | None, name: str, recording: Path, console: Console
) -> ExcitationResult:
    """Move the robot at an endpoint, or without one an emulated robot, under a progress bar."""
    # imported late: physics and the link are for those who use them
    from nao_hil.connection import connect as connected
    from nao_hil.identification.excitation import excite_emulated, excite_linked

    with share_shown("excitation", console) as show:
        if connect is None:
            return excite_emulated(settings, duration, recording, show)
        with connected(connect, robot=name, name="excite") as link:
            return excite_linked(link, settings.start, duration, recording, show)
