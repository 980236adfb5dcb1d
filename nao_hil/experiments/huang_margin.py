"""Benefit of the search of Huang's gait, and agreement of plan and walk; Huang et al. (2001), (11) to (14).

Conditions: the hip motion with the largest stability margin, and a badly chosen one, with the same feet and
times; a step of 1 cm up and down that the plan knows of, and the same step unknown to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from matplotlib.figure import Figure

from bridge.body import Body
from bridge.body.sole import sole_hull
from bridge.types import SIDES, Array
from emulator.scenarios import load_scenario
from nao_hil.analysis.report.render import Claim
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.search import search
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import (
    Comparison,
    before_fall,
    conditions_table,
    during,
    falls_finding,
    soles_in_world,
)
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Drawing, Experiment, Measured, bounded
from nao_hil.runs.ground import known_ground
from nao_hil.runs.run import Table
from nao_hil.runs.walk import WalkOutcome
from walker.gaits import gait_parameters
from walker.gaits.huang import HuangParameters
from walker.gaits.huang.hip import Choice
from walker.gaits.pose import ARMS

_NOTHING: Final = 2.0
"""N; a foot with less than this bears nothing."""
SCENARIO: Final = "step"
PLANNED: Final = "1 cm step, planned"
UNKNOWN: Final = "1 cm step, unknown"
DURATION: Final = 60.0
"""Duration of a walk, s."""
STEP_DURATION: Final = 15.0
"""s: over the step of the scenario and off it again."""
BAD: Final = (0.25, 0.1)
"""Badly chosen x_sd and x_ed, shares of bound (11): the worst corner that the joints reach."""
SHARE: Final = 0.8
"""Least share that walks on."""
SPEED: Final = 0.08
"""m/s over ground, at least (median)."""


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


def in_stance_sole(track: Table, body: Body) -> tuple[Array, Array, Array]:
    """Planned and true ZMP in the frame of the stance sole in single support, y outwards.

    Returns:
        Rows of the track, shape (n,); plan and truth, each (n, 2), m.
    """
    rows, plans, truths, zmp = [], [], [], track["world/truth.zmp"]
    for side, phase in zip(SIDES, ("SSL", "SSR"), strict=True):
        of_side = np.flatnonzero(during(track, phase) & np.isfinite(zmp[:, 0]))
        soles = soles_in_world(body, side, track.where(of_side))
        off = zmp[of_side] - soles[:, :2, 3]
        outward = np.array([1.0, 1.0 if side == "L" else -1.0])
        foot = track["walk/telemetry.left" if side == "L" else "walk/telemetry.right"][of_side, :2]
        rows.append(of_side)
        truths.append(np.einsum("nij,ni->nj", soles[:, :2, :2], off) * outward)
        plans.append((track["walk/telemetry.zmp"][of_side] - foot) * outward)
    return np.concatenate(rows), np.concatenate(plans), np.concatenate(truths)


def zmp_match(results: Sequence[WalkOutcome], body: Body) -> ZmpMatch:
    """Planned against measured, medians over the runs, each until a second before its fall."""
    tracks = [before_fall(result) for result in results]
    values = [_match(track, body) for track in tracks if during(track, "SSL", "SSR").any()]
    middle = np.nanmedian(np.array(values), axis=0) if values else np.full(5, np.nan)
    return ZmpMatch(**dict(zip(ZmpMatch.__struct_fields__, middle.tolist(), strict=True)))


def _match(track: Table, body: Body) -> tuple[float, float, float, float, float]:
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


def _from_sensors(track: Table, body: Body, rows: Array) -> Array:
    """Centre of pressure of the stance foot by its four cells, y outwards, shape (n, 2), m."""
    left = np.isin(rows, np.flatnonzero(during(track, "SSL")))
    points = np.empty((len(rows), 2))
    for mask, columns, places, outward in (
        (left, slice(0, 4), body.fsr.L, 1.0),
        (~left, slice(4, 8), body.fsr.R, -1.0),
    ):
        forces = np.maximum(track["sensors.fsr"][rows[mask], columns], 0.0)
        total = forces.sum(axis=1)
        other = (
            track["sensors.fsr"][rows[mask], 4:] if columns.start == 0 else track["sensors.fsr"][rows[mask], :4]
        )
        total[other.sum(axis=1) > _NOTHING] = np.nan
        with np.errstate(invalid="ignore", divide="ignore"):
            points[mask] = forces @ np.array(places)[:, :2] / total[:, None] * (1.0, outward)
    return points


def _delay(track: Table) -> float:
    """Shift, s, at which the true ZMP's y, less the mass', correlates best with the planned one's."""
    walking = during(track, "DSL", "SSL", "DSR", "SSR")
    plan = (track["walk/telemetry.zmp"] - track["walk/telemetry.com"])[walking, 1]
    truth = (track["world/truth.zmp"] - track["world/truth.com"][:, :2])[walking, 1]
    truth = np.nan_to_num(truth - np.nanmean(truth))
    cycle = float(np.median(np.diff(track["time"])))
    shifts = range(0, 16)
    scores = [float(np.dot(plan[: len(plan) - s], truth[s:])) for s in shifts]
    return cycle * int(np.argmax(scores))


class HuangWalks(NamedTuple):
    """Both motions, and the walks."""

    choices: tuple[Choice, Choice]
    """Searched, and badly chosen."""
    margins: tuple[float, float]
    """Planned, m."""
    compared: Comparison


