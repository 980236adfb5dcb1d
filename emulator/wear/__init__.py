"""Wear profiles: deviations of a robot's drives and sensors from ideal, each effect a number.

A profile is a TOML file; an effect that it does not name stays ideal. Tables `generation.NAME` change it for
the bodies whose names begin so.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from bridge.body import Body
from bridge.config import from_dict
from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from emulator.wear.ensemble import ENSEMBLE, WearProfile, ensemble_member, read_profile, wear_of_seed

__all__ = ["WEAR", "WearProfile", "load_wear", "wear_of_seed"]

WEAR: Final = ("ideal", "nominal", "worn")
"""The profiles of the package, without the members of ensembles."""


def load_wear(name_or_path: str, body: Body | None = None) -> WearProfile:
    """A shipped profile by name, a member of an ensemble (`ensemble:17`), or a profile from a TOML file.

    Args:
        name_or_path: Of the profile.
        body: Of the robot: generations differ, and each has its own ensemble.

    Raises:
        ConfigurationError: no such profile, unknown key, or an impossible value.
    """
    if name_or_path in WEAR:
        return _load(Path(__file__).with_name(f"{name_or_path}.toml"), body)
    if name_or_path.partition(":")[0] == ENSEMBLE:
        return ensemble_member(name_or_path, body)
    if not name_or_path.endswith(".toml"):
        known = unknown_name("wear profile", name_or_path, (*WEAR, "ensemble:K"))
        raise ConfigurationError(f"{known}, or the path of a .toml file")
    return _load(Path(name_or_path), body)


def _load(path: Path, body: Body | None) -> WearProfile:
    return from_dict(read_profile(path, body), str(path), WearProfile)
