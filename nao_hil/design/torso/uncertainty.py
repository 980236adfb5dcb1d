"""Plants that differ from the identified one, and the worst figures of a design on them."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import control
import numpy as np

from nao_hil.design.torso.assembly import TorsoDesign, assemble


@dataclass(frozen=True, slots=True)
class WorstCase:
    """The worst of several plants under one controller; each figure may come from another plant."""

    stable: bool
    """On every plant."""
    overshoot: float
    gain_margin: float
    """Nearest to 1; 1 if a plant is unstable."""


def perturbed(
    plant: control.TransferFunction, frequency: float, damping: float, zero: float
) -> control.TransferFunction:
    """The plant with its poles and zeros moved and its steady-state gain kept.

    Args:
        plant: continuous.
        frequency: factor on the natural frequency of every pole.
        damping: factor on the damping ratio of every complex pole pair (real poles have none).
        zero: factor on every zero.
    """
    poles = plant.poles() * frequency
    moved = []
    for pole in poles:
        size, ratio = abs(pole), -pole.real / abs(pole)
        if pole.imag != 0.0:
            ratio = min(1.0, ratio * damping)
            pole = size * complex(-ratio, math.copysign(math.sqrt(1.0 - ratio**2), pole.imag))
        moved.append(pole)
    zeros = plant.zeros() * zero
    # Constant terms are kept at 1 each, so the ratio of the polynomials is the steady-state gain.
    top = np.real(np.poly(zeros)) if len(zeros) else np.array([1.0])
    bottom = np.real(np.poly(np.array(moved))) if moved else np.array([1.0])
    return control.tf(float(np.real(plant.dcgain())) * top / top[-1], bottom / bottom[-1])


def corners(plant: control.TransferFunction, spread: float) -> list[control.TransferFunction]:
    """The plant itself, then the eight with frequency, damping and zero each off by `spread`.

    Args:
        plant: continuous.
        spread: relative uncertainty, 0 to 1.
    """
    return [plant, *perturbations(plant, (1.0 - spread, 1.0 + spread))]


def perturbations(
    plant: control.TransferFunction, factors: tuple[float, ...]
) -> list[control.TransferFunction]:
    """The plant with every combination of `factors` on frequency, damping and zero.

    Args:
        plant: continuous.
        factors: each applied to each of the three.
    """
    return [perturbed(plant, *combination) for combination in itertools.product(factors, repeat=3)]


def worst_case(design: TorsoDesign, plants: list[control.TransferFunction]) -> WorstCase:
    """The worst figures of a design's controller over several plants.

    Args:
        design: of the controller.
        plants: continuous.
    """
    sample_time = design.controller.sample_time
    results = [assemble(plant, design.notch_q, design.pi, sample_time) for plant in plants]
    stable = all(result.stable for result in results)
    return WorstCase(
        stable=stable,
        overshoot=max(result.step.overshoot for result in results),
        gain_margin=min(max(m, 1.0 / m) for m in (r.margins.gain_margin for r in results)) if stable else 1.0,
    )
