"""The folder of a run: configuration, versions, recording with its robot's shapes, summary."""

from __future__ import annotations

import json
import os
import platform
import re
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final, cast

import msgspec

from bridge.body import Body, load_body
from bridge.errors import ConfigurationError
from bridge.recording.foxglove import RobotScene
from bridge.recording.recorder import later_file
from emulator.engine.catalogue import ENGINES
from emulator.scenarios import Scenario, load_scenario
from emulator.wear import load_wear
from nao_hil.files import write_bytes, write_text
from nao_hil.runs.config import FILES, RunConfig, is_path
from nao_hil.runs.fingerprint import kernels, package_version

try:
    import fcntl
except ModuleNotFoundError:  # no POSIX system: folders are not locked
    fcntl = None  # type: ignore[assignment]

_RESULT: Final = re.compile(r"summary\.json|frames(-\d+)?\.mcap")
"""Files of a run that do not exist before it."""
RECORDING: Final = "frames.mcap"
_LOADERS: Final[dict[str, Callable[[str], msgspec.Struct]]] = {
    "robot": load_body,
    "wear": load_wear,
    "scenario": load_scenario,
}
"""Loaders of `FILES`."""
PACKAGES: Final = ("nao-hil", *ENGINES, "numba", "numpy", "scipy", "eclipse-zenoh", "msgspec")


def recording_of(run: Path) -> Path:
    """The recording in a run's folder; any other path counts as a recording's.

    Raises:
        ConfigurationError: the folder is that of a world, whose robots have a folder each.
    """
    if not run.is_dir():
        return run
    own = run / RECORDING
    if not own.exists() and (robots := sorted(found.parent.name for found in run.glob(f"*/{RECORDING}"))):
        raise ConfigurationError(
            f"{run} is the run of a world, with a folder for each robot: {', '.join(robots)}; give "
            f"{run / robots[0]}."
        )
    return own


def run_name(recording: Path) -> str:
    """Name of a recorded run: of its folder, or of a recording with a name of its own."""
    return recording.resolve().parent.name if recording.name == RECORDING else recording.stem


class RunDirectory:
    """`runs/<time>/`, or the requested folder.

    Args:
        out: folder to use; made if it is not there. None: a new one under `runs/`, named by the time in UTC.

    Raises:
        ConfigurationError: the folder cannot be made.
    """

    def __init__(self, out: Path | None) -> None:
        self._held: int | None = None
        """Descriptor of the folder with a lock on it, for as long as this process lives."""
        try:
            self.path = out if out is not None else _fresh(Path("runs"))
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigurationError(
                f"{error.filename}: the folder of the run cannot be made ({error.strerror}); give a writable "
                "one with --out."
            ) from None

    @property
    def recording(self) -> Path:
        """All frames of the run, up to its first reset."""
        return self.path / RECORDING

    def last_recording(self, resets: int) -> Path:
        """All frames since the last of so many resets."""
        return later_file(self.recording, resets + 1)

    @property
    def config(self) -> Path:
        """The run's configuration, which `--config` takes back."""
        return self.path / "config.toml"

    def clear(self, *, overwrite: bool) -> None:
        """Take the folder for a run of this process.

        Args:
            overwrite: remove the recordings and the summary of an earlier run.

        Raises:
            ConfigurationError: another process has it for a run, or an earlier run is in it.
        """
        self.release()
        if fcntl is not None:
            self._lock()
        left = [path for path in self.path.iterdir() if _RESULT.fullmatch(path.name)]
        if left and not overwrite:
            self.release()
            raise ConfigurationError(
                f"{self.path}: holds a run already ({left[0].name}); give another folder with --out, or "
                "replace the run with --overwrite."
            )
        for path in left:
            path.unlink()

    def _lock(self) -> None:
        self._held = os.open(self.path, os.O_RDONLY)
        try:
            fcntl.flock(self._held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.release()
            raise ConfigurationError(
                f"{self.path}: a run that goes on writes into this folder; give another one with --out."
            ) from None
        except OSError:  # a file system without locks
            pass

    def release(self) -> None:
        """Give the folder to another process."""
        if self._held is not None:
            os.close(self._held)
            self._held = None

    def write_config(self, settings: msgspec.Struct | dict[str, Any]) -> None:
        """Write the configuration, the versions of the software and the robot's own files.

        A data sheet, a wear profile or a scenario that is a file is copied, and the configuration names the
        copy: the run can be repeated when the file has changed or the folder is elsewhere.

        Raises:
            ConfigurationError: one of these files cannot be read or is wrong.
        """
        if isinstance(settings, RunConfig):
            settings = self._with_copies(settings)
        write_bytes(self.config, msgspec.toml.encode(settings))
        write_text(self.path / "versions.json", json.dumps(versions(), indent=2) + "\n")

    def _with_copies(self, config: RunConfig) -> RunConfig:
        files = [field for field in FILES if is_path(getattr(config, field))]
        read = {field: _LOADERS[field](getattr(config, field)) for field in files}  # refuses a wrong file
        for field in files:
            if field == "scenario":
                self.write_scenario(cast(Scenario, read[field]))  # a heightfield's file is elsewhere
            else:
                write_bytes(self.path / f"{field}.toml", Path(getattr(config, field)).read_bytes())
        return msgspec.structs.replace(config, **{field: f"{field}.toml" for field in files})

    def write_scenario(self, scenario: Scenario) -> None:
        """Write the world in full, given heights of a heightfield as a CSV file of their own."""
        field = scenario.heightfield
        if field is not None and field.heights:
            rows = (",".join(map(repr, row)) for row in field.heights)
            write_text(self.path / "heights.csv", "\n".join(rows) + "\n")
            field = msgspec.structs.replace(field, heights=(), file="heights.csv")
            scenario = msgspec.structs.replace(scenario, heightfield=field)
        write_bytes(self.path / "scenario.toml", msgspec.toml.encode(scenario))

    def write_summary(self, summary: dict[str, Any]) -> None:
        """Write the result of the run."""
        write_text(self.path / "summary.json", json.dumps(summary, indent=2) + "\n")


def name_of_now() -> str:
    """Name of the folder of a run that begins now."""
    return time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())


def _fresh(parent: Path) -> Path:
    stem = name_of_now()
    for suffix in ("", *(f"-{n}" for n in range(2, 1000))):
        path = parent / f"{stem}{suffix}"
        try:
            path.mkdir(parents=True)
        except FileExistsError:
            continue
        return path
    raise ConfigurationError(f"{parent}: a thousand runs began within one second; give a folder with --out.")


def versions() -> dict[str, str]:
    """Versions of Python, the platform, the packages a result depends on, and their kernels."""
    known = {"python": sys.version.split()[0], "platform": platform.platform()} | kernels()
    return known | {package: package_version(package) for package in PACKAGES}


def describe(body: Body) -> str:
    """The robot as URDF; friction is that of nominal drives."""
    # Imported late: the shapes of the links take time.
    from emulator.export.urdf import to_urdf
    from emulator.wear import load_wear

    return to_urdf(body, load_wear("nominal", body), f"{body.name}, by nao-hil")


def robot_scene(body: Body) -> Callable[[], RobotScene]:
    """Makes the scene of each file of a recording."""
    return partial(RobotScene, body, describe(body))
