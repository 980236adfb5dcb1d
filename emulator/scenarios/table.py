"""Base of a scenario's tables, and the ranges of their values."""

from __future__ import annotations

from typing import Annotated

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0.0, le=1000.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0, le=1e6)]
Slope = Annotated[float, msgspec.Meta(ge=-34.0, le=34.0)]
Degrees = Annotated[float, msgspec.Meta(ge=-360.0, le=360.0)]
Seed = Annotated[int, msgspec.Meta(ge=0)]
Plane = tuple[Positive, Positive]
Size = tuple[Positive, Positive, Positive]


class ScenarioTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """Base: frozen, a misspelt key is an error, and a default is not written."""
