"""The search for the steepest slope, on robots whose limit is known."""

from collections.abc import Callable

import pytest

from nao_hil.experiments.slope import SlopeSetup, search, trial

Robot = Callable[[float, int], bool]


def answered(robot: Robot, seeds: int, setup: SlopeSetup) -> tuple[float, int]:
    """Slope that is found, and runs that it took."""
    steps = search(tuple(range(seeds)), setup)
    slope, tried = next(steps)
    seen: set[tuple[float, int]] = set()
    for _ in range(1000):
        seen |= {(slope, seed) for seed in tried}
        try:
            slope, tried = steps.send([robot(slope, seed) for seed in tried])
        except StopIteration as stop:
            return stop.value, len(seen)
    raise AssertionError("the search does not end")


@pytest.mark.parametrize("limit", [0.0, 0.5, 3.0, 4.5, 5.0, 7.5, 9.5, 10.0])
def test_a_sharp_limit_is_found_on_the_half_degree(limit: float) -> None:
    found, runs = answered(lambda slope, _: slope <= limit + 0.2, 20, SlopeSetup())
    assert found == limit
    # bisection: at most five slopes in the search, and the 20 seeds of the last one
    assert runs <= 5 * 10 + 20


def test_the_bound_of_the_interval_decides() -> None:
    """Wilson's lower bound of 19 of 20 is 76 %, of 20 of 20 84 %."""
    fewer = SlopeSetup(share=0.7)
    for setup, found in ((SlopeSetup(), 4.5), (fewer, 6.0)):
        robot = lambda slope, seed: slope <= 6.0 and (slope < 5.0 or seed != 13)  # noqa: E731
        assert answered(robot, 20, setup)[0] == found


@pytest.mark.parametrize(
    ("alive", "passes", "runs"),
    [([True] * 10, True, 9), ([False] * 10, False, 2), ([True, False] * 5, False, 4)],
)
def test_a_trial_ends_as_soon_as_it_is_sure(alive: list[bool], passes: bool, runs: int) -> None:
    steps = trial(5.0, range(10), 9, 1)
    _, seeds = next(steps)
    count = 0
    for _ in range(20):
        count += len(seeds)
        try:
            _, seeds = steps.send([alive[seed] for seed in seeds])
        except StopIteration as stop:
            assert (stop.value, count) == (passes, runs)
            return
    raise AssertionError("the trial does not end")
