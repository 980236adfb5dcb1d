"""How bad may the network be? Walks in real time over lines with delay, jitter and loss.

Robot and walker run in two network namespaces; between them packets are delayed and dropped (`lab.weather`).
The link is TCP: a lost packet is late, not missing, and holds up those behind it.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Final, NamedTuple

import msgspec

from lab.campaign.campaign import Interrupted
from lab.campaign.proportion import wilson
from lab.experiments.context import Context
from lab.experiments.page import Claim, Outcome, Page, Picture, Table
from lab.weather import Site, Weather
from lab.weather.kept import depends_on, kept
from lab.weather.walks import Pair, WalkedInWeather, options

GAITS: Final = ("static", "dynamic")
STEPS: Final = 4
DELAYS: Final = (0.0, 0.005, 0.010, 0.020)
"""s, one way."""
JITTERS: Final = (0.0, 0.005)
"""s, each way."""
LOSSES: Final = (0.0, 0.01)
"""Share of packets, each way."""
PATIENCE: Final = 120.0
"""s for a walk of a few steps, which takes under 40 in good weather on an idle machine."""


class Cell(msgspec.Struct, frozen=True, kw_only=True):
    """One kind of weather and what became of the walks in it."""

    gait: str
    delay: float
    jitter: float
    loss: float
    n: int
    success: int
    interval: tuple[float, float]
    """Of the share of successes, 95 %."""
    stopped: int
    """Walks that the walker ended because the link was worse than it bears."""
    fell: int
    missed: float
    """Share of cycles without a timely answer, mean."""
    torso_max: float
    """rad, mean."""


class WeatherMap(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil experiment weather`."""

    name: str = "weather"
    passed: bool
    n: int
    cells: list[Cell]


class Task(NamedTuple):
    """One walk to be made."""

    gait: str
    weather: Weather
    seed: int

    @property
    def name(self) -> str:
        """For its folder, and for people."""
        w = self.weather
        return f"{self.gait}-{1e3 * w.delay:g}-{1e3 * w.jitter:g}-{100 * w.loss:g}-{self.seed}"


def experiment(context: Context) -> Outcome:
    """The map; each cell with one walk per seed, seed by seed, several at a time.

    Raises:
        LinkError: no root, no namespaces, or a process failed.
        Interrupted: stopped before every cell had a walk.
    """
    kinds = [
        (gait, Weather(delay=delay, jitter=jitter, loss=loss))
        for gait, loss, jitter, delay in itertools.product(GAITS, LOSSES, JITTERS, DELAYS)
        if jitter <= delay
    ]
    tasks = [Task(gait, weather, seed) for seed in context.seeds for gait, weather in kinds]
    key = depends_on(context.changes)

    def walk(task: Task) -> WalkedInWeather:
        folder = context.out / "walks" / task.name
        return kept(folder / "result.json", key, WalkedInWeather, lambda: _walk(context, task, folder))

    walked = context.campaign.watch(walk, tasks, lambda task, result: (task.name, result.note))
    of_kind: dict[tuple[str, Weather], list[WalkedInWeather]] = {kind: [] for kind in kinds}
    for task, one in zip(tasks, walked, strict=True):
        if one is not None:
            of_kind[task.gait, task.weather].append(one)
    if not all(of_kind.values()):
        raise Interrupted
    cells = [_cell(gait, weather, walks) for (gait, weather), walks in of_kind.items()]
    calm = all(c.success == c.n for c in cells if c.delay == c.jitter == c.loss == 0.0)
    result = WeatherMap(passed=calm, n=min(c.n for c in cells), cells=cells)
    picture = context.out / "weather.png"
    draw(cells, picture)
    return Outcome(result, _page(context, result, picture))


def _walk(context: Context, task: Task, folder: Path) -> WalkedInWeather:
    robot, walker = options(context.changes, task.gait, task.seed, STEPS)
    with Site(task.seed) as site, Pair(site, folder, robot, walker) as pair:
        site.line.set(task.weather)
        pair.wait(PATIENCE, lambda: context.campaign.interrupted)
        end = pair.end()
        recordings = pair.recordings
    if context.campaign.interrupted:
        raise Interrupted
    if not end.fell:  # hundreds of walks; those that fell are worth a look
        for recording in recordings:
            recording.unlink(missing_ok=True)
    return end