def _measure(context: Context) -> HuangWalks:
    """Search the motion; walk it and a badly chosen one, and the searched one over a step."""
    cycle = Cycle(_parameters(context), context.body, ARMS)
    optimum, bound = search(cycle), 0.5 * _parameters(context).D_s
    bad = optimum.choice._replace(x_sd=BAD[0] * bound, x_ed=BAD[1] * bound)
    searched, scenario = _motion(optimum.choice), load_scenario(SCENARIO)
    ground = msgspec.to_builtins(known_ground(scenario, context.body))
    flat, over_step = Task("huang", DURATION), Task("huang", STEP_DURATION, fields={"scenario": scenario})
    motions = {
        "searched": flat.walks(context, "huang, searched", searched),
        "badly chosen": flat.walks(context, "huang, badly chosen", _motion(bad)),
    }
    steps = {
        PLANNED: over_step.walks(context, "huang, step, planned", searched | {"parameters.ground": ground}),
        UNKNOWN: over_step.walks(context, "huang, step, unknown", searched | {"parameters.ground": {}}),
    }
    compared = Comparison(context.run(motions) | context.run(steps))
    return HuangWalks((optimum.choice, bad), (optimum.margin, cycle.margin(bad)), compared)


def _parameters(context: Context) -> HuangParameters:
    found = gait_parameters("huang", context.config("huang").parameters)
    assert isinstance(found, HuangParameters)
    return found


def _motion(choice: Choice) -> dict[str, Any]:
    return {f"parameters.{name}": value for name, value in choice._asdict().items()}


def _setup(measured: Measured[HuangWalks]) -> list[tuple[str, str]]:
    p, (choices, margins, _) = _parameters(measured.context), measured.results
    return [
        ("gait", f"huang, D_s = {p.D_s} m every {p.T_c} s, {DURATION:g} s"),
        *(
            (name, f"x_sd = {1e3 * c.x_sd:.1f} mm, x_ed = {1e3 * c.x_ed:.1f} mm, margin {1e3 * margin:.1f} mm")
            for name, c, margin in zip(("searched", "badly chosen"), choices, margins, strict=True)
        ),
    ]


def _quantities(measured: Measured[HuangWalks]) -> dict[str, Any]:
    _, margins, compared = measured.results
    searched, bad, *_ = compared.walks.values()
    return {
        "margin": margins[0],
        "margin_bad": margins[1],
        "with": compared.conditions["searched"],
        "without": compared.conditions["badly chosen"],
        "paired": compared.pair,
        "zmp": zmp_match(searched, measured.body),
        "zmp_bad": zmp_match(bad, measured.body),
        "step_planned": compared.conditions[PLANNED],
        "step_unknown": compared.conditions[UNKNOWN],
    }


def _claims(found: dict[str, Any]) -> list[Claim]:
    best, worse = found["with"], found["without"]
    outside, outside_bad = found["zmp"].outside, found["zmp_bad"].outside
    leans = worse.tilt_max_deg[0] > best.tilt_max_deg[0]
    return [
        bounded(f"with the searched motion {100 * SHARE:.0f} % walk on for {DURATION:g} s", best, SHARE),
        bounded(f"at {SPEED} m/s or more over ground", best.speed, SPEED, words="{:.3f} m/s"),
        Claim(
            "the search pays: the badly chosen motion falls more often, leans more, or leaves the sole more",
            f"{worse.words()}, leans {worse.tilt_max_deg[0]:.1f} deg against {best.tilt_max_deg[0]:.1f}, "
            f"ZMP outside {100 * outside_bad:.1f} % against {100 * outside:.1f} %",
            worse.survived < best.survived or (leans and outside_bad > outside),
        ),
        bounded("a known step of 1 cm up and down is walked by plan", found["step_planned"], SHARE),
    ]


def _findings(measured: Measured[HuangWalks]) -> list[str]:
    walks = measured.results.compared.walks
    both = Comparison({name: walks[name] for name in ("searched", "badly chosen")})
    return [
        *both.findings(measured.body),
        falls_finding("Step, unknown", walks[UNKNOWN], None),
    ]


def _draw(figure: Figure, measured: Measured[HuangWalks]) -> None:
    hull = np.vstack((sole_hull(measured.body, "L"), sole_hull(measured.body, "L")[:1]))
    panels = figure.subplots(1, 2, sharey=True)
    for axis, (name, results) in zip(panels, measured.results.compared.walks.items(), strict=False):
        _, plan, truth = in_stance_sole(before_fall(results[0]), measured.body)
        axis.plot(1e3 * hull[:, 0], 1e3 * hull[:, 1], color="k", linewidth=0.8)
        axis.plot(1e3 * truth[:, 0], 1e3 * truth[:, 1], ".", ms=1.5, color=axes.BLUE, label="true")
        axis.plot(1e3 * plan[:, 0], 1e3 * plan[:, 1], ".", ms=2.5, color=axes.RED, label="planned")
        axis.set(xlabel="x from the ankle, mm", title=name, aspect="equal")
        axis.legend(fontsize=8)
    figure.axes[0].set_ylabel("y from the ankle, outwards, mm")


HUANG_MARGIN: Final = Experiment(
    title="The searched hip motion of Huang's gait against a badly chosen one",
    source="Huang et al. (2001): the motion with the largest stability margin is searched (11), (12).",
    setup=_setup,
    measure=_measure,
    quantities=_quantities,
    claims=lambda measured: _claims(measured.figures),
    pictures=(
        Drawing(
            "huang-margin-zmp.png",
            _draw,
            "ZMP, planned and true, in the frame of the stance sole",
            "Single supports of seed {seed}; the outline is the sole's.",
            (10.0, 5.0),
        ),
    ),
    tables=lambda measured: [conditions_table(measured.results.compared.conditions)],
    findings=_findings,
)
