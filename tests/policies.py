"""Sheets of policies, and networks whose outputs are known, for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
import tomli_w

from bridge.body.joints import JOINTS
from bridge.body.joints import LEGS as LEG_SLOTS
from tests.imitation.layers import Layer, onnx_file

LEGS: Final = tuple(JOINTS[slot] for slot in LEG_SLOTS)


def sheet(**changes: Any) -> dict[str, Any]:
    """A policy of the legs that sees gravity, with some keys changed."""
    table: dict[str, Any] = {
        "model": "policy.onnx",
        "cycle": 0.01,
        "command": {
            "default": [0.0, 0.0, 0.0],
            "forward": [-0.2, 0.3],
            "left": [-0.1, 0.1],
            "turn": [-1.0, 1.0],
        },
        "phase": {"period": 0.5},
        "observation": [{"term": "projected_gravity"}],
        "action": [{"joints": list(LEGS)}],
    }
    return table | changes


def write_policy(
    folder: Path, table: dict[str, Any], weights: np.ndarray | None = None, bias: np.ndarray | None = None
) -> str:
    """A sheet with its network, y = x weights + bias; zeros by default: the robot stands.

    Returns:
        Name of the gait.
    """
    inputs, outputs = (3, len(LEGS)) if weights is None else weights.shape
    layer = Layer(
        np.zeros((inputs, outputs)) if weights is None else weights, np.zeros(outputs) if bias is None else bias
    )
    (folder / "policy.onnx").write_bytes(onnx_file([layer]))
    (folder / "policy.toml").write_text(tomli_w.dumps(table), encoding="utf-8")
    return f"onnx:{folder / 'policy.toml'}"
