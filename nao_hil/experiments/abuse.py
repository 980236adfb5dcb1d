"""Abuse: what no robot should be made to bear, and whether the emulated one stays a physical body in it.

Random commands inside and outside the limits, random stiffness, pushes, falls, lying about, put back on its
feet by hand. In between the drives are cut, and the robot must not gain mechanical energy from nowhere.
"""

from __future__ import annotations

import argparse

import msgspec
import numpy as np

from bridge.body import Body, load_body
from emulator.robot import EmulatedRobot
from emulator.wear import WearProfile, load_wear
from nao_hil.analysis.report.page import Claim, Outcome, ReportPage
from nao_hil.experiments.abuse_run import LARGEST_EXCESS, LARGEST_RISE, AbuseResult, AbuseRun
from nao_hil.experiments.context import Context


def run(seconds: float, *, seed: int, body: Body, wear: WearProfile, engine: str = "auto") -> AbuseResult:
    """Abuse a robot.

    Args:
        seconds: Robot time.
        seed: Of the abuse and of the robot.
        body: Data sheet.
        wear: State of its drives.
        engine: Name of the physics engine.
    """
    random = np.random.default_rng(seed)
    with EmulatedRobot(body, seed=seed, wear=wear, engine=engine) as robot:
        return AbuseRun(robot, random).run(seconds)


def experiment(context: Context) -> Outcome:
    """A minute of it per seed, in a row, as a page of the report."""
    minutes = float(len(context.seeds))
    body = load_body(context.robot)
    result = run(
        60.0 * minutes,
        seed=context.seeds[0],
        body=body,
        wear=load_wear(context.wear, body),
        engine=context.engine,
    )
    claims = (
        Claim("Every number of every frame is finite", "yes" if result.finite else "no", result.finite),
        Claim(
            f"No joint is more than {LARGEST_EXCESS:g} degree beyond its stop",
            f"{result.stop_excess_deg:.2f} deg ({result.stop_excess_joint})",
            result.stop_excess_deg <= LARGEST_EXCESS,
        ),
        Claim(
            f"A limp robot gains no more than {LARGEST_RISE:g} J",
            f"{result.energy_rise_j:.4f} J",
            result.energy_rise_j <= LARGEST_RISE,
        ),
    )
    page = ReportPage(
        name="abuse",
        title="Random commands, pushes and falls",
        source="Bounds of a physical body; no part of the thesis.",
        setup=(
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            ("length", f"{minutes:g} min, {result.falls} falls, seed {context.seeds[0]}"),
        ),
        claims=claims,
    )
    return Outcome(result, page)


def main() -> None:
    """Ten minutes on the nominal V3, unless told otherwise."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0, help="robot time")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--robot", default="nao-v3")
    parser.add_argument("--wear", default="nominal")
    options = parser.parse_args()
    body = load_body(options.robot)
    result = run(
        60.0 * options.minutes,
        seed=options.seed,
        body=body,
        wear=load_wear(options.wear, body),
    )
    print(msgspec.json.format(msgspec.json.encode(result)).decode())


if __name__ == "__main__":
    main()
