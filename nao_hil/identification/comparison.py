"""Differences of a recorded and the emulated robot under the same commands, in numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import JOINTS
from bridge.body.quantities import HANDS, absent_joints
from bridge.types import Array
from nao_hil.identification import measures
from nao_hil.identification.leg_model import LegModelComparison
from nao_hil.identification.readings import NAMES, Signals
from nao_hil.identification.recorded import EncoderGrid
from nao_hil.identification.sensors_only import FusedAngleComparison

SENSORS: Final = ("gyroscope", "accelerometer", "fsr")
"""Signals that are compared by mean, RMS and spectrum."""


class JointFollowing(msgspec.Struct, frozen=True, kw_only=True):
    """How a joint followed its command."""

    tracking_error: float
    """RMS, rad."""
    delay: float | None
    """s; None: the joint does not move."""
    hysteresis: float | None
    """Width, rad; None: no slow motion to and fro."""


class JointComparison(msgspec.Struct, frozen=True, kw_only=True):
    """One joint of both robots."""

    joint: str
    difference: float
    """RMS of the angle recorded less that of the replay, rad."""
    floor: float
    """The same between two replays with different seeds, at least one step of the encoder, rad."""
    excess: float
    """Difference beyond the noise floor, rad."""
    recorded: JointFollowing
    replayed: JointFollowing


class SensorComparison(msgspec.Struct, frozen=True, kw_only=True):
    """One axis or force cell of both robots, in the sensor's unit."""

    sensor: str
    recorded_mean: float
    replayed_mean: float
    recorded_rms: float
    """About the mean."""
    replayed_rms: float
    floor_rms: float
    """RMS error of the second replay."""
    frequency: tuple[float, ...]
    """Frequencies of the spectra, Hz."""
    recorded_density: tuple[float, ...]
    """Units^2/Hz."""
    replayed_density: tuple[float, ...]


class Comparison(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil compare`."""

    recording: str
    config: dict[str, Any]
    """Configuration of the replay, with the seed."""
    notes: tuple[str, ...]
    """Conversions, assumptions, and signals that cannot be compared."""
    seconds: float
    """Duration of the comparison."""
    first: str
    """The joint that differs most; empty: none is beyond the noise floor."""
    joints: tuple[JointComparison, ...]
    """Those that differ most come first; none without commands."""
    sensors: tuple[SensorComparison, ...]
    fused_angle: FusedAngleComparison | None
    """None: gyroscope, accelerometer and fused angle were not all recorded."""
    encoder_grid: EncoderGrid
    leg_model: LegModelComparison | None = None
    """None: none was given."""

    @property
    def sentence(self) -> str:
        """The result in words."""
        if not self.joints:
            if self.fused_angle is None:
                return f"Joints are not compared; {len(self.sensors)} values of sensors are."
            worst = math.degrees(max(self.fused_angle.difference))
            return f"Joints are not compared; the fused angle differs by {worst:.2f} degrees RMS."
        if not self.first:
            return "No joint differs beyond the noise floor."
        most = math.degrees(self.joints[0].excess)
        return f"{self.first} differs most: {most:.2f} degrees RMS beyond the noise floor."


def compare(
    body: Body, recorded: Signals, replayed: Signals, again: Signals
) -> tuple[tuple[JointComparison, ...], tuple[SensorComparison, ...]]:
    """Measure both robots.

    Args:
        body: Data sheet.
        recorded: The recording.
        replayed: The emulated robot under its commands.
        again: The same with another seed: the difference of the two is the noise floor.
    """
    absent = (*absent_joints(body), *HANDS)  # differences count where there is a measurement
    quantum = 2.0 * math.pi / body.encoder_steps
    joints = [
        _joint(number, recorded, replayed, again, quantum)
        for number, name in enumerate(JOINTS)
        if name not in absent
        and np.isfinite(recorded.position[:, number]).all()
        and np.isfinite(recorded.command[:, number]).any()
    ]
    joints.sort(key=lambda joint: (-joint.excess, -joint.difference))
    return tuple(joints), tuple(_sensors(recorded, replayed, again))


def _joint(
    number: int, recorded: Signals, replayed: Signals, again: Signals, quantum: float
) -> JointComparison:
    angles = [signals.position[recorded.measured, number] for signals in (recorded, replayed, again)]
    difference = measures.rms(angles[0] - angles[1])
    floor = max(measures.rms(angles[1] - angles[2]), quantum)
    return JointComparison(
        joint=JOINTS[number],
        difference=difference,
        floor=floor,
        excess=math.sqrt(max(difference**2 - floor**2, 0.0)),
        recorded=_following(number, recorded),
        replayed=_following(number, replayed),
    )


def _following(number: int, signals: Signals) -> JointFollowing:
    known = np.isfinite(signals.command[:, number])
    begin = int(np.argmax(known))
    command, position = signals.command[begin:, number], signals.position[begin:, number]
    lag = measures.delay(command, position, signals.cycle)
    return JointFollowing(
        tracking_error=measures.tracking_error(command, position),
        delay=lag,
        hysteresis=None if lag is None else measures.hysteresis(command, position, signals.cycle, lag),
    )


def _sensors(recorded: Signals, replayed: Signals, again: Signals) -> Sequence[SensorComparison]:
    compared = []
    rows = recorded.measured
    highest = 0.5 * rows.mean() / recorded.cycle
    for name in SENSORS:
        for column, label in enumerate(NAMES[name]):
            values: list[Array] = [getattr(each, name)[:, column] for each in (recorded, replayed, again)]
            if not np.isfinite(values[0]).all() or not np.isfinite(values[1]).all():
                continue
            spectra = [measures.spectrum(each, recorded.cycle) for each in values[:2]]
            rms = [float(np.std(each[rows])) for each in values]
            shown = spectra[0][0] <= highest * (1.0 + 1e-9)
            compared.append(
                SensorComparison(
                    sensor=f"{name}.{label}",
                    recorded_mean=float(values[0][rows].mean()),
                    replayed_mean=float(values[1][rows].mean()),
                    recorded_rms=rms[0],
                    replayed_rms=rms[1],
                    floor_rms=rms[2],
                    frequency=tuple(spectra[0][0][shown].tolist()),
                    recorded_density=tuple(spectra[0][1][shown].tolist()),
                    replayed_density=tuple(spectra[1][1][shown].tolist()),
                )
            )
    return compared
