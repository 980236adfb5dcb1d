"""Results are made once for each key, and the key changes with everything that they depend on."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import grimp
import msgspec
import pytest

from nao_hil.runs import fingerprint
from nao_hil.runs.campaign import Campaign, Interrupted
from nao_hil.runs.config import RunConfig
from nao_hil.runs.fingerprint import IN_PROCESS, PROCESSES, ROOT, source_hash
from nao_hil.runs.store import key
from nao_hil.runs.walk import Walk
from tests.loops import TIMEOUT
from tests.measure.stored import stored

WALK = Walk(name="a", config=RunConfig(gait="dynamic"), duration=1.0)


def test_every_module_that_a_walk_imports_is_among_its_sources() -> None:
    graph = grimp.build_graph("bridge", "emulator", "walker", "nao_hil", cache_dir=None)
    reached = graph.find_upstream_modules("nao_hil.runs.walk") | {"nao_hil.runs.walk"}
    assert {"walker.controller", "emulator.robot", "nao_hil.runs.config", "nao_hil.runs.ground"} <= reached
    for module in reached - {"nao_hil"}:
        stem = ROOT / module.replace(".", "/")
        file = stem / "__init__.py" if stem.is_dir() else stem.with_suffix(".py")
        assert any(file.is_relative_to(ROOT / part) for part in IN_PROCESS), module


@pytest.mark.parametrize("parts", [IN_PROCESS, PROCESSES])
@pytest.mark.parametrize("file", ["nao_hil/runs/ground.py", "emulator/wear/worn.toml"])
def test_an_edit_of_any_source_changes_the_hash(tmp_path: Path, parts: tuple[str, ...], file: str) -> None:
    for part in {Path(each).parts[0] for each in parts}:
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    assert source_hash.__wrapped__(parts, tmp_path) == source_hash.__wrapped__(parts, ROOT)
    (tmp_path / file).write_text((tmp_path / file).read_text() + "\n# edited\n")
    assert source_hash.__wrapped__(parts, tmp_path) != source_hash.__wrapped__(parts, ROOT)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="these kernels are of x86-64")
@pytest.mark.parametrize("kernel", ["OPENBLAS_CORETYPE=Prescott", "GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-AVX2"])
def test_another_kernel_of_blas_or_libm_changes_the_key(kernel: str, monkeypatch: pytest.MonkeyPatch) -> None:
    name, _, value = kernel.partition("=")
    ask = "from nao_hil.runs.fingerprint import kernels; import json; print(json.dumps(kernels()))"
    here, other = (
        json.loads(subprocess.run([sys.executable, "-c", ask], env=env, capture_output=True, check=True).stdout)
        for env in (os.environ, os.environ | {name: value})
    )
    assert here["numerics"] == fingerprint.numerics() != other["numerics"]
    before = key(WALK)
    fingerprint.library_versions.cache_clear()
    monkeypatch.setattr(fingerprint, "numerics", lambda: other["numerics"])
    assert key(WALK) != before
    fingerprint.library_versions.cache_clear()


def test_the_key_has_the_whole_configuration_and_not_the_name(tmp_path: Path) -> None:
    assert key(msgspec.structs.replace(WALK, name="b")) == key(WALK)
    assert key(msgspec.structs.replace(WALK, duration=2.0)) != key(WALK)
    other = {
        "robot": "nao-v4",
        "wear": "ideal",
        "engine": "mujoco",
        "gait": "static",
        "seed": 1,
        "parameters": {"a": 1.0},
    }
    for field, value in (other | {"controller": {"switches": {"torso": "none"}}}).items():
        config = msgspec.structs.replace(WALK.config, **{field: value})
        assert key(msgspec.structs.replace(WALK, config=config)) != key(WALK), field


def test_the_key_has_the_contents_of_files_that_the_configuration_names(tmp_path: Path) -> None:
    sheet = tmp_path / "worn.toml"
    sheet.write_text((ROOT / "emulator/wear/worn.toml").read_text())
    walk = msgspec.structs.replace(WALK, config=msgspec.structs.replace(WALK.config, wear=str(sheet)))
    before = key(walk)
    sheet.write_text((ROOT / "emulator/wear/nominal.toml").read_text())
    assert key(walk) != before


class Found(msgspec.Struct, frozen=True):
    n: int


def test_a_result_is_made_once_for_each_key_and_a_broken_file_is_made_anew(tmp_path: Path) -> None:
    file, made = tmp_path / "walks" / "one" / "result.json", []

    def make() -> Found:
        made.append(1)
        return Found(len(made))

    assert stored(file, "a", Found, make) == stored(file, "a", Found, make) == Found(1)
    assert stored(file, "b", Found, make) == Found(2)
    file.write_bytes(file.read_bytes()[:-2])
    assert stored(file, "b", Found, make) == Found(3)


def test_watched_calls_come_in_order_and_as_many_at_once_as_there_are_workers() -> None:
    at_once, most, lock, both = 0, 0, threading.Lock(), threading.Barrier(2)

    def call(seconds: float) -> float:
        nonlocal at_once, most
        with lock:
            at_once += 1
            most = max(most, at_once)
        if seconds in pauses[:2]:  # the first two calls are under way at once, however late a thread begins
            both.wait(TIMEOUT)
        time.sleep(seconds)
        with lock:
            at_once -= 1
        return seconds

    pauses = [0.05, 0.01, 0.03, 0.02, 0.04]
    with Campaign(cluster="local:2") as campaign:
        assert campaign.watch(call, pauses, lambda s, _: (f"{s}", "done")) == pauses
    assert most == 2


def test_after_a_stop_and_after_an_error_no_further_call_is_made() -> None:
    stop, made = threading.Event(), []

    def stops(n: int) -> int:
        made.append(n)
        if n == 1:
            stop.set()
            raise Interrupted
        return n

    with Campaign(cluster="local:1", stop=stop) as campaign:
        assert campaign.watch(stops, range(4), lambda n, _: (f"{n}", "done")) == [0, None, None, None]
    assert made == [0, 1]
    made.clear()

    def fails(n: int) -> int:
        made.append(n)
        if n == 1:
            raise ValueError(n)
        return n

    with Campaign(cluster="local:1") as campaign, pytest.raises(ValueError, match="1"):
        campaign.watch(fails, range(4), lambda n, _: (f"{n}", "done"))
    assert made == [0, 1]
