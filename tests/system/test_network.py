"""Walks between two network namespaces: over a slow link, and with an outage during the walk."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("pybullet")

from nao_hil.experiments.context import Context
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from tests.measure import network, outages

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(
        not hasattr(os, "geteuid")
        or os.geteuid() != 0
        or shutil.which("ip") is None
        or not Path("/dev/net/tun").exists(),
        reason="needs root, iproute2 and /dev/net/tun",
    ),
]


@pytest.fixture
def context(tmp_path: Path) -> Iterator[Context]:
    with Campaign(cluster="local:1") as campaign:
        yield Context(campaign, tmp_path, (3,), RunConfig())


def test_a_walk_over_a_slow_line_is_walked_with_every_answer_late(
    context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in {"GAITS": ("dynamic",), "DELAYS": (0.008,), "JITTERS": (0.0,), "LOSSES": (0.0,)}.items():
        monkeypatch.setattr(network, name, value)
    (cell,) = network.measure(context)
    assert (cell.completed.n, cell.completed.survived, cell.fell) == (1, 1, 0)
    # 16 ms there and back: while it walks no answer is there within its cycle of 10 ms.
    assert cell.missed > 0.3


def test_a_dynamic_walk_with_an_outage_stays_upright_and_is_walked_to_its_end(
    context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(outages, "STEPS", {"dynamic": 24})
    monkeypatch.setattr(outages, "EVENTS", ("outage of 2 s",))
    (walk,) = outages.measure(context)
    assert walk.walked and not walk.fell and not walk.walker
    assert "guard-hold" in walk.notices and "guard-crouch" in walk.notices
    assert all(count > 1000 for count in walk.recordings)
