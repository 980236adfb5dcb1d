"""Drives of emulated robots that differ from `nominal` in every unknown: recorded, fitted, against the truth.

The robots are members of the ensemble of the V3, hanging, on MuJoCo, each recorded with `nao-hil excite` and
fitted with `nao-hil identify`. `model_error` of the fit is calibrated on some; the others test the intervals.
"""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, NamedTuple

import numpy as np

from bridge.body import Body, load_body
from bridge.body.quantities import joint_stall_torque
from emulator.servo.parameters import ServoParameters
from emulator.wear import load_wear
from nao_hil.identification.excitation import excite_emulated
from nao_hil.identification.fit import ABSOLUTE
from nao_hil.identification.identification import identify, parameters
from nao_hil.identification.recorded import read_signals
from nao_hil.runs.config import run_config

BODY: Final = "nao-v3"
CALIBRATION: Final = range(40, 43)
"""Members that `model_error` is calibrated on."""
CALIBRATION_SEED: Final = 9000
"""Seed of member 0; that of member k is k more."""
VALIDATION: Final = range(30, 40)
"""Members not used in any calibration."""
VALIDATION_SEED: Final = 31_000


class Recovered(NamedTuple):
    """One parameter of one robot."""

    kind: str
    """Its name up to the dot."""
    error: float
    """rad, s, or a fraction of the truth, see `ABSOLUTE`."""
    scatter: float | None
    """Standard deviation by the scatter of the residuals alone, likewise; None: follows from other values."""
    held: bool
    """The interval holds the truth."""


def measure(
    members: Sequence[int] = VALIDATION, first_seed: int = VALIDATION_SEED, duration: float = 600.0
) -> dict[str, Any]:
    """Record and fit robots of the ensemble, one after the other.

    Args:
        members: Their numbers.
        first_seed: Seed of the recording of member 0; that of member k is k more.
        duration: Of each recording, s.

    Returns:
        By kind of parameter, see `summary`.
    """
    return summary([each for k in members for each in recover(k, first_seed + k, duration)])


calibrate = functools.partial(measure, CALIBRATION, CALIBRATION_SEED)
"""Measurement on the robots that calibrate `model_error`."""


def recover(member: int, seed: int, duration: float) -> Iterator[Recovered]:
    """Record one robot and fit its drives; all parameters.

    Args:
        member: Of the ensemble.
        seed: Of the recording.
        duration: Of the recording, s.
    """
    body, wear = load_body(BODY), f"ensemble:{member}"
    settings = run_config(None, robot=BODY, wear=wear, engine="mujoco", seed=seed, start="hang")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "frames.mcap"
        excite_emulated(settings, duration, file)
        recorded = read_signals(file, None)
    found, _ = identify(recorded, load_wear("nominal"))
    scatter = dict(zip(found.names, np.sqrt(np.diag(found.covariance)), strict=True))
    drives = load_wear(wear, body).servo
    for name, identified in parameters(body, found).items():
        kind, low, high = name.partition(".")[0], *identified.interval
        truth = true_value(body, drives, name)
        unit = 1.0 if kind in ABSOLUTE else truth
        yield Recovered(
            kind=kind,
            error=(identified.value - truth) / unit,
            scatter=float(scatter[name]) / unit if name in scatter else None,
            held=low <= truth <= high,
        )


def true_value(body: Body, drives: ServoParameters, name: str) -> float:
    """True value of a parameter of an identification.

    Args:
        body: Data sheet.
        drives: Of the recorded robot.
        name: `delay`, `backlash.KneePitch`, `stiffness.KneePitch`, ...
    """
    kind, _, group = name.partition(".")
    if not group:
        return float(getattr(drives, name))
    joint = group if group.startswith("Head") else f"L{group}"
    if kind == "backlash":
        return drives.backlash.of(joint)
    gears = 2.0 if group == "HipYawPitch" else 1.0  # one motor, two gears side by side
    loop = drives.full_voltage_error / joint_stall_torque(body, joint)
    return 1.0 / (loop + drives.gear_compliance / gears)


def summary(recovered: Sequence[Recovered]) -> dict[str, dict[str, float | int | None]]:
    """By kind of parameter: number of values, errors, and how many intervals hold the truth.

    Args:
        recovered: Of all robots.

    Returns:
        `n`; `largest_error` and `rms_error`; `held`; and `model_error`, the standard deviation that the
        scatter of the residuals does not account for, None for values that follow from others.
    """
    kinds: dict[str, list[Recovered]] = defaultdict(list)
    for each in recovered:
        kinds[each.kind].append(each)
    return {kind: _summary(each) for kind, each in kinds.items()}


def _summary(recovered: Sequence[Recovered]) -> dict[str, float | int | None]:
    square = np.square([each.error for each in recovered])
    scatter = [each.scatter for each in recovered if each.scatter is not None]
    beyond = float(square.mean() - np.square(scatter).mean()) if scatter else None
    return {
        "n": len(recovered),
        "largest_error": float(np.sqrt(square.max())),
        "rms_error": float(np.sqrt(square.mean())),
        "held": sum(each.held for each in recovered),
        "model_error": None if beyond is None else float(np.sqrt(max(beyond, 0.0))),
    }
