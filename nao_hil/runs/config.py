"""The configuration of a run: command line and `--config FILE`, checked together."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec

from bridge.config import from_dict, load_toml
from bridge.errors import ConfigurationError
from bridge.guard import GuardSettings
from bridge.types import Finite
from bridge.validation import unknown_name
from emulator.scenarios import START_NAMES

Engine = Literal["auto", "pybullet", "mujoco"]
Mode = Literal["real-time", "lockstep", "in-process"]


class RunConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A whole run, both sides of it. Written with every result; can be given back with `--config`."""

    robot: str = "nao-v3"
    """Body: a name of `nao-hil robots`, or the path of a data sheet."""
    wear: str = "nominal"
    """Wear profile: `ideal`, `nominal`, `worn`, `ensemble:K`, or the path of one."""
    engine: Engine = "auto"
    """Physics: `pybullet` or `mujoco`; `auto`: PyBullet where it is installed, else MuJoCo."""
    scenario: str = "flat"
    """World: a name of `nao-hil scenarios`, or the path of one."""
    start: str = ""
    """Pose to begin in: a name of `emulator.scenarios.START_NAMES`; empty: the scenario's."""
    recover: bool = False
    """Get up after a fall and walk on, on bodies that have motions for that."""
    gait: str = "omni"
    mode: Mode = "real-time"
    steps: Annotated[int, msgspec.Meta(ge=0)] = 10
    """Steps to walk, the closing step included; 0: no bound."""
    duration: Annotated[float, msgspec.Meta(ge=0.0)] = 0.0
    """Time to walk, s; 0: no bound."""
    velocity: tuple[Finite, ...] = ()
    """Forward and to the left, m/s, and turn, rad/s; empty: the gait's own."""
    target: tuple[Finite, ...] = ()
    """Target of the walk, from the robot's place: forward and to the left, m, and turn, rad; empty: none."""
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    parameters: dict[str, Any] = {}
    """Gait parameters that differ from the shipped ones."""
    controller: dict[str, Any] = {}
    """Controller parameters that differ from the gait's shipped ones: `switches` and other tables."""
    guard: GuardSettings = GuardSettings()
    """Bounds and times of the guard on the robot's side."""

    def __post_init__(self) -> None:
        """Raises ValueError for an unknown start, and for a velocity or a target that is no triple."""
        if self.start and self.start not in START_NAMES:
            raise ValueError(unknown_name("start pose", self.start, START_NAMES))
        if len(self.velocity) not in (0, 3):
            raise ValueError(f"velocity has {len(self.velocity)} numbers; it takes three: vx, vy, omega")
        if len(self.target) not in (0, 3):
            raise ValueError(f"target has {len(self.target)} numbers; it takes three: x, y, turn")


def run_config(
    file: Path | None,
    *,
    stabilizer: str | None = None,
    torso: str | None = None,
    admittance: bool | None = None,
    **options: Any,
) -> RunConfig:
    """The defaults, overridden by the file, overridden by the options that are not None.

    Paths become absolute: those in the file are relative to its folder, those of options to the working
    directory.

    Args:
        file: TOML.
        stabilizer: a named set of switches, `walker.switches.StabilizerName`.
        torso: torso control; into the table `controller.switches`, as the next.
        admittance: of legs and ankles.
        options: fields of `RunConfig`; a duration or a target without steps bounds the walk alone.

    Raises:
        ConfigurationError: unreadable file, unknown key, or an impossible value.
    """
    # imported late: help and completion need not wait for the walk
    from walker.gaits.catalogue import gait_kind
    from walker.parameters import merged
    from walker.switches import switch_changes

    base = _with_paths(load_toml(file, RunConfig), file.parent) if file else RunConfig()
    given = {k: v for k, v in options.items() if v is not None}
    if given.get("duration") or given.get("target"):
        given.setdefault("steps", 0)
    given["controller"] = merged(base.controller, switch_changes(stabilizer, torso, admittance))
    config = from_dict(msgspec.to_builtins(base) | given, "options", RunConfig)
    try:
        gait_kind(config.gait)
    except ConfigurationError as error:
        where = "options" if "gait" in given else str(file)
        raise ConfigurationError(f"{where}: {error}") from None
    config = _with_paths(config, Path())
    if config.steps == 1:
        raise ConfigurationError(
            "options: steps is 1; a walk has at least 2, one out and one to close the feet."
        )
    return config


FILES: Final = ("robot", "wear", "scenario")
"""Fields of `RunConfig` that may be the path of a file."""


def is_path(name_or_path: str) -> bool:
    """Whether one of `FILES` is the path of a file, and not a name."""
    path = Path(name_or_path)
    return path.suffix == ".toml" or path.name != name_or_path


def _with_paths(config: RunConfig, folder: Path) -> RunConfig:
    """The configuration with absolute paths, given those relative to a folder."""
    prefix, is_sheet, sheet = config.gait.partition("onnx:")
    if is_sheet and not prefix and is_path(sheet):
        config = msgspec.structs.replace(config, gait=f"onnx:{(folder / sheet).absolute()}")
    paths = {f: str((folder / value).absolute()) for f in FILES if is_path(value := getattr(config, f))}
    return msgspec.structs.replace(config, **paths)
