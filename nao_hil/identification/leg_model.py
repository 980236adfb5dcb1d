"""A learned model of a walking V6's legs beside recorded and emulated joints.

Source: `JointAnglePredictor` of B-Human's code releases. Input: three frames, each with 11 requests and then 11
measurements, the oldest first; a request is that of the frame before its measurement. Output: 11 angles.
Valid while walking. Its horizon is not written down: the errors are given for several.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR, LEG_JOINTS
from bridge.errors import ConfigurationError
from bridge.files import read_limited
from bridge.types import Array
from nao_hil.identification.readings import Signals

FRAMES: Final = 3
"""Frames of the input."""
HORIZONS: Final = range(5)
"""Frames ahead of the newest measurement."""
CYCLE: Final = 0.012
"""Cycle of the robots that the model has learnt, s."""
ORDERS: Final = {
    "by leg": (*LEG_JOINTS["L"][1:], *LEG_JOINTS["R"]),
    "first release": (
        *("RAnkleRoll", "RAnklePitch", "RKneePitch", "RHipPitch", "RHipRoll"),
        *("LKneePitch", "LAnkleRoll", "LAnklePitch", "LHipPitch", "LHipRoll", "LHipYawPitch"),
    ),
}
"""Orders of the joints, by release. The file does not tell; the one with the smaller error is right."""
Model = Callable[[Array], Array]
"""(3, 22) to (11,), rad."""


class Horizon(msgspec.Struct, frozen=True, kw_only=True):
    """RMS of the predicted angle less the one measured so many frames later, by joint, rad."""

    frames: int
    recorded: dict[str, float]
    replayed: dict[str, float]

    def overall(self, which: str) -> float:
        """RMS over the joints, rad.

        Args:
            which: `recorded` or `replayed`.
        """
        return math.sqrt(np.mean(np.square(list(getattr(self, which).values()))))


class LegModelComparison(msgspec.Struct, frozen=True, kw_only=True):
    """Errors of the model on both robots."""

    model: str
    order: str
    """Key of `ORDERS`."""
    frames: int
    """Predictions that were compared."""
    horizons: tuple[Horizon, ...]

    @property
    def sentence(self) -> str:
        """The result in words."""
        words = []
        for which in ("recorded", "replayed"):
            best = min(self.horizons, key=lambda each: each.overall(which))
            words.append(f"{which} {math.degrees(best.overall(which)):.2f} deg at {best.frames}")
        return f"{self.model}: smallest RMS error, and the frames ahead: {', '.join(words)}."


def load_model(path: Path) -> Model:
    """The network in a file.

    Args:
        path: .onnx with one input of 3 by 22 numbers and one output of 11.

    Raises:
        ConfigurationError: unreadable, another network, or onnxruntime is not installed.
    """
    try:
        import onnxruntime
    except ImportError:
        raise ConfigurationError("--leg-model needs onnxruntime; install nao-hil[onnx].") from None
    data = read_limited(path, 1 << 28, "give the network of JointAnglePredictor (.onnx)")
    try:
        session: Any = onnxruntime.InferenceSession(data, providers=["CPUExecutionProvider"])
    except Exception as error:  # the runtime has classes of its own for each kind of damage
        raise ConfigurationError(f"{path}: is no network that onnxruntime can load ({error}).") from None
    inputs, outputs = session.get_inputs(), session.get_outputs()
    shape = [size if isinstance(size, int) else 1 for size in inputs[0].shape]
    if len(inputs) != 1 or shape[-2:] != [FRAMES, 22] or math.prod(shape) != FRAMES * 22 or len(outputs) != 1:
        raise ConfigurationError(
            f"{path}: takes {', '.join(f'{each.name} {each.shape}' for each in inputs)}; the network of "
            f"JointAnglePredictor takes one input of [{FRAMES}, 22]."
        )

    def run(values: Array) -> Array:
        (found,) = session.run(None, {inputs[0].name: values.astype(np.float32).reshape(shape)})
        return np.asarray(found, dtype=np.float64).ravel()

    if len(run(np.zeros((FRAMES, 22)))) != len(ORDERS["by leg"]):
        raise ConfigurationError(f"{path}: gives another number of angles than the 11 of both legs.")
    return run


def compare_leg_model(
    model: Model, name: str, body: Body, recorded: Signals, replayed: Signals
) -> LegModelComparison:
    """Predict from each robot's own requests and measurements.

    Args:
        model: Of `load_model`.
        name: Of its file.
        body: The recorded one.
        recorded: With requests and angles of the legs; rows without either are left out.
        replayed: The same of the emulated robot.

    Raises:
        ConfigurationError: another cycle than the model's, or too few rows.
    """
    if abs(body.cycle - CYCLE) > 1e-6:
        raise ConfigurationError(
            f"--leg-model: is a model of the NAO V6 with 12 ms; {body.name} has {1e3 * body.cycle:g} ms."
        )
    errors = {
        order: [_errors(model, signals, ORDERS[order]) for signals in (recorded, replayed)] for order in ORDERS
    }
    order = min(errors, key=lambda each: min(np.square(errors[each][0]).mean(axis=(1, 2))))
    rms = [np.sqrt(np.square(each).mean(axis=1)).tolist() for each in errors[order]]
    return LegModelComparison(
        model=name,
        order=order,
        frames=errors[order][0].shape[1],
        horizons=tuple(
            Horizon(
                frames=frames,
                recorded=dict(zip(ORDERS[order], rms[0][row], strict=True)),
                replayed=dict(zip(ORDERS[order], rms[1][row], strict=True)),
            )
            for row, frames in enumerate(HORIZONS)
        ),
    )


def _errors(model: Model, signals: Signals, order: tuple[str, ...]) -> Array:
    """Predicted less measured angles, (horizons, rows, 11), rad."""
    slots = [INDEX_WITH_MIRROR[joint] for joint in order]
    angle, request = signals.position[:, slots], signals.command[:, slots]
    known = np.isfinite(angle).all(axis=1) & np.append(False, np.isfinite(request[:-1]).all(axis=1))
    last = len(angle) - HORIZONS[-1]
    rows = [k for k in range(FRAMES, last) if known[k - FRAMES + 1 : k + HORIZONS[-1] + 1].all()]
    if len(rows) < FRAMES:
        raise ConfigurationError(
            f"--leg-model: needs {FRAMES} rows at least in which requests and angles of both legs are known."
        )
    predicted = np.array(
        [
            model(np.hstack([request[k - FRAMES : k], angle[k - FRAMES + 1 : k + 1]]))  # oldest first
            for k in rows
        ]
    )
    return np.array([predicted - angle[np.array(rows) + frames] for frames in HORIZONS])
