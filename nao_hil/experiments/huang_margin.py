"""Benefit of the search of Huang's gait, and agreement of plan and walk; Huang et al. (2001), (11) to (14).

Conditions: the hip motion with the largest stability margin, and a badly chosen one, with the same feet and
times; a step of 1 cm up and down that the plan knows of, and the same step unknown to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import Body, load_body
from bridge.body.sole import sole_hull
from bridge.types import SIDES
from emulator.scenarios import Scenario, load_scenario
from nao_hil.analysis.report.render import Claim, Outcome, Picture
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.search import search
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import (
    Comparison,
    Condition,
    before_fall,
    condition,
    conditions_table,
    falls_finding,
    soles_in_world,
)
from nao_hil.experiments.context import Context
from nao_hil.files import save_figure
from nao_hil.runs.ground import known_ground
from nao_hil.runs.track import Array, Track
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.gaits import gait_parameters
from walker.gaits.huang import HuangParameters
from walker.gaits.huang.hip import Choice
from walker.gaits.pose import ARMS

_NOTHING: Final = 2.0
"""N; a foot with less than this bears nothing."""
SCENARIO: Final = "step"
FLAT: Final = Scenario()


class ZmpMatch(msgspec.Struct, frozen=True, kw_only=True):
    """Planned against measured zero moment point, in the frame of the stance sole: medians over the runs."""

    rms_x: float
    """m; ground truth less plan, single supports."""
    rms_y: float
    delay: float
    """Time by which the truth follows the plan (largest correlation along y), s."""
    outside: float
    """Share of the time in single support for which the true point is not within the stance sole."""
    fsr_rms: float
    """From the stance foot's force sensors less the truth, while the other foot bears nothing, m."""


def in_stance_sole(track: Track, body: Body) -> tuple[Array, Array, Array]:
    """Planned and true ZMP in the frame of the stance sole in single support, y outwards.

    Args:
        track: Of the walk.
        body: Of the robot.

    Returns:
        Rows of the track, shape (n,); plan and truth, each (n, 2), m.
    """
    rows, plans, truths = [], [], []
    for side, phase in zip(SIDES, ("SSL", "SSR"), strict=True):
        of_side = np.flatnonzero(track.during(phase) & np.isfinite(track["zmp"][:, 0]))
        soles = soles_in_world(body, side, Track(track.rows[of_side]))
        off = track["zmp"][of_side] - soles[:, :2, 3]
        outward = np.array([1.0, 1.0 if side == "L" else -1.0])
        foot = track["plan_left" if side == "L" else "plan_right"][of_side, :2]
        rows.append(of_side)
        truths.append(np.einsum("nij,ni->nj", soles[:, :2, :2], off) * outward)
        plans.append((track["plan_zmp"][of_side] - foot) * outward)
    return np.concatenate(rows), np.concatenate(plans), np.concatenate(truths)


def zmp_match(results: Sequence[WalkOutcome], body: Body) -> ZmpMatch:
    """Planned against measured, medians over the runs, each until a second before its fall."""
    values = []
    for result in results:
        track = before_fall(result)
        if track.during("SSL", "SSR").any():
            values.append(_match(track, body))
    middle = np.nanmedian(np.array(values), axis=0) if values else np.full(5, np.nan)
    return ZmpMatch(
        rms_x=float(middle[0]),
        rms_y=float(middle[1]),
        delay=float(middle[2]),
        outside=float(middle[3]),
        fsr_rms=float(middle[4]),
    )


def _match(track: Track, body: Body) -> tuple[float, float, float, float, float]:
    rows, plan, truth = in_stance_sole(track, body)
    apart = np.sqrt(np.mean((truth - plan) ** 2, axis=0))
    hull = sole_hull(body, "L")
    edges = np.roll(hull, -1, axis=0) - hull
    inside = np.ones(len(truth), dtype=bool)
    for corner, edge in zip(hull, edges, strict=True):
        inside &= edge[0] * (truth[:, 1] - corner[1]) - edge[1] * (truth[:, 0] - corner[0]) >= 0.0
    fsr = _from_sensors(track, body, rows) - truth
    return (
        float(apart[0]),
        float(apart[1]),
        _delay(track),
        float(1.0 - inside.mean()),
        float(np.sqrt(np.nanmean(np.sum(fsr**2, axis=1)))),
    )


