"""The thesis' configuration on this robot: its admittances and torso control alone, and one of them less."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec

from nao_hil.experiments.arms import Arm, arm
from nao_hil.experiments.context import Context, Plates
from walker.stabilization.switches import NAMED


class ThesisArms(msgspec.Struct, frozen=True, kw_only=True):
    """The thesis' configuration with and without the mechanism that its claim credits."""

    with_: Arm = msgspec.field(name="with")
    without: Arm

    def table(self, off: str) -> dict[str, Arm]:
        """Rows for `arms_table`; `off` names what is off in the second."""
        return {"the thesis' configuration": self.with_, f"the thesis', {off}": self.without}

    def words(self, off: str) -> str:
        """What it does on this robot, in a sentence."""
        return (
            f"The thesis' configuration (its admittances and torso control alone): {self.with_.words()}; "
            f"{off}: {self.without.words()}."
        )


def thesis_arms(
    context: Context,
    name: str,
    gait: str,
    duration: float,
    off: dict[str, Any],
    plates: Callable[[int], Plates] | None = None,
) -> ThesisArms:
    """Walk both.

    Args:
        context: Of the experiment.
        name: Of the experiment.
        gait: Name.
        duration: s
        off: Of the one switch that is off in the second arm; others count where they are the thesis' anyway.
        plates: Of a seed.
    """
    thesis: dict[str, Any] = msgspec.to_builtins(NAMED["thesis"])
    with_, without = context.run(
        *(
            context.walks(f"{name}, {arm_name}", gait, duration, switches, plates=plates, keep_track=False)
            for arm_name, switches in (("thesis", thesis), ("thesis, without", thesis | off))
        )
    )
    return ThesisArms(with_=arm(with_), without=arm(without))
