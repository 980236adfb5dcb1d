"""Usage: python -m tests.chaos SECONDS [--seed N] [--engine mujoco|pybullet]; exit code 1 with a violation."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import msgspec

from tests.chaos.driver import Chaos, Report

DISK = "400m"
"""Size of the disk that is filled."""


def rough(seconds: float, seed: int, engine: str) -> Report:
    """One rough test, on a disk of its own where this user may mount one.

    Args:
        seconds: of the clock.
        seed: of the events.
        engine: of the robots.
    """
    with tempfile.TemporaryDirectory(prefix="chaos-") as name:
        mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "tmpfs", name]
        mounted = subprocess.run(mount, capture_output=True, check=False).returncode == 0
        try:
            return Chaos(Path(name), seed, engine).run(seconds)
        finally:
            if mounted:
                subprocess.run(["umount", "--lazy", name], check=True)


def main() -> None:
    """Run one, print its report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seconds", type=float)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engine", default="mujoco", choices=("mujoco", "pybullet"))
    given = parser.parse_args()
    report = rough(given.seconds, given.seed, given.engine)
    print(msgspec.json.format(msgspec.json.encode(report), indent=1).decode(), flush=True)
    sys.exit(1 if report.violations else 0)


if __name__ == "__main__":
    main()
