"""The other rows: files of Parquet that are never changed."""

from __future__ import annotations

import os
import uuid
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Final

import msgspec
import pyarrow as pa
import pyarrow.dataset as pads
import pyarrow.parquet as pq

from bridge.errors import ConfigurationError
from nao_hil.runs.dataset.row import Row

PATTERN: Final = "part-*.parquet"
_TYPES: Final = {"str": pa.string(), "int": pa.int64(), "float": pa.float64(), "bool": pa.bool_()}
SCHEMA: Final = pa.schema([(name, _TYPES.get(kind, pa.string())) for name, kind in Row.__annotations__.items()])
"""Columns of a part: the fields of `Row`."""


def write_part(folder: Path, rows: Sequence[Row]) -> Path:
    """Write rows as a new part; it is there whole or not at all."""
    path = folder / f"part-{uuid.uuid4().hex}.parquet"
    half = path.with_suffix(".half")
    table = pa.Table.from_pylist([msgspec.structs.asdict(row) for row in rows], schema=SCHEMA)
    with half.open("wb") as file:
        pq.write_table(table, file, compression="zstd")
        file.flush()
        os.fsync(file.fileno())
    half.rename(path)
    return path


def find_rows(folder: Path, keys: Collection[str]) -> dict[str, Row]:
    """The rows of some keys.

    Raises:
        ConfigurationError: a part that cannot be read.
    """
    return {found["key"]: msgspec.convert(found, Row) for found in _read(folder, keys, None).to_pylist()}


def known_keys(folder: Path, keys: Collection[str]) -> set[str]:
    """Which of some keys have a row; raises as `find_rows`."""
    return set(_read(folder, keys, ["key"]).column("key").to_pylist())


def _read(folder: Path, keys: Collection[str], columns: list[str] | None) -> pa.Table:
    files = sorted(map(str, folder.glob(PATTERN)))
    if not files or not keys:
        return SCHEMA.empty_table()
    try:
        found = pads.dataset(files, schema=SCHEMA, format="parquet")
        return found.to_table(columns=columns, filter=pads.field("key").isin(sorted(keys)))
    except (pa.ArrowInvalid, OSError) as error:
        raise ConfigurationError(
            f"{folder}: a part of the results cannot be read ({str(error).splitlines()[0]}); remove that file, "
            "and its walks are walked again."
        ) from None
