"""`nao-hil design`: compute the numbers that the walker loads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console
from nao_hil.cli.options import Assignments, assignments

if TYPE_CHECKING:
    from nao_hil.design.torso.assembly import TorsoDesign

Cycle = Annotated[
    list[float] | None,
    typer.Option(
        "--cycle", help="Cycle time of a robot; may be repeated. Default: those of all bodies.", metavar="S"
    ),
]
OutFile = Annotated[
    Path | None, typer.Option("--out", help="TOML file for `--config`; default: none.", metavar="FILE")
]


def torso(
    gait: options.Gait = None,
    values: Assignments = None,
    cycle: Cycle = None,
    out: OutFile = None,
) -> Answer:
    """Design the torso controllers of a gait: by the thesis' method (4.2.2), and for uncertain plants.

    The plant and the specifications are those of the gait's shipped designs. --set changes plant.numerator,
    plant.denominator, thesis.rise_time, thesis.overshoot, thesis.notch_factor, robust.overshoot,
    robust.gain_margin, robust.spread and robust.noise_gain. --out writes a file for --config.

    Example: nao-hil design torso --gait dynamic --json

    Example: nao-hil design torso --gait static --set thesis.rise_time=0.45 --out torso.toml

    Then: nao-hil up --gait static --torso thesis --config torso.toml
    """
    # imported late: `control` takes a second, and is there with the extra `design` only
    try:
        from nao_hil.design.torso import records
    except ModuleNotFoundError as error:
        if error.name != "control":
            raise
        raise ConfigurationError("`design torso` needs control; install nao-hil[design].") from None

    gait = gait or "static"
    inputs = records.shipped_inputs(gait, assignments(values or []))
    with open_console().status("design"):
        designed = records.design_torso(inputs, cycle or records.CYCLES)
    rows = [
        _row(method, seconds, design)
        for method, designs in (("thesis", designed.thesis), ("robust", designed.robust))
        for seconds, design in designs.items()
    ]
    _show(rows)
    if out is not None:
        command = " ".join(("nao-hil design torso --gait", gait, *(f"--set {v}" for v in values or [])))
        records.write_designs(out, designed.records, command)
    return Answer({"gait": gait, "file": out and str(out), "designs": rows})


def _row(method: str, cycle: float, design: TorsoDesign) -> dict[str, Any]:
    return {
        "method": method,
        "cycle": cycle,
        "phase_margin_deg": design.margins.phase_margin_deg,
        "gain_margin": design.margins.gain_margin,
        "crossover": design.margins.crossover,
        "overshoot": design.step.overshoot,
        "rise_time": design.step.rise_time,
        "settling_time": design.step.settling_time,
        "numerator_z": design.numerator_z,
        "denominator_z": design.denominator_z,
    }


def _show(rows: list[dict[str, Any]]) -> None:
    table = Table(
        *(
            "method",
            "cycle, ms",
            "phase margin, deg",
            "gain margin",
            "overshoot",
            "rises in, s",
            "settles in, s",
        ),
        title="Torso controllers",
    )
    for row in rows:
        table.add_row(
            row["method"],
            f"{1e3 * row['cycle']:g}",
            f"{row['phase_margin_deg']:.1f}",
            f"{row['gain_margin']:.2f}",
            f"{100 * row['overshoot']:.1f} %",
            f"{row['rise_time']:.2f}",
            f"{row['settling_time']:.1f}",
        )
    open_console().print(table)
