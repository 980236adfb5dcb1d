"""From a recording to the wear profile of its robot, and its file."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS
from bridge.body.quantities import absent_joints, joint_stall_torque
from bridge.errors import ConfigurationError
from bridge.types import Array
from emulator.servo.parameters import Backlash, ServoParameters
from emulator.wear import WearProfile
from nao_hil.analysis.statistics import Estimate
from nao_hil.files import write_text
from nao_hil.identification.fit import CONFIDENCE, KINDS, Fit, fit, joints_of
from nao_hil.identification.readings import Signals
from nao_hil.identification.recorded import RecordedSignals

STEADY: Final = 0.15
"""rad by which the torso may tilt to and fro."""


class Identification(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil identify`."""

    recording: str
    robot: str
    base: str
    """Wear profile that everything else is taken from."""
    profile: str
    """The written file."""
    confidence: float
    notes: tuple[str, ...]
    """Conversions and assumptions about the recording."""
    seconds: float
    parameters: dict[str, Estimate]
    """`delay`, `full_voltage_error`, `gear_compliance`, `dry_friction`, `backlash.KneePitch`, ..., and
    the derived `stiffness.KneePitch`, ..., N m/rad."""
    assumed: tuple[str, ...]
    """Values of the profile's table `servo` that are not fitted."""
    residual: dict[str, float | None]
    """RMS of the measured angle less the model's by joint, rad; None: not used."""


def identify(
    recorded: RecordedSignals, base: WearProfile, progress: Callable[[int], None] = lambda _: None
) -> tuple[Fit, Signals]:
    """Fit the drives to a recording.

    Args:
        recorded: Of a robot that hangs, or whose feet and torso rest while head and arms move.
        base: Values that are not fitted.
        progress: Called with the number of simulations.

    Returns:
        The fit, and the part of the recording that it uses.

    Raises:
        ConfigurationError: only sensors are recorded, the torso moves, or no joint moves by itself.
    """
    if not (recorded.commanded and recorded.has_angles):
        raise ConfigurationError(
            "Only sensors were recorded; identification needs the command and the angle of each joint, as "
            "`nao-hil excite` records them."
        )
    tilt = recorded.signals.angle
    if np.isfinite(tilt).all() and np.ptp(tilt, axis=0).max() > STEADY:
        raise ConfigurationError(
            f"The torso tilts by {math.degrees(np.ptp(tilt, axis=0).max()):.0f} degrees in this recording; "
            "identification needs a robot that hangs still or stands still, as `nao-hil excite` moves it."
        )
    signals = _under_command(recorded.body, recorded.signals)
    return fit(recorded.body, signals, base.servo, progress), signals


def parameters(body: Body, found: Fit) -> dict[str, Estimate]:
    """The fitted values, and the stiffness of each group of joints, with intervals."""
    count = len(found.names)
    values = {
        name: _identified(found, float(found.values[i]), np.eye(count)[i]) for i, name in enumerate(found.names)
    }
    loop, gear = found.names.index("full_voltage_error"), found.names.index("gear_compliance")
    for name in found.names:
        _, _, group = name.partition(".")
        if group:
            gradient = np.zeros(count)
            gradient[loop] = 1.0 / joint_stall_torque(body, joints_of(group, found.joints)[0])
            gradient[gear] = 0.5 if group == "HipYawPitch" else 1.0  # one motor, two gears side by side
            compliance = float(gradient @ found.values)
            stiffness = 1.0 / compliance
            values[f"stiffness.{group}"] = _identified(found, stiffness, -gradient * stiffness**2)
    return values


