"""R1: a plate of 1 cm under the swing foot in the static gait, without and with the admittances (thesis 4.1).

The thesis' robot is brought to fall by the force with which its swing foot treads on the plate; with the
admittances the force stays small and it walks on. Both arms have the gait's own torso control.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from bridge.datasheet import load_body
from bridge.world import PlateUnderFoot
from lab.campaign.proportion import Paired
from lab.campaign.track import Array, Track
from lab.campaign.walk import WalkResult
from lab.experiments import axes
from lab.experiments.arms import Arm, arm, arms_table, falls_finding, pair_words, pairs
from lab.experiments.context import Context
from lab.experiments.geometry import ankle_in_hip
from lab.experiments.page import Claim, Outcome, Page, Picture
from lab.experiments.setup import setup_rows


@dataclass(frozen=True)
class Setup:
    """The experiment's numbers."""

    duration: float = 45.0
    """s; the thesis' robot steps off the plate at about 32 s."""
    plate_time: float = 17.0
    """s of the walk: in SSL, the swing foot on its way down."""
    height: float = 0.01
    """m"""
    falls: float = 0.8
    """Share that falls without, at least."""
    survives: float = 0.95
    """Share that walks on with, at least."""
    force_ratio: float = 0.5
    """Largest force with over that without, at most."""
    lower: tuple[float, ...] = (0.002, 0.004, 0.006, 0.008)
    """Heights of the plate that are tried when the robot falls with the admittances, ascending, m."""
    higher: tuple[float, ...] = (0.015, 0.020, 0.025)
    """Heights that are tried when it does not fall without them, ascending, m."""
    probe_seeds: int = 4


class Force(msgspec.Struct, frozen=True, kw_only=True):
    """Largest sum of the swing foot's sensors from the plate to the end of that SSL, N: over the runs."""

    median: float
    largest: float


class ObstacleResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "obstacle"
    passed: bool
    with_: Arm = msgspec.field(name="with")
    without: Arm
    paired: Paired
    force_with: Force
    force_without: Force
    force_ratio: float
    """Of the medians."""
    survived_plate: float | None = None
    """Highest of the lower plates on which every run walks on with admittance, m; None: not tried, 0: none."""
    felling_plate: float | None = None
    """Lowest of the higher plates on which enough fall without it, m; None: not tried, or none of them."""


def plate(setup: Setup) -> tuple[tuple[float, PlateUnderFoot], ...]:
    """Under the right foot, which swings in SSL; as in the scenario `obstacle`."""
    size = (0.20, 0.08, setup.height)
    return ((setup.plate_time, PlateUnderFoot(foot="right", size=size, shift=(0.03, 0.0))),)


def landing_force(result: WalkResult, plate_time: float) -> float | None:
    """Largest sum of the right foot's four sensors from the plate to the end of that SSL, N.

    Until the fall if that is sooner, and until the torso leans 20 degrees: what a falling robot puts on the
    foot is no landing. None: the walk did not come so far.
    """
    track = result.track.until(result.end.time)
    time = track["time"]
    after = np.flatnonzero((time >= plate_time) & track.during("SSL"))
    if not after.size:
        return None
    breaks = np.flatnonzero(np.diff(after) > 1)
    rows = after[: int(breaks[0]) + 1] if breaks.size else after
    rows = rows[track.tilt[rows] < math.radians(20.0)]
    return float(track["fsr"][rows, 4:].sum(axis=1).max()) if rows.size else None


def _forces(results: Sequence[WalkResult], setup: Setup) -> Force:
    found = [f for r in results if (f := landing_force(r, setup.plate_time)) is not None]
    if not found:
        return Force(median=math.nan, largest=math.nan)
    return Force(median=float(np.median(found)), largest=max(found))


