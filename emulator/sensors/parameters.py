"""What makes the sensors differ from the truth; every default is ideal."""

from __future__ import annotations

import msgspec


class SensorParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Imperfections of encoders, force sensors and the inertial unit."""
