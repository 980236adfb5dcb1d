"""From a recording to its comparison with an emulated robot."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from nao_hil.identification.comparison import Comparison, compare
from nao_hil.identification.recorded import RecordedSignals
from nao_hil.identification.replay import replay
from nao_hil.identification.signals import Signals
from nao_hil.runs.config import RunConfig

_READ = ("robot", "wear", "engine", "scenario", "start", "seed")
"""What of a configuration a replay reads."""


def compare_recording(
    recorded: RecordedSignals,
    name: str,
    settings: RunConfig,
    progress: Callable[[float], None] = lambda _: None,
) -> tuple[Comparison, Signals]:
    """Replay a recording with two seeds, and measure.

    Args:
        recorded: The recording.
        name: Of its file, for the result.
        settings: The emulated robot; the noise floor's replay has the next seed.
        progress: Told of the share that is done.

    Returns:
        The numbers, and the first replay.

    Raises:
        ConfigurationError: no such body, wear profile, scenario or start.
    """
    half = 0.5 / len(recorded.signals.time)
    first = replay(recorded, settings, lambda done: progress(half * done))
    other = msgspec.structs.replace(settings, seed=settings.seed + 1)
    second = replay(recorded, other, lambda done: progress(0.5 + half * done))
    joints, sensors = compare(recorded.body, recorded.signals, first, second)
    result = Comparison(
        recording=name,
        config={key: getattr(settings, key) for key in _READ},
        seconds=float(recorded.signals.time[-1]),
        first=joints[0].joint if joints and joints[0].excess > 0.0 else "",
        joints=joints,
        sensors=sensors,
    )
    return result, first
