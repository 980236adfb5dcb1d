"""Wear profiles: how far a robot's drives and sensors are from ideal, each effect a number.

A profile is a TOML file; an effect that it does not name stays ideal.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from bridge.body import Body
from bridge.config import load_toml
from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from emulator.wear.ensemble import ENSEMBLE, ensemble_member, wear_of_seed
from emulator.wear.profile import WearProfile

__all__ = ["WEAR", "WearProfile", "load_wear", "wear_of_seed"]

WEAR: Final = ("ideal", "nominal", "worn")
"""The profiles that come with the package, beside the members of ensembles."""


def load_wear(name_or_path: str, body: Body | None = None) -> WearProfile:
    """A shipped profile by name, a member of an ensemble (`ensemble:17`), or a profile from a TOML file.

    Args:
        name_or_path: Of the profile.
        body: Whose ensemble; not read for other profiles.

    Raises:
        ConfigurationError: no such profile, unknown key, or an impossible value.
    """
    if name_or_path in WEAR:
        return load_toml(Path(__file__).with_name(f"{name_or_path}.toml"), WearProfile)
    if name_or_path.partition(":")[0] == ENSEMBLE:
        return ensemble_member(name_or_path, body)
    if not name_or_path.endswith(".toml"):
        known = unknown_name("wear profile", name_or_path, (*WEAR, "ensemble:K"))
        raise ConfigurationError(f"{known}, or the path of a .toml file")
    return load_toml(Path(name_or_path), WearProfile)
