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


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("leg.D", 37500.0, "leg.D is 37500 N s/m; a robot of this size takes 2000 N s/m at most"),
        ("ankle.K_roll", -1e3, "K_roll"),
        ("max_gap", 50.0, "max_gap is 50 s; a robot of this size takes 1 s at most"),
        ("leg.target_depth", 4.0, "leg.target_depth is 4 m; a robot of this size takes 0.5 m at most"),
    ],
)
def test_the_sentence_has_the_unit(path: str, value: float, said: str) -> None:
    with pytest.raises(ConfigurationError, match=said):
        controller_parameters("omni", change(path, value))


def test_a_misspelt_controller_parameter_is_named_with_what_was_meant() -> None:
    with pytest.raises(ConfigurationError, match=r"swing_foot_orientation\.gai.*gain"):
        controller_parameters("static", {"swing_foot_orientation": {"gai": 0.0}})