def _from_sensors(track: Track, body: Body, rows: Array) -> Array:
    """Centre of pressure of the stance foot by its four cells, y outwards, shape (n, 2), m."""
    left = np.isin(rows, np.flatnonzero(track.during("SSL")))
    points = np.empty((len(rows), 2))
    for mask, columns, places, outward in (
        (left, slice(0, 4), body.fsr.L, 1.0),
        (~left, slice(4, 8), body.fsr.R, -1.0),
    ):
        forces = np.maximum(track["fsr"][rows[mask], columns], 0.0)
        total = forces.sum(axis=1)
        other = track["fsr"][rows[mask], 4:] if columns.start == 0 else track["fsr"][rows[mask], :4]
        total[other.sum(axis=1) > _NOTHING] = np.nan
        with np.errstate(invalid="ignore", divide="ignore"):
            points[mask] = forces @ np.array(places)[:, :2] / total[:, None] * (1.0, outward)
    return points


def _delay(track: Track) -> float:
    """Shift, s, at which the true ZMP's y, less the mass', correlates best with the planned one's."""
    walking = track.during("DSL", "SSL", "DSR", "SSR")
    plan = (track["plan_zmp"] - track["plan_com"])[walking, 1]
    truth = (track["zmp"] - track["com"][:, :2])[walking, 1]
    truth = np.nan_to_num(truth - np.nanmean(truth))
    cycle = float(np.median(np.diff(track["time"])))
    shifts = range(0, 16)
    scores = [float(np.dot(plan[: len(plan) - s], truth[s:])) for s in shifts]
    return cycle * int(np.argmax(scores))


@dataclass(frozen=True)
class HuangMarginSetup:
    """The experiment's numbers."""

    duration: float = 60.0
    """s"""
    step_duration: float = 15.0
    """s: over the step of the scenario and off it again."""
    bad: tuple[float, float] = (0.25, 0.1)
    """Badly chosen x_sd and x_ed, shares of bound (11): the worst corner that the joints reach."""
    share: float = 0.8
    """That walk on, at least."""
    speed: float = 0.08
    """m/s over ground, at least (median)."""


def experiment(context: Context, setup: HuangMarginSetup | None = None) -> Outcome:
    """All four conditions, the match of plan and truth, and the verdict."""
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
    compared = Comparison({"searched": best, "badly chosen": worse})
    conditions = compared.conditions | {
        "1 cm step, planned": condition(planned),
        "1 cm step, unknown": condition(unknown),
    }
    return context.outcome(
        "huang-margin",
        "The searched hip motion of Huang's gait against a badly chosen one",
        "Huang et al. (2001): the motion with the largest stability margin is searched (11), (12).",
        setup=[
            ("gait", f"huang, D_s = {p.D_s} m every {p.T_c} s, {setup.duration:g} s"),
            ("searched", _motion(found.choice, margins[0])),
            ("badly chosen", _motion(bad, margins[1])),
        ],
        claims=_claims(setup, conditions, matches),
        pictures=[
            Picture(
                _plot(context.out / "huang-margin-zmp.png", (best[0], worse[0]), body),
                "ZMP, planned and true, in the frame of the stance sole",
                f"Single supports of seed {best[0].seed}; the outline is the sole's.",
            )
        ],
        tables=[conditions_table(conditions)],
        findings=[
            *compared.findings(body),
            _match_words("Searched", matches[0]),
            _match_words("Badly chosen", matches[1]),
            falls_finding("Step, unknown", unknown, None),
        ],
        figures={
            "margin": margins[0],  # planned, m
            "margin_bad": margins[1],
            "with": conditions["searched"],
            "without": conditions["badly chosen"],
            "paired": compared.pair,
            "zmp": matches[0],
            "zmp_bad": matches[1],
            "step_planned": conditions["1 cm step, planned"],
            "step_unknown": conditions["1 cm step, unknown"],
        },
    )


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
    setup: HuangMarginSetup, conditions: dict[str, Condition], matches: tuple[ZmpMatch, ZmpMatch]
) -> tuple[Claim, ...]:
    best, worse = conditions["searched"], conditions["badly chosen"]
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
            conditions["1 cm step, planned"].words(),
            conditions["1 cm step, planned"].interval[0] >= setup.share,
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
        track = before_fall(result)
        _, plan, truth = in_stance_sole(track, body)
        axis.plot(1e3 * hull[:, 0], 1e3 * hull[:, 1], color="k", linewidth=0.8)
        axis.plot(1e3 * truth[:, 0], 1e3 * truth[:, 1], ".", ms=1.5, color=axes.BLUE, label="true")
        axis.plot(1e3 * plan[:, 0], 1e3 * plan[:, 1], ".", ms=2.5, color=axes.RED, label="planned")
        axis.set(xlabel="x from the ankle, mm", title=name, aspect="equal")
        axis.legend(fontsize=8)
    figure.axes[0].set_ylabel("y from the ankle, outwards, mm")
    return save_figure(figure, file)
