"""The hip motions that the walker loads: searched anew, and scaled to other steps."""

from __future__ import annotations

import msgspec
import pytest

from bridge.body import BODIES, load_body
from bridge.config import load_toml
from bridge.errors import ConfigurationError
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.search import along, search, walkable
from walker.gaits import gait_parameters
from walker.gaits.huang import HuangGait, HuangParameters
from walker.gaits.huang.hip import PLANS, ShippedPlan, choice_of
from walker.gaits.pose import ARMS


def parameters(**changes: object) -> HuangParameters:
    p = gait_parameters("huang", changes)
    assert isinstance(p, HuangParameters)
    return p


@pytest.mark.parametrize("name", BODIES)
def test_searched_anew_the_motion_is_the_shipped_one(name: str) -> None:
    """From another grid than `nao-hil plan` takes.

    The best point of a third one, walkable alike, has 0.4 mm more at most: where the range of an ankle cuts the
    optimum off, the search steps back in steps of some tenths.

    The search ends in an optimisation, whose result differs a little between versions of SciPy.
    """
    body = load_body(name)
    planned = load_toml(PLANS / f"{name}.toml", ShippedPlan)
    assert (planned.robot, planned.gait) == (name, "huang")
    inputs = msgspec.structs.replace(planned.parameters, x_sd=None, x_ed=None)
    assert inputs == parameters()
    cycle = Cycle(inputs, body, ARMS)
    shipped = choice_of(inputs, body)
    found = search(cycle, 9)
    assert shipped == pytest.approx(found.choice, abs=1e-4)
    assert cycle.margin(shipped) == pytest.approx(found.margin, abs=5e-5)
    optimum = walkable(cycle, along(cycle, shipped, 25)[0])
    assert found.margin > cycle.margin(optimum) - 4e-4


@pytest.mark.parametrize(("name", "length"), [("nao-v3", 0.02), ("nao-v6", 0.05)])
def test_a_scaled_motion_has_the_margin_of_a_searched_one(name: str, length: float) -> None:
    body = load_body(name)
    cycle = Cycle(parameters(D_s=length), body, ARMS)
    assert cycle.margin(choice_of(cycle.p, body)) > search(cycle, 12).margin - 3e-4


def test_a_longer_step_scales_the_motion_and_walks() -> None:
    body = load_body("nao-v3")
    shipped = choice_of(parameters(), body)
    choice = HuangGait(parameters(D_s=0.07), body).choice
    assert choice.x_sd == pytest.approx(shipped.x_sd * 7.0 / 6.0)
    assert choice.x_ed == pytest.approx(shipped.x_ed * 7.0 / 6.0)
    assert (choice.y_d, choice.y_m) == (shipped.y_d, shipped.y_m)


def test_a_body_without_a_plan_is_refused_with_the_command() -> None:
    body = msgspec.structs.replace(load_body("nao-v3"), name="nao-v7")
    with pytest.raises(ConfigurationError, match="nao-hil plan --out plan"):
        choice_of(parameters(), body)
    named = choice_of(parameters(), load_body("nao-v3"))._asdict()
    assert choice_of(parameters(**named), body)._asdict() == named
