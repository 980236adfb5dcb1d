"""A network in a file (.onnx), run by onnxruntime on one thread."""

from __future__ import annotations

import math
import time
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from bridge.errors import ConfigurationError
from bridge.files import read_limited
from bridge.histogram import DurationHistogram
from bridge.types import Array

MAX_SIZE: Final = 1 << 28
"""bytes of a file."""


class Network:
    """One vector in, one vector out.

    Args:
        path: of the file.
        inputs: numbers of the observation.
        outputs: numbers of the action.

    Raises:
        ConfigurationError: onnxruntime is not installed, or the file is missing, is no network, has other
            sizes, or fails at zeros.
    """

    def __init__(self, path: Path, inputs: int, outputs: int) -> None:
        self._path = path
        self._session = _session(read_limited(path, MAX_SIZE, "give the network of the policy (.onnx)"), path)
        self.times = DurationHistogram()
        """Wall time of each call, s."""
        taken, given = self._session.get_inputs(), self._session.get_outputs()
        if len(taken) != 1 or taken[0].type != "tensor(float)":
            sizes = ", ".join(f"{each.name}: {each.type} {each.shape}" for each in taken)
            raise ConfigurationError(f"{path}: takes {sizes}; a policy takes one tensor of floats.")
        self._name, self._given = taken[0].name, given[0].name
        self._shape = _shape(taken[0].shape, inputs)
        if math.prod(self._shape) != inputs:
            raise ConfigurationError(
                f"{path}: takes {math.prod(self._shape)} numbers (shape {taken[0].shape}); the terms of the "
                f"sheet are {inputs}."
            )
        if (found := len(self._run(np.zeros(inputs)))) != outputs:
            raise ConfigurationError(f"{path}: gives {found} numbers; the sheet's actions take {outputs}.")

    def _run(self, observation: Array) -> Array:
        values = observation.astype(np.float32).reshape(self._shape)
        try:
            found = self._session.run([self._given], {self._name: values})[0]
        except Exception as error:  # the runtime has classes of its own for each kind of failure
            raise ConfigurationError(f"{self._path}: the network fails ({_first_line(error)}).") from None
        return np.asarray(found, dtype=np.float64).ravel()

    def __call__(self, observation: Array) -> Array:
        """Outputs for an observation, both flat.

        Raises:
            ConfigurationError: the network fails.
        """
        began = time.perf_counter()
        found = self._run(observation)
        self.times.add(time.perf_counter() - began)
        return found


def _shape(shape: list[Any], inputs: int) -> list[int]:
    """A shape with its free sizes set: the last one takes the rest, the others, such as the batch, are 1."""
    sizes = [size if isinstance(size, int) else 1 for size in shape]
    if shape and not isinstance(shape[-1], int):
        sizes[-1] = max(inputs // math.prod(sizes), 1)
    return sizes


@lru_cache(maxsize=8)  # a walk that changes its velocity makes its gait again
def _session(data: bytes, path: Path) -> Any:
    try:
        import onnxruntime
    except ImportError:
        raise ConfigurationError("A gait onnx:SHEET needs onnxruntime; install nao-hil[onnx].") from None
    options = onnxruntime.SessionOptions()
    # A second thread would wait for the first by spinning, on a core that the robot needs.
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4  # its errors are raised
    try:
        return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # the runtime has classes of its own for each kind of damage
        reason = _first_line(error)
        raise ConfigurationError(f"{path}: is no network that onnxruntime can load ({reason}).") from None


def _first_line(error: Exception) -> str:
    return str(error).strip().split("\n", 1)[0]