def _cell(gait: str, weather: Weather, walks: list[WalkedInWeather]) -> Cell:
    success = sum(walk.success for walk in walks)
    return Cell(
        gait=gait,
        delay=weather.delay,
        jitter=weather.jitter,
        loss=weather.loss,
        n=len(walks),
        success=success,
        interval=wilson(success, len(walks)),
        stopped=sum(walk.stopped for walk in walks),
        fell=sum(walk.fell for walk in walks),
        missed=sum(walk.missed / max(1, walk.cycles) for walk in walks) / len(walks),
        torso_max=sum(walk.torso_max for walk in walks) / len(walks),
    )


def _page(context: Context, result: WeatherMap, picture: Path) -> Page:
    head = (
        "gait",
        "delay, ms",
        "jitter, ms",
        "loss, %",
        "walked",
        "95 %",
        "stopped",
        "fell",
        "missed cycles, %",
    )
    rows = tuple(
        (
            c.gait,
            f"{1e3 * c.delay:g}",
            f"{1e3 * c.jitter:g}",
            f"{1e2 * c.loss:g}",
            f"{c.success} of {c.n}",
            f"{c.interval[0]:.2f} to {c.interval[1]:.2f}",
            str(c.stopped),
            str(c.fell),
            f"{1e2 * c.missed:.1f}",
        )
        for c in result.cells
    )
    calm = [c for c in result.cells if c.delay == c.jitter == c.loss == 0.0]
    return Page(
        name="weather",
        title="Walks over a bad network",
        source="No part of the thesis, whose controller ran on the robot.",
        setup=(
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            ("walk", f"{STEPS} steps in real time, two processes in two network namespaces, TCP"),
        ),
        claims=tuple(
            Claim(
                f"The {c.gait} gait walks over a line that does nothing",
                f"{c.success} of {c.n}",
                c.success == c.n,
            )
            for c in calm
        ),
        pictures=(
            Picture(picture, "Share of walks that made all their steps", "Delay and jitter are one way."),
        ),
        tables=(Table("Weather and success", head, rows),),
    )


def draw(cells: list[Cell], file: Path) -> None:
    """One map per gait and loss: delay to the right, jitter upwards."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    gaits, losses = list(dict.fromkeys(c.gait for c in cells)), sorted({c.loss for c in cells})
    delays, jitters = sorted({c.delay for c in cells}), sorted({c.jitter for c in cells})
    figure, axes = plt.subplots(
        len(gaits),
        len(losses),
        figsize=(4.2 * len(losses), 2.3 * len(gaits)),
        squeeze=False,
        layout="constrained",
    )
    for (i, gait), (j, loss) in itertools.product(enumerate(gaits), enumerate(losses)):
        axis = axes[i][j]
        grid = [[float("nan")] * len(delays) for _ in jitters]
        for c in cells:
            if (c.gait, c.loss) == (gait, loss):
                y, x = jitters.index(c.jitter), delays.index(c.delay)
                grid[y][x] = c.success / c.n
                axis.text(
                    x,
                    y,
                    f"{c.success}/{c.n}\n{c.stopped} stopped\n{c.fell} fell",
                    ha="center",
                    va="center",
                    size=7,
                )
        axis.imshow(grid, origin="lower", vmin=0.0, vmax=1.0, cmap="RdYlGn", aspect="auto", alpha=0.8)
        axis.set_xticks(range(len(delays)), [f"{1e3 * d:g}" for d in delays])
        axis.set_yticks(range(len(jitters)), [f"{1e3 * d:g}" for d in jitters])
        axis.set_title(f"{gait} gait, {100 * loss:g} % loss", size=9)
        axis.set_xlabel("delay one way, ms")
        axis.set_ylabel("jitter, ms")
    figure.savefig(file, dpi=130)
    plt.close(figure)
