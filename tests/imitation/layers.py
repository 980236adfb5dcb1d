"""A small network: layers with tanh between them, fitted by Adam, written in ONNX's published format."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from bridge.types import Array

_FLOAT: Final = 1
_IR_VERSION: Final = 8
_OPERATORS: Final = 17
_DECAY: Final = (0.9, 0.999)
"""Of Adam's means of the gradient and its square (Kingma and Ba 2015)."""


class Layer(NamedTuple):
    """x weights + bias."""

    weights: Array
    """(inputs, outputs)"""
    bias: Array
    """(outputs,)"""


def random_layers(sizes: Sequence[int], random: np.random.Generator) -> list[Layer]:
    """Layers with small random weights.

    Args:
        sizes: numbers of inputs, of each hidden layer, and of outputs.
        random: generator.
    """
    return [Layer(random.normal(0.0, 1.0 / np.sqrt(a), (a, b)), np.zeros(b)) for a, b in pairwise(sizes)]


def outputs_of(layers: Sequence[Layer], inputs: Array) -> list[Array]:
    """Values of all layers, the inputs first, (n, size) each."""
    values = [inputs]
    for i, layer in enumerate(layers):
        value = values[-1] @ layer.weights + layer.bias
        values.append(np.tanh(value) if i < len(layers) - 1 else value)
    return values


def fit(
    layers: Sequence[Layer],
    inputs: Array,
    targets: Array,
    random: np.random.Generator,
    *,
    epochs: int,
    rate: float = 1e-3,
    batch: int = 512,
) -> tuple[list[Layer], float]:
    """Layers with a smaller mean square error, by Adam with a rate that falls to zero.

    Args:
        layers: To begin with.
        inputs: (n, inputs)
        targets: (n, outputs)
        random: Order of the batches.
        epochs: Passes over all rows.
        rate: First step length.
        batch: Rows of a step.

    Returns:
        The layers, and the root mean square error over all rows.
    """
    parts = [part.copy() for layer in layers for part in layer]
    means, squares = [np.zeros_like(part) for part in parts], [np.zeros_like(part) for part in parts]
    steps, step = epochs * max(len(inputs) // batch, 1), 0
    for _ in range(epochs):
        order = random.permutation(len(inputs))
        for begin in range(0, len(order) - batch + 1, batch):
            rows, step = order[begin : begin + batch], step + 1
            now = _layers(parts)
            values = outputs_of(now, inputs[rows])
            slope = (values[-1] - targets[rows]) / batch
            gradients: list[Array] = []
            for i in reversed(range(len(now))):
                gradients[:0] = [values[i].T @ slope, slope.sum(axis=0)]
                slope = (slope @ now[i].weights.T) * (1.0 - values[i] ** 2)
            length = rate * (1.0 - step / (steps + 1.0))
            a, b = _DECAY
            for part, gradient, mean, square in zip(parts, gradients, means, squares, strict=True):
                mean += (1.0 - a) * (gradient - mean)
                square += (1.0 - b) * (gradient**2 - square)
                part -= length * (mean / (1.0 - a**step)) / (np.sqrt(square / (1.0 - b**step)) + 1e-8)
    found = _layers(parts)
    return found, float(np.sqrt(np.mean((outputs_of(found, inputs)[-1] - targets) ** 2)))


def _layers(parts: Sequence[Array]) -> list[Layer]:
    return [Layer(*pair) for pair in zip(parts[::2], parts[1::2], strict=True)]


def onnx_file(layers: Sequence[Layer]) -> bytes:
    """The network as an ONNX file: one row in, one row out."""
    nodes, tensors, value = [], [], "observation"
    for i, layer in enumerate(layers):
        last = i == len(layers) - 1
        for kind, name, array in (("MatMul", "weights", layer.weights), ("Add", "bias", layer.bias)):
            tensors.append(_tensor(f"{name}{i}", array))
            result = "action" if last and kind == "Add" else f"{kind}{i}"
            nodes.append(_node(kind, [value, f"{name}{i}"], result))
            value = result
        if not last:
            nodes.append(_node("Tanh", [value], f"Tanh{i}"))
            value = f"Tanh{i}"
    graph = b"".join(_inner(1, node) for node in nodes) + _inner(2, b"policy")
    graph += b"".join(_inner(5, tensor) for tensor in tensors)
    graph += _inner(11, _value("observation", 1, len(layers[0].weights)))
    graph += _inner(12, _value("action", 1, len(layers[-1].bias)))
    return _integer(1, _IR_VERSION) + _inner(7, graph) + _inner(8, _integer(2, _OPERATORS))


# Protocol buffers, as `onnx.proto` has them: fields by number.


def _varint(value: int) -> bytes:
    parts = []
    while value > 0x7F:
        parts.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*parts, value])


def _integer(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _inner(field: int, content: bytes) -> bytes:
    return _varint(field << 3 | 2) + _varint(len(content)) + content


def _tensor(name: str, values: Array) -> bytes:
    shape = b"".join(_integer(1, size) for size in values.shape)
    raw = values.astype("<f4").tobytes()
    return shape + _integer(2, _FLOAT) + _inner(8, name.encode()) + _inner(9, raw)


def _node(kind: str, inputs: Sequence[str], result: str) -> bytes:
    names = b"".join(_inner(1, name.encode()) for name in inputs)
    return names + _inner(2, result.encode()) + _inner(4, kind.encode())


def _value(name: str, *shape: int) -> bytes:
    sizes = b"".join(_inner(1, _integer(1, size)) for size in shape)
    return _inner(1, name.encode()) + _inner(2, _inner(1, _integer(1, _FLOAT) + _inner(2, sizes)))
