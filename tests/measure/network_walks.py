"""Walks over an emulated network: robot and walker as two processes in two network namespaces, in real time."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import msgspec

from bridge.body import load_body
from bridge.errors import ConfigurationError, LinkError
from emulator.wear import load_wear
from nao_hil.runs.config import RunConfig
from nao_hil.runs.fingerprint import PROCESSES, fingerprint
from nao_hil.runs.supervisor import Child
from tests.measure.site import ROBOT_ADDRESS, NetworkConditions, Site

ENDPOINT: Final = f"tcp/{ROBOT_ADDRESS}:7447#open"
END_TIMEOUT: Final = 30.0
"""s for a side to end by itself, with a link whose queue is still full."""


class NetworkWalk(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a walk over a bad network."""

    done: bool
    """The walker has made all its steps and stands."""
    fell: bool
    stopped: bool
    """The walker closed its feet because the link exceeded the gait's delay."""
    steps: int
    distance: float
    """m"""
    torso_max: float
    """rad"""
    cycles: int
    missed: int
    """Cycles with a late or no answer."""
    walker: str
    """The walker's last line of output; empty: it ended as ordered."""

    @property
    def success(self) -> bool:
        """Walked as ordered, and upright."""
        return self.done and not self.fell

    @property
    def note(self) -> str:
        """The end in a word."""
        if self.fell:
            return "fell"
        return "walked" if self.done else "stopped" if self.stopped else "gave up"


class Pair:
    """A robot and a walker at their places; both end with it.

    Args:
        site: where.
        folder: for logs and the recording.
        robot: further options of `nao-hil emulate`.
        walker: further options of `nao-hil walk`.
    """

    def __init__(self, site: Site, folder: Path, robot: Sequence[str], walker: Sequence[str]) -> None:
        self._site, self._folder = site, folder
        self._options = list(robot), list(walker)
        self._starts = 0
        self.robot = self.start_robot()
        self.walker = self.start_walker()

    def start_robot(self) -> Child:
        """Start the robot, again if it has ended; each start has its own folder."""
        self._starts += 1
        self.recordings = [self._folder / f"robot-{n + 1}" / "frames.mcap" for n in range(self._starts)]
        out = self.recordings[-1].parent
        out.mkdir(parents=True, exist_ok=True)
        common = ["--listen", ENDPOINT, "--out", str(out), "--json"]
        self.robot = Child("robot", ["emulate", *common, *self._options[0]], out, self._site.robot)
        return self.robot

    def start_walker(self) -> Child:
        """Start the walker, again if it has ended."""
        out = self._folder / "walker"
        out.mkdir(parents=True, exist_ok=True)
        common = ["--connect", ENDPOINT, "--json"]
        self.walker = Child("walker", ["walk", *common, *self._options[1]], out, self._site.walker)
        return self.walker

    def wait(self, timeout: float, stop: Callable[[], bool] = lambda: False) -> bool:
        """Wait until the walker ends (True), the robot ends, `stop()`, or `timeout` s are over."""
        deadline = time.monotonic() + timeout
        while self.walker.running and self.robot.running and time.monotonic() < deadline and not stop():
            time.sleep(0.05)
        return not self.walker.running

    def end(self) -> NetworkWalk:
        """End both on a good link, and return the result.

        Raises:
            LinkError: a side failed; with its last output.
            ConfigurationError: a side refused its configuration.
        """
        self._site.link.set(NetworkConditions())
        self.walker.ask_to_end()
        walker = self.walker.end(END_TIMEOUT)
        robot = self.robot.end(END_TIMEOUT)
        for who, side in (("robot", robot), ("walker", walker)):
            if side.code == 2:
                raise ConfigurationError(side.error)
            if side.result is None and who == "robot":
                raise LinkError(f"the {who}'s process failed: {side.error}")
        assert robot.result is not None
        reported = walker.result or {"done": False, "fell": False, "late": False}  # it did not end in time
        return NetworkWalk(
            done=bool(reported["done"] and not reported["fell"]),
            stopped=bool(reported["late"]),
            fell=bool(robot.result["fell"]),
            steps=int(robot.result["steps"]),
            distance=float(robot.result["distance"]),
            torso_max=float(robot.result["torso_max"]),
            cycles=int(robot.result["cycles"]),
            missed=int(robot.result["cycles_missed"]),
            walker=walker.error if walker.code else "",
        )

    def __enter__(self) -> Pair:
        return self

    def __exit__(self, *_: object) -> None:
        for child in (self.walker, self.robot):
            if child.running:
                child.kill()


def walk_key(changes: RunConfig) -> str:
    """Fingerprint of walks as processes: contents of body and wear profile, the engine, and all sources."""
    body = load_body(changes.robot)
    return fingerprint(body, load_wear(changes.wear, body), changes.engine, sources=PROCESSES)


def options(configuration: RunConfig, gait: str, seed: int, steps: int) -> tuple[list[str], list[str]]:
    """Options of both commands: robot, wear and engine as configured."""
    robot = ["--robot", configuration.robot, "--wear", configuration.wear, "--engine", configuration.engine]
    return [*robot, "--seed", str(seed)], ["--gait", gait, "--steps", str(steps)]
