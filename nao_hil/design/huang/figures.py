"""Pictures of a plan of the gait huang: margin surface, ZMP, trajectories and a strip of stick figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import matplotlib
import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.kinematics import BodyTree
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.search import along
from nao_hil.files import save_figure
from walker.gaits.gait import dry_walk
from walker.gaits.huang import HuangGait, HuangParameters
from walker.gaits.huang.hip import Choice
from walker.gaits.huang.multibody import Ankle, Bodies
from walker.gaits.plan import Plan
from walker.gaits.pose import ARMS

matplotlib.use("Agg")
from matplotlib import pyplot as plt

LEVEL_SPACING: Final = 2.5
"""mm between two colours of the margin."""
DT: Final = 0.005
"""s; sampling of the walk that is drawn."""
STEPS: Final = 6
_POSES_PER_CYCLE: Final = 6
"""Figures per cycle."""
_POSE_SPACING: Final = 0.17
"""m, between them."""


def draw(p: HuangParameters, body: Body, choice: Choice, folder: Path) -> list[Path]:
    """Draw a plan.

    Returns:
        The files.
    """
    cycle = Cycle(p, body, ARMS)
    gait = HuangGait(msgspec.structs.replace(p, **choice._asdict()), body)
    walk = []
    for plan, state in dry_walk(gait, DT):
        walk.append((plan, gait.pose(state)))
        if plan.step >= STEPS:
            break
    figures = {
        "margin": _margin(cycle, choice),
        "zmp": _zmp(cycle, choice),
        "trajectories": _trajectories([plan for plan, _ in walk], p),
        "sticks": _sticks(body, walk, p),
    }
    files = []
    for name, figure in figures.items():
        files.append(folder / f"huang-{name}.png")
        save_figure(figure, files[-1])
        plt.close(figure)
    return files


def _margin(cycle: Cycle, choice: Choice) -> Any:
    """The margin over the grid, the chosen point, and the bound (11)."""
    cycle.p = msgspec.structs.replace(cycle.p, x_sd=None, x_ed=None)
    _, surface = along(cycle, choice)
    figure, axes = plt.subplots(figsize=(7.0, 5.6), layout="constrained")
    lowest, highest = max(1e3 * surface.margin.min(), -30.0), 1e3 * surface.margin.max()
    levels = LEVEL_SPACING * np.arange(np.floor(lowest / LEVEL_SPACING), np.ceil(highest / LEVEL_SPACING) + 1.0)
    filled = axes.contourf(
        1e3 * surface.first, 1e3 * surface.second, 1e3 * surface.margin.T, levels, extend="min", cmap="viridis"
    )
    zero = axes.contour(1e3 * surface.first, 1e3 * surface.second, surface.margin.T, [0.0], colors="white")
    axes.clabel(zero, fmt="0 mm")
    i, j = surface.best()
    axes.plot(
        1e3 * surface.first[i], 1e3 * surface.second[j], "s", mfc="none", mec="white", label="best of the grid"
    )
    axes.plot(1e3 * choice.x_sd, 1e3 * choice.x_ed, "r*", ms=12, label="chosen")
    bound = 500.0 * cycle.p.D_s
    axes.set(
        xlabel="x_sd, mm",
        ylabel="x_ed, mm",
        xlim=(0.0, bound),
        ylim=(0.0, bound),
        title="Stability margin over the cycle within bound (11)",
    )
    axes.legend(loc="lower left")
    figure.colorbar(filled, label="margin d_zmp, mm")
    return figure


def _zmp(cycle: Cycle, choice: Choice) -> Any:
    """The ZMP in the support polygons, and its coordinates with the pendulum's."""
    x, y = cycle.zmp(choice)
    p_x, p_y = cycle.pendulum_zmp(choice)
    margins = cycle.support.margins(x[:, None], y[:, None])[:, 0]
    figure = plt.figure(figsize=(11.0, 6.0), layout="constrained")
    left, right = figure.subfigures(1, 2)
    axes = left.subplots()
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 1.0, len(x)))
    for i in range(0, len(x), 2):
        corners = np.vstack((cycle.support.polygons[i], cycle.support.polygons[i][:1]))
        axes.plot(1e3 * corners[:, 0], 1e3 * corners[:, 1], color=colours[i], lw=0.8)
    axes.plot(1e3 * p_x, 1e3 * p_y, "--", color="grey", lw=1.0, label="pendulum")
    axes.plot(1e3 * x, 1e3 * y, "k-", lw=1.2, label="all bodies")
    axes.scatter(1e3 * x, 1e3 * y, c=colours, s=18, zorder=3)
    axes.set(xlabel="x, mm", ylabel="y, mm", aspect="equal", title="ZMP and support polygons over a cycle")
    axes.legend()
    rows = right.subplots(3, 1, sharex=True)
    for row, (name, all_bodies, pendulum) in zip(rows, (("x", x, p_x), ("y", y, p_y)), strict=False):
        row.plot(cycle.times, 1e3 * all_bodies, label="all bodies (13), (14)")
        row.plot(cycle.times, 1e3 * pendulum, "--", label="pendulum (3.4)")
        row.axvspan(0.0, cycle.p.T_d, color="0.92")
        row.set(ylabel=f"{name}_zmp, mm")
    rows[0].legend()
    rows[2].plot(cycle.times, 1e3 * margins)
    rows[2].axvspan(0.0, cycle.p.T_d, color="0.92")
    rows[2].set(ylabel="margin, mm", xlabel="time of the cycle, s (grey: double support)", ylim=(0.0, None))
    return figure


