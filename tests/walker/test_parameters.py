"""Parameters of the controller: all have a bound, the shipped values keep it, slips do not."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from bridge.errors import ConfigurationError
from walker.gaits import GAITS
from walker.parameters import BOUNDS, controller_parameters, numbers

SHIPPED = {
    path: value
    for gait in GAITS
    for path, value in numbers(msgspec.to_builtins(controller_parameters(gait)))
    if value != 0.0
}


def change(path: str, value: Any) -> dict[str, Any]:
    for key in reversed(path.split(".")):
        value = {key: value}
    return dict(value)


def test_every_parameter_has_a_bound_and_every_bound_a_parameter() -> None:
    paths = {path for gait in GAITS for path, _ in numbers(msgspec.to_builtins(controller_parameters(gait)))}
    assert paths <= set(BOUNDS)
    assert all(path.startswith("torso_design.") for path in set(BOUNDS) - paths)  # of gaits that have a design


@pytest.mark.parametrize("path", [path for path in SHIPPED if "torso_design" not in path])
def test_a_value_five_hundred_times_the_shipped_one_is_refused(path: str) -> None:
    value = 500.0 * SHIPPED[path]
    pair = path in ("deviation.first_mean_gain", "landed_foot.damping")
    with pytest.raises(ConfigurationError) as error:
        controller_parameters("omni", change(path, [value, value] if pair else value))
    sentence = str(error.value)
    assert path.rpartition(".")[2] in sentence and "\n" not in sentence