def experiment(context: Context, setup: Setup | None = None) -> Outcome:
    """Both arms, the figures 4.1, 4.2 and 4.8, and the verdict."""
    setup = setup or Setup()
    with_, without = context.run(
        context.walks("obstacle, with", "static", setup.duration, {"admittance": True}, plates=plate(setup)),
        context.walks(
            "obstacle, without", "static", setup.duration, {"admittance": False}, plates=plate(setup)
        ),
    )
    forces = _forces(with_, setup), _forces(without, setup)
    arms = arm(with_), arm(without)
    ratio = forces[0].median / forces[1].median if forces[1].median else math.nan
    pair = pairs(with_, without)
    claims = _claims(setup, arms, forces, ratio)
    findings = [pair_words(pair)]
    body = load_body(context.robot)
    survived = felling = None
    if not context.campaign.interrupted:
        if not claims[1].holds:
            survived = _highest(context, setup)
            findings.append(_tried(setup.lower, setup, "with admittance every run walks over", survived))
        if not claims[0].holds:
            felling = _lowest(context, setup)
            findings.append(_tried(setup.higher, setup, "without admittance enough fall from", felling))
    findings += [
        falls_finding("With", with_, body),
        falls_finding("Without", without, body),
        _force_finding(context, forces, ratio, setup),
    ]
    result = ObstacleResult(
        passed=all(claim.holds for claim in claims),
        with_=arms[0],
        without=arms[1],
        paired=pair,
        force_with=forces[0],
        force_without=forces[1],
        force_ratio=ratio,
        survived_plate=survived,
        felling_plate=felling,
    )
    page = Page(
        name="obstacle",
        title="R1: a plate of 1 cm under the swing foot",
        source=(
            "Thesis 4.1, figures 4.1, 4.2 and 4.8: at t = 17 s, in SSL, an object of 1 cm lies under the "
            "swing foot. Without admittance the contact force reaches 15 N and the robot falls at about 18 "
            "s; with it the force stays at about 5 N, the foot stays on the object for two steps and steps "
            "down at about 32 s."
        ),
        setup=setup_rows(
            context,
            [
                ("gait", "static, T_DSP 2 s, T_SSP 1.5 s"),
                (
                    "plate",
                    f"{1e3 * setup.height:g} mm, under the right foot at {setup.plate_time:g} s of the walk",
                ),
                ("length", f"{setup.duration:g} s"),
                ("arms", "admittance on and off, torso control as the gait ships it"),
            ],
        ),
        claims=claims,
        pictures=_pictures(context, setup, with_[0], without[0]),
        tables=(arms_table({"with admittance": arms[0], "without": arms[1]}),),
        findings=tuple(text for text in findings if text),
    )
    return Outcome(result, page)


def _claims(
    setup: Setup, arms: tuple[Arm, Arm], forces: tuple[Force, Force], ratio: float
) -> tuple[Claim, ...]:
    with_, without = arms
    return (
        Claim(
            f"Without admittance {100 * setup.falls:.0f} % or more fall",
            without.fall_words(),
            1.0 - without.share >= setup.falls - 1e-9,
        ),
        Claim(
            f"With it {100 * setup.survives:.0f} % or more walk on",
            with_.words(),
            with_.share >= setup.survives - 1e-9,
        ),
        Claim(
            "Contact force while loading in SSL at most half of that without",
            f"{forces[0].median:.1f} N with, {forces[1].median:.1f} N without (medians of the peaks): "
            f"{100.0 * ratio:.0f} %",
            ratio <= setup.force_ratio,
        ),
    )


def _share(context: Context, setup: Setup, height: float, *, admittance: bool) -> float:
    """Share of a few runs that walks over a plate of some height, m."""
    few = context.first(setup.probe_seeds)
    arm_name = "with" if admittance else "without"
    (results,) = few.run(
        few.walks(
            f"obstacle, {arm_name}, {1e3 * height:g} mm",
            "static",
            setup.duration,
            {"admittance": admittance},
            plates=plate(replace(setup, height=height)),
            keep_track=False,
        )
    )
    return arm(results).share


