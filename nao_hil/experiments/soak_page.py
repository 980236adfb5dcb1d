"""Page and figure of the soak."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from nao_hil.analysis.report.page import Claim, Picture, ReportPage
from nao_hil.experiments.context import Context
from nao_hil.experiments.soak_result import LARGEST_DRIFT, LARGEST_GROWTH, Soak, as_punctual, lateness
from nao_hil.files import atomic_path

GAIT: Final = "static"


def soak_page(context: Context, duration: float, result: Soak, picture: Path) -> ReportPage:
    """Claims, figure and setup of the soak."""
    claims = [
        Claim(
            f"It walks for {duration:g} s",
            f"{result.seconds:.0f} s watched" + ("" if result.done else "; walker.log says why no more"),
            result.done,
        ),
        Claim("No fall", "fell" if result.fell else f"{result.steps} steps, upright", not result.fell),
    ]
    for who, use in (("robot", result.robot_use), ("walker", result.walker_use)):
        claims += [
            Claim(
                f"The {who}'s memory grows by less than {LARGEST_GROWTH:g} MB",
                f"{use.growth_mb:+.2f} MB to {use.memory_mb:.0f} MB",
                use.growth_mb < LARGEST_GROWTH,
            ),
            Claim(
                f"The {who} opens no more files",
                f"{use.descriptor_growth:+d} to {use.descriptors}",
                use.descriptor_growth <= 0,
            ),
        ]
    late, bare = ([f"{1e3 * s:.2f} ms" for s in both] for both in (result.lateness, result.lateness_bare))
    claims += [
        Claim(
            "Frames are as punctual in the end as in the beginning",
            f"99 % within {late[0]} at first, {late[1]} at last; of a bare loop {bare[0]} and {bare[1]}",
            as_punctual(result.lateness, result.lateness_bare),
        ),
        Claim("Robot time does not drift", f"{1e6 * result.drift:+.0f} us", abs(result.drift) <= LARGEST_DRIFT),
    ]
    return ReportPage(
        name="soak",
        title="A long walk",
        source="No part of the thesis.",
        setup=(
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            ("walk", f"{result.seconds:.0f} s of the {GAIT} gait in real time, two processes over loopback"),
            ("cycles", f"{result.cycles}, {result.missed} missed, {result.skipped} skipped"),
        ),
        claims=tuple(claims),
        pictures=(
            Picture(
                picture, "Memory and lateness", "Lateness beyond the earliest frame of the next ten seconds."
            ),
        ),
    )


def draw(
    frames: list[tuple[int, int]],
    cycle: float,
    samples: list[tuple[float, list[float], list[int]]],
    file: Path,
) -> None:
    """Memory of both processes above, lateness of the frames below, over time."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, (above, below) = plt.subplots(2, 1, figsize=(7, 5), layout="constrained")
    for i, who in enumerate(("robot", "walker")):
        above.plot([s[0] for s in samples], [s[1][i] for s in samples], label=who)
    above.set_ylabel("resident memory, MB")
    above.legend()
    late, _ = lateness(frames, cycle)
    below.plot([cycle * (seq - frames[0][0]) for seq, _ in frames], 1e3 * late, lw=0.3)
    below.set_ylabel("lateness, ms")
    below.set_xlabel("time, s")
    with atomic_path(file) as temporary:
        figure.savefig(temporary, dpi=120)
    plt.close(figure)
