"""How NumPy is called: in a way that its later versions also take."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
PACKAGES = ("bridge", "emulator", "walker", "nao_hil")


def test_no_function_of_numpy_gets_its_output_by_position() -> None:
    found = []
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
                    continue
                owner, function = node.func.value, vars(np).get(node.func.attr)
                if isinstance(owner, ast.Name) and owner.id == "np" and isinstance(function, np.ufunc):
                    found += [f"{path}:{node.lineno}"] if len(node.args) > function.nin else []
    assert not found
