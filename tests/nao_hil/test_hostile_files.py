"""Files that are too long, too deep, or no files: one sentence within two seconds of processor time."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from pathlib import Path

import pytest
import zstandard

from bridge.errors import ConfigurationError
from bridge.recording.playback import MAX_RECORD_SIZE, read_recording
from emulator.scenarios import MAX_CSV, load_scenario
from nao_hil.campaigns.file import load_campaign

SECONDS = 2.0
"""s of processor time."""
BOX = '[[boxes]]\nname = "b{}"\nsize = [1.0, 1.0, 1.0]\nat = [1.0, 1.0]\n'


def refused(read: Callable[[Path], object], path: Path) -> str:
    """The sentence with which a file is refused in time."""
    began = time.process_time()
    with pytest.raises(ConfigurationError) as error:
        read(path)
    assert time.process_time() - began < SECONDS
    sentence = str(error.value)
    assert str(path) in sentence and "\n" not in sentence and len(sentence) < 1000
    return sentence


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (".".join("a" * 200_000) + " = 1", "more than 262144 bytes"),
        (".".join("a" * 120_000) + " = 1", "line 1: a key of more than 32 parts"),
        (" . ".join("a" * 60_000) + " = 1", "line 1: a key of more than 32 parts"),
        ("\n[" + ".".join("a" * 120_000) + "]", "line 2: a key of more than 32 parts"),
        ("x = {" + ".".join("a" * 120_000) + " = 1}", "line 1: a key of more than 32 parts"),
        ('title = "' + "x" * 50_000_000 + '"', "more than 262144 bytes"),
        ('title = "' + "x" * 250_000 + '"', "title"),
        ("".join(BOX.format(i) for i in range(20_000)), "more than 262144 bytes"),
        ("".join(BOX.format(i) for i in range(1001)), "boxes: expected a list of length <= 1000"),
        ("x" * 250_000 + " = 1", "unknown key"),
    ],
    ids=[
        "400 kB",
        "240 kB",
        "spaces",
        "header",
        "inline",
        "title",
        "shorter title",
        "boxes",
        "1001 boxes",
        "key",
    ],
)
def test_a_hostile_scenario_is_refused_in_one_sentence(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "hostile.toml"
    path.write_text(text)
    assert said in refused(lambda path: load_scenario(str(path)), path)


def test_a_file_of_heights_is_bounded_in_length_and_points(tmp_path: Path) -> None:
    scenario, heights = tmp_path / "hills.toml", tmp_path / "heights.csv"
    scenario.write_text('[heightfield]\nfile = "heights.csv"\n')
    heights.write_text("0.0," * (MAX_CSV // 4) + "0.0")
    began = time.process_time()
    with pytest.raises(ConfigurationError, match="has more than"):
        load_scenario(str(scenario))
    heights.write_text(("0," * 599 + "0\n") * 600)
    with pytest.raises(ConfigurationError, match="360000 points; at most 250000"):
        load_scenario(str(scenario))
    assert time.process_time() - began < SECONDS


def test_a_campaign_of_too_many_combinations_is_refused(tmp_path: Path) -> None:
    axes = "\n".join(f'"parameters.p{i}" = {list(range(100))}' for i in range(6))
    path = tmp_path / "campaign.toml"
    path.write_text(f"[axes]\n{axes}\n")
    with pytest.raises(ConfigurationError, match="combinations"):
        load_campaign(path).cells()


@pytest.mark.parametrize("honest", [True, False])
def test_a_recording_that_unpacks_to_gigabytes_is_refused(honest: bool, tmp_path: Path) -> None:
    size = 4 * MAX_RECORD_SIZE
    packed = zstandard.compress(bytes(size))
    chunk = struct.pack("<QQQII", 0, 0, size if honest else 100, 0, 4) + b"zstd"
    chunk += struct.pack("<Q", len(packed)) + packed
    path = tmp_path / "bomb.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(chunk)) + chunk)
    assert "a chunk that unpacks to more than" in refused(lambda path: list(read_recording(path)), path)
