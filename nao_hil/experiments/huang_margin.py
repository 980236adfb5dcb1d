"""Whether the search of Huang's gait pays and its plan comes true; Huang et al. (2001), (11) to (14).

Arms: the hip motion with the largest stability margin, and a badly chosen one, with the same feet and times; a
step of 1 cm up and down that the plan knows of, and the same step unknown to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import Body, load_body
from bridge.body.sole import sole_hull
from emulator.scenarios import Scenario, load_scenario
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage
from nao_hil.analysis.statistics import Paired
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.search import search
from nao_hil.experiments import axes
from nao_hil.experiments.arms import Arm, arm, arms_table, falls_finding, pair_words, pairs
from nao_hil.experiments.context import Context
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.zmp_match import ZmpMatch, in_stance_sole, zmp_match
from nao_hil.runs.ground import known_ground
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.gaits import gait_parameters
from walker.gaits.huang import HuangParameters
from walker.gaits.huang.hip import Choice
from walker.gaits.pose import ARMS

SCENARIO: Final = "step"
FLAT: Final = Scenario()


@dataclass(frozen=True)
class HuangMarginSetup:
    """The experiment's numbers."""

    duration: float = 60.0
    """s"""
    step_duration: float = 15.0
    """s: over the step of the scenario and off it again."""
    bad: tuple[float, float] = (0.25, 0.1)
    """x_sd and x_ed of the badly chosen arm, shares of bound (11): the worst corner that the joints reach."""
    share: float = 0.8
    """That walk on, at least."""
    speed: float = 0.08
    """m/s over ground, at least (median)."""


class HuangMarginResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "huang-margin"
    passed: bool
    margin: float
    """Planned, of the chosen motion, m."""
    margin_bad: float
    with_: Arm = msgspec.field(name="with")
    """The searched motion."""
    without: Arm
    """The badly chosen one."""
    paired: Paired
    zmp: ZmpMatch
    zmp_bad: ZmpMatch
    step_planned: Arm
    step_unknown: Arm


def experiment(context: Context, setup: HuangMarginSetup | None = None) -> Outcome:
    """All four arms, the match of plan and truth, and the verdict."""
    setup = setup or HuangMarginSetup()
    body = load_body(context.robot)
    p = gait_parameters("huang", context.config("huang", 0, {}).parameters)
    assert isinstance(p, HuangParameters)
    cycle = Cycle(p, body, ARMS)
    found = search(cycle)
    bound = 0.5 * p.D_s
    bad = found.choice._replace(x_sd=setup.bad[0] * bound, x_ed=setup.bad[1] * bound)
    margins = found.margin, cycle.margin(bad)
    best, worse = context.run(
        _walks(context, "searched", setup.duration, found.choice._asdict()),
        _walks(context, "badly chosen", setup.duration, bad._asdict()),
    )
    planned, unknown = _step_walks(context, setup, found.choice, body)
    matches = zmp_match(best, body), zmp_match(worse, body)
    arms = {
        "searched": arm(best),
        "badly chosen": arm(worse),
        "1 cm step, planned": arm(planned),
        "1 cm step, unknown": arm(unknown),
    }
    claims = _claims(setup, arms, matches)
    result = HuangMarginResult(
        passed=all(claim.holds for claim in claims),
        margin=margins[0],
        margin_bad=margins[1],
        with_=arms["searched"],
        without=arms["badly chosen"],
        paired=pairs(best, worse),
        zmp=matches[0],
        zmp_bad=matches[1],
        step_planned=arms["1 cm step, planned"],
        step_unknown=arms["1 cm step, unknown"],
    )
    chosen = [
        ("gait", f"huang, D_s = {p.D_s} m every {p.T_c} s, {setup.duration:g} s"),
        ("searched", _motion(found.choice, margins[0])),
        ("badly chosen", _motion(bad, margins[1])),
    ]
    findings = (
        pair_words(result.paired),
        _match_words("Searched", matches[0]),
        _match_words("Badly chosen", matches[1]),
        falls_finding("Searched", best, body),
        falls_finding("Badly chosen", worse, body),
        falls_finding("Step, unknown", unknown, None),
    )
    picture = Picture(
        _plot(context.out / "huang-margin-zmp.png", (best[0], worse[0]), body),
        "ZMP, planned and true, in the frame of the stance sole",
        f"Single supports of seed {best[0].seed}; the outline is the sole's.",
    )
    page = ReportPage(
        name="huang-margin",
        title="The searched hip motion of Huang's gait beside a badly chosen one",
        source="Huang et al. (2001): the motion with the largest stability margin is searched (11), (12).",
        setup=setup_rows(context, chosen),
        claims=claims,
        pictures=(picture,),
        tables=(arms_table(arms),),
        findings=tuple(text for text in findings if text),
    )
    return Outcome(result, page)


