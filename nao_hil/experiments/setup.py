"""The part of every page that says with what it was made."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from nao_hil.experiments.context import Context


def setup_rows(context: Context, rows: Sequence[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """An experiment's own rows, then robot, wear, seeds, and what was changed of the shipped parameters."""
    changes = context.changes
    changed = {
        table: values
        for table, values in (("parameters", changes.parameters), ("controller", changes.controller))
        if values
    }
    return (
        *rows,
        ("robot", f"{context.robot}, {context.wear} drives and sensors"),
        ("seeds", seed_words(context.seeds)),
        *(
            ((f"changed ({changes.gait} gait)", msgspec.json.encode(changed).decode()),)
            if changed
            else (("parameters", "as shipped"),)
        ),
    )


def seed_words(seeds: Sequence[int]) -> str:
    """`0 to 19 (20)`, or the list where it has gaps."""
    if len(seeds) > 1 and list(seeds) == list(range(seeds[0], seeds[0] + len(seeds))):
        return f"{seeds[0]} to {seeds[-1]} ({len(seeds)})"
    return ", ".join(map(str, seeds))