def result(
    recorded: RecordedSignals, found: Fit, signals: Signals, base: WearProfile, recording: str, profile: str
) -> Identification:
    """The JSON.

    Args:
        recorded: The recording.
        found: Fit to it.
        signals: The part of it in use.
        base: The rest.
        recording: Its file.
        profile: File of the profile.
    """
    identified = parameters(recorded.body, found)
    if recorded.own_clock:  # only the sum of delay and offset is known
        del identified["delay"]
    return Identification(
        recording=recording,
        robot=recorded.body.name,
        base=base.name,
        profile=profile,
        confidence=CONFIDENCE,
        notes=recorded.notes,
        seconds=float(signals.time[-1]),
        parameters=identified,
        assumed=tuple(_assumed(list(identified))),
        residual={joint: _residual(found, signals, i) for i, joint in enumerate(found.joints)},
    )


def _identified(found: Fit, value: float, gradient: Array) -> Estimate:
    return Estimate(value=value, interval=found.interval(value, gradient))


def _residual(found: Fit, signals: Signals, column: int) -> float | None:
    used = found.samples[:, column] > 0.0
    error = signals.position[used, INDEX[found.joints[column]]] - found.predicted[used, column]
    return float(np.sqrt(np.mean(np.square(error)))) if used.any() else None


def _assumed(fitted: Sequence[str]) -> list[str]:
    names = [name for name in ServoParameters.__struct_fields__ if name != "backlash"]
    names += [f"backlash.{group}" for group in Backlash.__struct_fields__]
    return [name for name in names if name not in fitted]


def _under_command(body: Body, signals: Signals) -> Signals:
    """From where every joint has a command; one that never has holds its first angle, an absent one is at 0."""
    absent = absent_joints(body)
    present = [number for number, joint in enumerate(JOINTS) if joint not in absent]
    known = np.isfinite(signals.command[:, present])
    ever = known.any(axis=0)
    signals = signals.part(slice(int(known[:, ever].all(axis=1).argmax()), None))
    position = np.nan_to_num(signals.position)
    command = np.where(np.isfinite(signals.command), signals.command, position[0])
    position[:, [number for number in range(len(JOINTS)) if number not in present]] = 0.0
    stiffness = np.where(np.isfinite(signals.stiffness), signals.stiffness, 1.0)
    return replace(signals, position=position, command=command, stiffness=stiffness)


def write_profile(path: Path, found: Identification, base: WearProfile) -> None:
    """Write the profile; `--wear FILE` loads it.

    Args:
        path: Of the file, .toml.
        found: The identified values.
        base: All others.

    Raises:
        ConfigurationError: the file cannot be written.
    """
    rest = msgspec.toml.encode(
        {"servo": {"heating": base.servo.heating}, "sensors": msgspec.to_builtins(base.sensors)}
    ).decode()
    lines = [
        f'name = "{path.stem}"',
        "",
        f"# A {found.robot}, fitted by `nao-hil identify` to {Path(found.recording).name}. SI and radians.",
        f"# Intervals have {found.confidence:.0%} confidence; what is assumed is that of `{base.name}`.",
        "[servo]",
        *(_line(name, getattr(base.servo, name), found) for name in _plain()),
        "",
        "[servo.backlash]  # whole width",
        *(
            _line(group, getattr(base.servo.backlash, group), found, "backlash.")
            for group in Backlash.__struct_fields__
        ),
        "",
        f"# assumed: as {base.name}, all of the rest",
        rest.strip(),
    ]
    write_text(path, "\n".join(lines) + "\n")


def _plain() -> list[str]:
    return [name for name in ServoParameters.__struct_fields__ if name not in ("backlash", "heating")]


def _line(name: str, value: float, found: Identification, prefix: str = "") -> str:
    identified = found.parameters.get(prefix + name)
    if identified is None:
        return f"{name} = {value!r}  # assumed"
    low, high = identified.interval
    if prefix:
        where = f"{math.degrees(low):.2f} to {math.degrees(high):.2f} deg"
    else:
        where = f"{low:.4g} to {high:.4g} {KINDS[name].unit.replace('ms', 's')}"
    return f"{name} = {identified.value:.6g}  # identified: {where}"