def _step_walks(
    context: Context, setup: HuangMarginSetup, choice: Choice, body: Body
) -> list[list[WalkOutcome]]:
    """Over the step of the scenario, by a plan that knows of it and by one that does not."""
    scenario, motion = load_scenario(SCENARIO), choice._asdict()
    ground = msgspec.to_builtins(known_ground(scenario, body))
    return context.run(
        _walks(context, "step, planned", setup.step_duration, motion | {"ground": ground}, scenario),
        _walks(context, "step, unknown", setup.step_duration, motion | {"ground": {}}, scenario),
    )


def _walks(
    context: Context, name: str, duration: float, parameters: dict[str, Any], scenario: Scenario = FLAT
) -> list[Walk]:
    """One walk per seed with these parameters of the gait."""
    return [
        msgspec.structs.replace(
            walk, config=msgspec.structs.replace(walk.config, parameters=walk.config.parameters | parameters)
        )
        for walk in context.walks(f"huang, {name}", "huang", duration, scenario=scenario)
    ]


def _claims(
    setup: HuangMarginSetup, arms: dict[str, Arm], matches: tuple[ZmpMatch, ZmpMatch]
) -> tuple[Claim, ...]:
    best, worse = arms["searched"], arms["badly chosen"]
    return (
        Claim(
            f"with the searched motion {100 * setup.share:.0f} % walk on for {setup.duration:g} s",
            best.words(),
            best.interval[0] >= setup.share,
        ),
        Claim(f"at {setup.speed} m/s or more over ground", f"{best.speed:.3f} m/s", best.speed >= setup.speed),
        Claim(
            "the search pays: the badly chosen motion falls more often, leans more, or leaves the sole more",
            f"{worse.words()}, leans {worse.tilt_max_deg[0]:.1f} deg against {best.tilt_max_deg[0]:.1f}, "
            f"ZMP outside {100 * matches[1].outside:.1f} % against {100 * matches[0].outside:.1f} %",
            worse.survived < best.survived
            or (worse.tilt_max_deg[0] > best.tilt_max_deg[0] and matches[1].outside > matches[0].outside),
        ),
        Claim(
            "a known step of 1 cm up and down is walked by plan",
            arms["1 cm step, planned"].words(),
            arms["1 cm step, planned"].interval[0] >= setup.share,
        ),
    )


def _motion(choice: Choice, margin: float) -> str:
    return f"x_sd = {1e3 * choice.x_sd:.1f} mm, x_ed = {1e3 * choice.x_ed:.1f} mm, margin {1e3 * margin:.1f} mm"


def _match_words(name: str, match: ZmpMatch) -> str:
    return (
        f"{name}: the true ZMP is {1e3 * match.rms_x:.0f} mm (x) and {1e3 * match.rms_y:.0f} mm (y) off the "
        f"plan (RMS in single support, {match.delay:.2f} s late), outside the stance sole for "
        f"{100 * match.outside:.1f} % of it; by the force sensors {1e3 * match.fsr_rms:.0f} mm off the truth."
    )


def _plot(file: Path, results: tuple[WalkOutcome, WalkOutcome], body: Body) -> Path:
    figure = axes.new_figure(10.0, 5.0)
    hull = np.vstack((sole_hull(body, "L"), sole_hull(body, "L")[:1]))
    for axis, result, name in zip(
        figure.subplots(1, 2, sharey=True), results, ("searched", "badly chosen"), strict=True
    ):
        track = result.track if result.end.survived else result.track.until(result.end.time - 1.0)
        _, plan, truth = in_stance_sole(track, body)
        axis.plot(1e3 * hull[:, 0], 1e3 * hull[:, 1], color="k", linewidth=0.8)
        axis.plot(1e3 * truth[:, 0], 1e3 * truth[:, 1], ".", ms=1.5, color=axes.BLUE, label="true")
        axis.plot(1e3 * plan[:, 0], 1e3 * plan[:, 1], ".", ms=2.5, color=axes.RED, label="planned")
        axis.set(xlabel="x from the ankle, mm", title=name, aspect="equal")
        axis.legend(fontsize=8)
    figure.axes[0].set_ylabel("y from the ankle, outwards, mm")
    return axes.save(figure, file)
