"""The thesis' two torso controllers (4.2.2) and the robust one, designed for the plant (4.12)."""

from __future__ import annotations

from pathlib import Path

import control
import matplotlib
import msgspec
import numpy as np

from walker.torso.analysis import bode, frequency_response
from walker.torso.design import DYNAMIC_GAIT, STATIC_GAIT, TorsoDesign, thesis_design
from walker.torso.robust import robust_design
from walker.torso.transfer import thesis_plant

matplotlib.use("Agg")
from matplotlib import pyplot as plt

TOLERANCE = 0.01
"""Share by which a margin may differ from its value recomputed from the thesis' own numbers."""
CHECKED = {"static": (60.0, 2.13), "dynamic": (60.0, 1.52)}
"""Phase margin (deg) and gain margin that the thesis' two designs have (4.17), (4.21)."""


class Design(msgspec.Struct, frozen=True, kw_only=True):
    """One controller's figures."""

    phase_margin_deg: float
    gain_margin: float
    overshoot: float
    """Of the closed loop's step response, share of the final value."""
    settling_time_s: float
    numerator_z: tuple[float, ...]
    """Highest power first."""
    denominator_z: tuple[float, ...]


class TorsoDesignResult(msgspec.Struct, frozen=True, kw_only=True):
    """The three designs side by side."""

    name: str = "torso-design"
    passed: bool
    """The thesis' margins come out within 1 %; the robust design overshoots less than 10 %, gain margin 2.5."""
    static: Design
    dynamic: Design
    robust: Design


def run(out: Path | None = None) -> TorsoDesignResult:
    """Design all three for the plant (4.12).

    Args:
        out: folder for `torso-design.json` and `torso-design.png`; None: nothing is written.
    """
    plant = thesis_plant()
    designs = {
        "static": thesis_design(plant, STATIC_GAIT),
        "dynamic": thesis_design(plant, DYNAMIC_GAIT),
        "robust": robust_design(plant),
    }
    figures = {name: _figures(design) for name, design in designs.items()}
    as_printed = all(
        abs(figures[name].phase_margin_deg / phase - 1.0) <= TOLERANCE
        and abs(figures[name].gain_margin / gain - 1.0) <= TOLERANCE
        for name, (phase, gain) in CHECKED.items()
    )
    robust = figures["robust"]
    result = TorsoDesignResult(
        passed=as_printed and robust.overshoot < 0.10 and robust.gain_margin >= 2.5,
        static=figures["static"],
        dynamic=figures["dynamic"],
        robust=robust,
    )
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        (out / "torso-design.json").write_bytes(msgspec.json.format(msgspec.json.encode(result)))
        plot(out / "torso-design.png", designs)
    return result


def _figures(design: TorsoDesign) -> Design:
    return Design(
        phase_margin_deg=design.margins.phase_margin_deg,
        gain_margin=design.margins.gain_margin,
        overshoot=design.step.overshoot,
        settling_time_s=design.step.settling_time,
        numerator_z=tuple(float(c) for c in design.numerator_z),
        denominator_z=tuple(float(c) for c in design.denominator_z),
    )


def plot(path: Path, designs: dict[str, TorsoDesign]) -> None:
    """Bode diagram, Nyquist curve and closed-loop step of each design (figures 4.11 to 4.14)."""
    figure, ((gain, nyquist), (phase, step)) = plt.subplots(2, 2, figsize=(11, 8), layout="constrained")
    omega = np.asarray(np.geomspace(0.1, 100.0, 800), dtype=np.float64)
    for name, design in designs.items():
        curve = bode(design.loop_q, omega)
        gain.semilogx(omega, curve.magnitude_db, label=name)
        phase.semilogx(omega, curve.phase_deg)
        points = frequency_response(design.loop_q, omega)
        nyquist.plot(points.real, points.imag)
        closed: control.TransferFunction = control.feedback(design.plant_z * design.controller_z, 1)
        time, output = control.step_response(closed, np.arange(0.0, 6.0, 0.01))
        step.plot(time, output)
    gain.set(ylabel="open loop, dB", xlabel="Omega, rad/s", ylim=(-60.0, 40.0))
    gain.legend()
    phase.set(ylabel="phase, deg", xlabel="Omega, rad/s")
    nyquist.plot(-1.0, 0.0, "k+")
    nyquist.set(xlim=(-2.5, 1.0), ylim=(-2.0, 2.0), xlabel="Re", ylabel="Im", title="Nyquist")
    step.set(xlabel="time, s", ylabel="torso angle", title="closed loop, step of the reference")
    for axes in (gain, phase, nyquist, step):
        axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)
