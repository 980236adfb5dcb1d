"""Fingerprint of a walk, and its row in a data set."""

from __future__ import annotations

import hashlib
import json
from datetime import datetime, timezone
from typing import Any

import msgspec

from bridge.body import load_body
from emulator.wear import load_wear
from nao_hil.runs.fingerprint import fingerprint, library_versions, source_hash
from nao_hil.runs.walk import Ending, Walk, WalkEnd, WalkOutcome
from walker.gaits.catalogue import policy_files


def key(walk: Walk) -> str:
    """Fingerprint of a walk: configuration, seed, world, contents of body, wear and policy; not its name."""
    body = walk.body or load_body(walk.config.robot)
    wear = walk.wear or load_wear(walk.config.wear, body)
    config = msgspec.structs.replace(walk.config, robot="", wear="")
    gaits = (config.gait, *(other.gait for other in walk.neighbours))
    policy = [hashlib.sha256(file.read_bytes()).hexdigest() for gait in gaits for file in policy_files(gait)]
    walk = msgspec.structs.replace(walk, name="", config=config, body=None, wear=None)
    return fingerprint(walk, body, wear, *policy)


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One walk; SI units and radians."""

    key: str
    """Fingerprint of all that the walk depends on; there is one row of a key."""
    configuration_hash: str
    """Hash of the configuration, the same for all seeds."""
    name: str
    """For people: experiment and condition that walked it first."""
    robot: str
    wear: str
    gait: str
    seed: int
    duration: float
    """Asked for, s."""
    scenario: str
    """Title of the world."""
    configuration: str
    """JSON of the whole walk but its name and seed."""
    sources: str
    """SHA-256 of the sources that a walk runs."""
    versions: str
    """JSON: Python, machine, libraries."""
    ending: Ending
    survived: bool
    time: float
    """Time of the fall, or of the end, in the time of the walk, s."""
    steps: int
    distance: float
    speed: float
    roll: float
    pitch: float
    tilt_max: float
    track: bool
    """Its track is in `tracks/KEY.npz`."""
    seconds: float
    """Wall time of the walk, s."""
    made: str
    """UTC."""

    @property
    def end(self) -> WalkEnd:
        """The end of a walk."""
        return msgspec.convert({name: getattr(self, name) for name in WalkEnd.__struct_fields__}, WalkEnd)


def row(result: WalkOutcome, seconds: float) -> Row:
    """The row of a walk.

    Args:
        result: The walk.
        seconds: Wall time that it took.
    """
    task, config = result.walk, result.walk.config
    words = _configuration(task)
    return Row(
        key=key(task),
        configuration_hash=hashlib.sha256(words.encode()).hexdigest()[:32],
        name=task.name,
        robot=config.robot,
        wear=config.wear,
        gait=config.gait,
        seed=config.seed,
        duration=task.duration,
        scenario=task.scenario.title,
        configuration=words,
        sources=source_hash(),
        versions=json.dumps(dict(library_versions())),
        speed=result.end.speed,
        survived=result.end.survived,
        track=task.keep_track,
        seconds=seconds,
        made=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        **msgspec.structs.asdict(result.end),
    )


def _configuration(task: Walk) -> str:
    table = _fields(task)
    table["config"] = _fields(task.config)
    del table["name"], table["config"]["seed"]
    return json.dumps(table, sort_keys=True, default=_fields)


def _fields(struct: msgspec.Struct) -> dict[str, Any]:
    """All fields: `to_builtins` omits a scenario's defaults by identity, which a worker's copy has lost."""
    config = struct.__struct_config__
    tag = {config.tag_field: config.tag} if config.tag_field else {}
    return {**tag, **msgspec.structs.asdict(struct)}
