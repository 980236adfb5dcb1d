"""Tables of numbers, rounded, and packed for a script to read.

Unpacked: the length of the header (uint32, little endian), the header (JSON, padded by spaces to a multiple of
4 bytes), then each table column by column as int32: the first number and the differences, modulo 2**32, of the
numbers divided by the table's step.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

NOTHING: Final = -(2**31)
"""The integer that stands for NaN."""


class PackedTable(NamedTuple):
    """Rows of numbers."""

    values: ArrayLike
    """Shape (rows, columns); NaN: nothing."""
    step: float
    """To which they are rounded."""


def pack(header: Mapping[str, Any], tables: Mapping[str, PackedTable]) -> bytes:
    """Header and tables, compressed by gzip.

    Args:
        header: What goes into JSON beside the layout, which is added as `tables`.
        tables: By their names.
    """
    layout, columns = [], []
    for name, table in tables.items():
        values = np.asarray(table.values, dtype=np.float64)
        layout.append({"name": name, "rows": len(values), "columns": values.shape[1], "step": table.step})
        rounded = np.where(np.isnan(values), NOTHING, np.round(np.nan_to_num(values) / table.step))
        columns.append(np.diff(rounded.astype(np.int64), axis=0, prepend=0).T.astype("<i4").tobytes())
    text = json.dumps({**header, "tables": layout}).encode()
    text += b" " * (-len(text) % 4)
    return gzip.compress(np.array(len(text), dtype="<u4").tobytes() + text + b"".join(columns), mtime=0)