def _highest(context: Context, setup: Setup) -> float:
    """Highest lower plate on which every run walks on with admittance, those below it included, m; 0: none."""
    highest = 0.0
    for height in setup.lower:
        if _share(context, setup, height, admittance=True) < 1.0:
            break
        highest = height
    return highest


def _lowest(context: Context, setup: Setup) -> float | None:
    """Lowest higher plate on which enough fall without admittance, m; None: on none of them."""
    for height in setup.higher:
        if _share(context, setup, height, admittance=False) <= 1.0 - setup.falls + 1e-9:
            return height
    return None


def _tried(heights: Sequence[float], setup: Setup, what: str, found: float | None) -> str:
    tried = ", ".join(f"{1e3 * height:g}" for height in heights)
    return (
        f"Other plates, {tried} mm with {setup.probe_seeds} seeds each: {what} "
        f"{f'{1e3 * found:g} mm' if found else 'none of them'}."
    )


def _force_finding(context: Context, forces: tuple[Force, Force], ratio: float, setup: Setup) -> str:
    """Which damping the wanted force would take, as far as the force is damping times speed."""
    if not ratio > setup.force_ratio:
        return ""
    from walker.parameters import controller_parameters

    changes = context.config("static", 0, {}).controller
    damping = controller_parameters("static", changes).leg.D
    wanted = setup.force_ratio * forces[1].median
    return (
        f"The leg admittance yields at F / D: for {wanted:.1f} N, half of what is measured without it, its "
        f"damping leg.D would have to be about {damping * wanted / forces[0].median:.0f} N s/m in place of "
        f"{damping:.0f}."
    )


def _pictures(context: Context, setup: Setup, with_: WalkResult, without: WalkResult) -> tuple[Picture, ...]:
    seed = with_.seed
    note = f"Seed {seed}; blue without, red with admittance."
    out, body = context.out, load_body(context.robot)
    return (
        Picture(
            _plot_force(out / "obstacle-4.1.png", with_.track, without.track, setup.plate_time),
            "Figure 4.1: contact force on the right foot",
            f"{note} Sum of the right foot's four sensors; phases green: 0 DSL, 5 SSL, 10 DSR, 15 SSR.",
        ),
        Picture(
            axes.pitch_and_roll(out / "obstacle-4.2.png", with_.track, without.track),
            "Figure 4.2: pitch of the torso, and its roll",
            f"{note} True angles, positive nose down and to the right.",
        ),
        Picture(
            _plot_feet(
                out / "obstacle-4.8.png",
                with_.track,
                ankle_in_hip(body, "L", with_.track["request"]),
                ankle_in_hip(body, "R", with_.track["request"]),
            ),
            "Figure 4.8: trajectories of the feet with admittance",
            f"Seed {seed}; ankles in the frames of their hips as requested, left solid, right dash-dotted; "
            "phases: 0 DSL, 30 SSL, 60 DSR, 90 SSR.",
        ),
    )


def _plot_force(path: Path, with_: Track, without: Track, plate_time: float) -> Path:
    figure = axes.new_figure(9.0, 7.0)
    longer = with_ if len(with_) >= len(without) else without
    whole, landing = figure.subplots(2, 1)
    for panel in (whole, landing):
        axes.phase_line(panel, longer, 5.0, axes.GREEN)
        axes.two_arms(panel, with_, without, lambda track: track["fsr"][:, 4:].sum(axis=1))
        axes.finish(panel, "t / s", "F_R,Foot,z / N")
    landing.axvline(plate_time, color="k", linestyle=":", linewidth=0.9)
    landing.set(xlim=(plate_time - 1.5, plate_time + 2.5), title="about the plate")
    return axes.save(figure, path)


def _plot_feet(path: Path, track: Track, left: Array, right: Array) -> Path:
    figure = axes.new_figure()
    panel = figure.subplots()
    axes.feet(panel, track["time"], left, right)
    axes.phase_line(panel, track, 30.0)
    axes.finish(panel, "t / s", "p_i,0^i,8 / mm")
    return axes.save(figure, path)
