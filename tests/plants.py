"""Plants for tests of the torso design."""

from __future__ import annotations

import control


def second_order_plant(
    natural_frequency: float, damping: float, zero: float, gain: float = 1.0
) -> control.TransferFunction:
    """Plant of the form (4.12), in the thesis' sign; natural frequency and zero in rad/s."""
    denominator = [1.0 / natural_frequency**2, 2.0 * damping / natural_frequency, 1.0]
    return control.tf([-gain / zero, gain], denominator)
