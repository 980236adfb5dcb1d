"""Plans for tests."""

from __future__ import annotations

from walker.gaits import Plan, SolePose
from walker.gaits.plan import Support


def supported_plan(support: Support, progress: float = 0.5) -> Plan:
    """Feet 0.1 m apart, the right one 0.06 m ahead: a single support of the left leg, else a double support."""
    return Plan(
        phase="SSL" if support == "L" else "DSL",
        support=support,
        progress=progress,
        step=0,
        left=SolePose(0.0, 0.05),
        right=SolePose(0.06, -0.05),
        com=(0.0, 0.0),
        zmp=(0.0, 0.0),
        hip_height=0.215,
    )
