"""Where the values of an ensemble lie in their ranges."""

import math

from emulator.wear.ensemble import Unknown


def share(unknown: Unknown, value: float) -> float:
    """The share of the range at which a value lies: the inverse of `Unknown.at`."""
    if unknown.log:
        return math.log(value / unknown.low) / math.log(unknown.high / unknown.low)
    return (value - unknown.low) / (unknown.high - unknown.low)