def _trajectories(walk: list[Plan], p: HuangParameters) -> Any:
    """Feet and hip from rest to the steady cycle."""
    times = DT * np.arange(1, len(walk) + 1)
    figure, rows = plt.subplots(5, 1, figsize=(9.0, 10.0), sharex=True, layout="constrained")
    for name, side in (("left", "left"), ("right", "right")):
        feet = [getattr(plan, side) for plan in walk]
        rows[0].plot(times, [1e3 * foot.x for foot in feet], label=f"{name} foot")
        rows[1].plot(times, [1e3 * foot.z for foot in feet], label=f"{name} foot")
        rows[2].plot(times, np.degrees([foot.pitch for foot in feet]), label=f"{name} foot")
    com, zmp = np.array([r.com for r in walk]), np.array([r.zmp for r in walk])
    rows[0].plot(times, 1e3 * com[:, 0], "k", label="mass (hip + its offset at rest)")
    rows[0].plot(times, 1e3 * zmp[:, 0], "k:", lw=0.8, label="ZMP")
    rows[3].plot(times, [1e3 * r.hip_height for r in walk], "k")
    rows[4].plot(times, 1e3 * com[:, 1], "k", label="mass (hip + its offset at rest)")
    rows[4].plot(times, 1e3 * zmp[:, 1], "k:", lw=0.8, label="ZMP")
    labels = ("x, mm", "sole's z, mm", "pitch, deg", "hip's z, mm", "y, mm")
    for row, label in zip(rows, labels, strict=True):
        row.set(ylabel=label)
        for i, plan in enumerate(walk):
            if plan.support == "both":
                row.axvspan(times[i] - DT, times[i], color="0.93", lw=0.0)
    rows[0].legend(ncols=4)
    rows[4].legend()
    rows[4].set(xlabel="time, s (grey: both feet bear)")
    rows[0].set(title=f"D_s = {1e3 * p.D_s:.0f} mm every {p.T_c} s")
    return figure


def _sticks(
    body: Body,
    walk: list[tuple[Plan, tuple[tuple[float, float, float], Ankle, Ankle]]],
    p: HuangParameters,
) -> Any:
    """Stick figures from the side, as in figure 2 of the source."""
    tree, bodies = BodyTree(body), Bodies(body, ARMS)
    place = {name: i for i, name in enumerate(tree.links)}
    along_sole = [x for x, _ in body.foot.sole]
    figure, axes = plt.subplots(figsize=(12.0, 4.2), layout="constrained")
    first = next(i for i, (r, _) in enumerate(walk) if r.step >= STEPS - 3)
    shown = walk[first :: round(p.T_c / _POSES_PER_CYCLE / DT)][: 2 * _POSES_PER_CYCLE + 1]
    for i, (plan, pose) in enumerate(shown):
        frames = bodies.frames(*pose)
        shift = _POSE_SPACING * i - pose[0][0]
        for side, colour in (("R", "tab:red"), ("L", "tab:blue")):
            hip, knee, ankle = (
                frames[place[f"{side}{joint}"], :3, 3] for joint in ("HipPitch", "KneePitch", "AnklePitch")
            )
            foot = frames[place[f"{side}AnkleRoll"]]
            low = -body.lengths.FootHeight
            heel, toe = ((foot @ np.array([x, 0.0, low, 1.0]))[:3] for x in (min(along_sole), max(along_sole)))
            line = np.array([hip, knee, ankle, heel, toe, ankle])
            bears = plan.support in (side, "both")
            axes.plot(1e3 * (line[:, 0] + shift), 1e3 * line[:, 2], color=colour, lw=1.4 if bears else 0.7)
        torso = np.array([pose[0], (pose[0][0], 0.0, pose[0][2] + 0.18)])
        axes.plot(1e3 * (torso[:, 0] + shift), 1e3 * torso[:, 2], "k", lw=1.0)
    axes.axhline(0.0, color="0.6", lw=0.8)
    axes.set(
        aspect="equal",
        xlabel=f"mm; the figures stand {1e3 * _POSE_SPACING:.0f} mm apart, {p.T_c / _POSES_PER_CYCLE:.2f} s",
        ylabel="z, mm",
    )
    axes.set_title("Two cycles from the side: left leg blue, right leg red; thick where the foot bears")
    return figure
