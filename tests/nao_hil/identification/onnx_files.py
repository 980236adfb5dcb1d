"""Networks in ONNX's published format (`onnx.proto`): one product and one sum, written by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.nao_hil.identification.naoth_logs import inner, integer

FLOAT = 1


def tensor(name: str, values: np.ndarray) -> bytes:
    shape = b"".join(integer(1, size) for size in values.shape)
    return shape + integer(2, FLOAT) + inner(8, name.encode()) + inner(9, values.astype("<f4").tobytes())


def node(kind: str, inputs: list[str], output: str, attribute: bytes = b"") -> bytes:
    names = b"".join(inner(1, name.encode()) for name in inputs)
    return names + inner(2, output.encode()) + inner(4, kind.encode()) + attribute


def value(name: str, *shape: int) -> bytes:
    sizes = b"".join(inner(1, integer(1, size)) for size in shape)
    return inner(1, name.encode()) + inner(2, inner(1, integer(1, FLOAT) + inner(2, sizes)))


def write_network(path: Path, weights: np.ndarray, bias: np.ndarray, *, frames: int = 3) -> Path:
    """y = flatten(x) weights + bias.

    Args:
        path: Of the file.
        weights: (frames 22, 11)
        bias: (11,)
        frames: Rows of x.
    """
    axis = inner(5, inner(1, b"axis") + integer(3, 0) + integer(20, 2))
    graph = b"".join(
        (
            inner(1, node("Flatten", ["x"], "flat", axis)),
            inner(1, node("MatMul", ["flat", "weights"], "product")),
            inner(1, node("Add", ["product", "bias"], "y")),
            inner(2, b"legs"),
            inner(5, tensor("weights", weights)),
            inner(5, tensor("bias", bias)),
            inner(11, value("x", frames, 22)),
            inner(12, value("y", 1, 11)),
        )
    )
    path.write_bytes(integer(1, 8) + inner(7, graph) + inner(8, integer(2, 17)))
    return path
