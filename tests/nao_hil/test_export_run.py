"""An exported page's numbers, unpacked here by the words of the format."""

from __future__ import annotations

import gzip
import json
import math
from pathlib import Path

import numpy as np
import pytest

from nao_hil.cli.main import run
from nao_hil.view.rows import PackedTable, pack


def unpacked(packed: bytes) -> tuple[dict[str, object], dict[str, np.ndarray]]:
    data = gzip.decompress(packed)
    length = int.from_bytes(data[:4], "little")
    header = json.loads(data[4 : 4 + length])
    numbers, tables, at = np.frombuffer(data[4 + length :], dtype="<i4"), {}, 0
    for table in header["tables"]:
        n = table["rows"] * table["columns"]
        columns = numbers[at : at + n].reshape(table["columns"], table["rows"])
        whole = np.cumsum(columns, axis=1, dtype=np.int32).T
        tables[table["name"]] = np.where(whole == -(2**31), math.nan, whole * table["step"])
        at += n
    assert at == len(numbers)
    return header, tables


def test_what_is_packed_is_what_was_given_to_the_step() -> None:
    values = np.random.default_rng(0).normal(0.0, 3.0, (50, 4))
    values[7:12, 2] = math.nan
    header, tables = unpacked(
        pack({"title": "ä"}, {"a": PackedTable(values, 1e-4), "none": PackedTable(np.zeros((0, 3)), 1.0)})
    )
    np.testing.assert_allclose(tables["a"], values, atol=0.5001e-4)
    assert header["title"] == "ä" and tables["none"].shape == (0, 3)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "--html FILE"),
        (["--video", "walk.mp4"], ".webm"),
        (["--html", "walk.pdf"], ".html"),
        (["--html", "walk.html", "--from", "500"], "--from, --to and --speed are the video's"),
        (["--html", "no-such-folder/walk.html"], "no folder no-such-folder"),
        (["--html", "{there}/walk.html"], "nothing.mcap: cannot be read"),
    ],
)
def test_a_wrong_export_is_one_sentence(
    arguments: list[str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there = [argument.format(there=tmp_path) for argument in arguments]
    assert run(["export", str(tmp_path / "nothing.mcap"), *there]) == 2
    (said,) = capsys.readouterr().err.splitlines()
    assert sentence in said
