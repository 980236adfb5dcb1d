"""`nao-hil identify`: the wear profile of a recorded robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec
import typer

from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.compare import RecordingOrCsv
from nao_hil.cli.console import open_console
from nao_hil.files import write_bytes


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
    as_json: options.Json = False,
) -> int:
    """Fit backlash, delay, stiffness and friction to a recording of `nao-hil excite`.

    The file loads with --wear, and says which values were identified, with intervals, and which were assumed.
    Beside it are the same as JSON, and a page with pictures.

    Example: nao-hil identify frames.mcap --out my-robot.toml

    Example: nao-hil identify real.csv --robot nao-v5 --out my-robot.toml
    """
    # imported late: the fit and the figures are for those who identify
    from emulator.wear import load_wear
    from nao_hil.identification.identification import identify, result
    from nao_hil.identification.identification_page import in_words, write_identification
    from nao_hil.identification.profile import write_profile
    from nao_hil.identification.recorded import read_signals

    options.check_stretch(begin, end)
    if out.suffix != ".toml":
        raise ConfigurationError(f"--out {out}: the name of a wear profile ends with .toml.")
    console = open_console()
    recorded = read_signals(recording, robot, begin, end)
    profile = load_wear(base, recorded.body)
    with console.status("fitting") as status:
        found, signals = identify(recorded, profile, lambda n: status.update(f"fitting: simulation {n}"))
    values = result(recorded, found, signals, profile, str(recording), str(out))
    write_profile(out, values, profile)
    encoded = msgspec.json.encode(values)
    write_bytes(out.with_suffix(".json"), msgspec.json.format(encoded))
    page = out.with_name(f"{out.stem}-report.html")
    write_identification(page, values, found, signals)
    for name, each in values.parameters.items():
        value, interval = in_words(name, each)
        console.print(f"{name:26} {value:>20}   {interval}", highlight=False)
    console.print(f"profile: {out}\nreport: {page}", highlight=False, soft_wrap=True)
    if as_json:
        print(encoded.decode(), flush=True)
    return 0
