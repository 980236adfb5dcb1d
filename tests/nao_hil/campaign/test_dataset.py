"""The data set: what was put is found, whoever was killed when; no walk has two rows."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from itertools import takewhile
from pathlib import Path

import msgspec
import numpy as np
import pyarrow.parquet as pq
import pytest

from emulator.scenarios import load_scenario
from nao_hil.runs.config import RunConfig
from nao_hil.runs.dataset import Dataset, row
from nao_hil.runs.run import Table
from nao_hil.runs.store import key
from nao_hil.runs.walk import NO_TRACK, Walk, WalkEnd, WalkOutcome
from tests.made_walks import made_track

TRACK = made_track({"time": [0.01, 0.02, 0.03], "walk/telemetry.phase": ["start", "DSL", "SSL"]})
WRITERS = """
import os, sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_dataset import outcome
from nao_hil.runs.dataset import Dataset
for _ in sys.stdin:
    pid = os.fork()  # a writer that need not import everything
    if pid == 0:
        print(os.getpid(), flush=True)
        kept = Dataset(Path(sys.argv[1]), rows=7)
        for seed in range(100000):
            kept.put(outcome(seed), 0.1)
            print(seed, flush=True)
    os.waitpid(pid, 0)
    print("killed", flush=True)
"""
"""For each line, a process that puts walks until it is killed."""


def outcome(seed: int, track: Table | None = None) -> WalkOutcome:
    end = WalkEnd(ending="fell", time=1.5, roll=0.1, pitch=-0.2, steps=3, distance=0.25, tilt_max=0.3)
    task = Walk(name="a", config=RunConfig(seed=seed), duration=2.0, keep_track=track is not None)
    return WalkOutcome(task, end, NO_TRACK if track is None else track)


def keys_on_disk(folder: Path) -> list[str]:
    return [each for part in folder.glob("part-*.parquet") for each in pq.read_table(part)["key"].to_pylist()]


@pytest.mark.parametrize("rows", [2, 100])
def test_what_was_put_is_found_in_the_journal_and_in_the_parts(tmp_path: Path, rows: int) -> None:
    put = [outcome(0, TRACK), *(outcome(seed) for seed in range(1, 5))]
    asked = {key(each.walk): each.walk for each in put}
    other = outcome(9).walk
    kept = Dataset(tmp_path, rows=rows)
    for each in put:
        kept.put(each, 0.1)
    for found in (kept.find(asked | {key(other): other}), Dataset(tmp_path).find(asked)):
        if not found:  # the journal belongs to a writer that lives
            continue
        assert found.keys() <= asked.keys()
        for k, each in found.items():
            assert (each.walk, each.end) == (asked[k], outcome(0).end)
    kept.close()
    found = Dataset(tmp_path).find(asked)
    assert found.keys() == asked.keys()
    for name, values in found[key(put[0].walk)].track.items():
        np.testing.assert_array_equal(values, TRACK[name])
    assert sorted(keys_on_disk(tmp_path)) == sorted(asked)
    assert not list((tmp_path / "journal").iterdir())


def test_a_walk_that_two_writers_put_has_one_row(tmp_path: Path) -> None:
    first, second = Dataset(tmp_path), Dataset(tmp_path)
    for kept in (first, second, first):
        kept.put(outcome(0), 0.1)
    second.put(outcome(1), 0.1)
    first.close()
    second.close()
    assert sorted(keys_on_disk(tmp_path)) == sorted(key(outcome(seed).walk) for seed in (0, 1))


def test_a_writer_that_was_killed_loses_no_row_and_doubles_none(tmp_path: Path) -> None:
    folder, here = tmp_path / "walks", str(Path(__file__).parent)
    words = [sys.executable, "-c", WRITERS, str(folder), here]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as writers:
        assert writers.stdin is not None and writers.stdout is not None
        for killed_after in (3, 8, 14):
            writers.stdin.write("\n")
            writers.stdin.flush()
            pid = int(writers.stdout.readline())
            said = [int(writers.stdout.readline()) for _ in range(killed_after)]
            os.kill(pid, signal.SIGKILL)
            said += [int(line) for line in takewhile(lambda line: line != "killed\n", writers.stdout)]
            walks = [outcome(seed).walk for seed in range(said[-1] + 1)]
            assert len(Dataset(folder).find({key(walk): walk for walk in walks})) == len(walks)
            on_disk = keys_on_disk(folder)
            assert len(on_disk) == len(set(on_disk)) >= len(walks)


def test_a_walk_whose_track_is_spoilt_is_not_found(tmp_path: Path) -> None:
    kept, task = Dataset(tmp_path), outcome(0, TRACK).walk
    kept.put(outcome(0, TRACK), 0.1)
    (file,) = (tmp_path / "tracks").iterdir()
    file.write_bytes(file.read_bytes()[:100])
    assert not kept.find({key(task): task})
    kept.put(outcome(0, TRACK), 0.1)
    assert len(kept.find({key(task): task})) == 1
    kept.close()


def test_the_configuration_of_a_walk_that_a_worker_got_is_that_of_the_command() -> None:
    walk = msgspec.structs.replace(outcome(0).walk, scenario=load_scenario("obstacle"))
    end, track = outcome(0).end, outcome(0).track
    here, there = (row(WalkOutcome(each, end, track), 0.1) for each in (walk, pickle.loads(pickle.dumps(walk))))
    assert here.configuration_hash == there.configuration_hash
    assert json.loads(here.configuration)["scenario"]["floor"]["roll"] == 0.0  # a default is written
