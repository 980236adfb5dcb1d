"""The wear profile of an identified robot, as a file that says where each number is from."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec

from emulator.servo.parameters import Backlash, ServoParameters
from emulator.wear import WearProfile
from nao_hil.files import write_text
from nao_hil.identification.identification import Identification

_UNITS = {
    "delay": "s",
    "full_voltage_error": "rad",
    "gear_compliance": "rad/(N m)",
    "dry_friction": "N m",
    "lead": "s",
    "motor_time_constant": "s",
    "gear_relaxation": "s",
}


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
        where = f"{low:.4g} to {high:.4g} {_UNITS[name]}"
    return f"{name} = {identified.value:.6g}  # identified: {where}"
