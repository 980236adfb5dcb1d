"""Which physics engine a command uses, said when it is not the usual one."""

from __future__ import annotations

from rich.console import Console

from nao_hil.runs.config import RunConfig


def chosen_engine(settings: RunConfig, console: Console) -> RunConfig:
    """The configuration with its engine by name; a missing PyBullet is told in a sentence.

    Raises:
        ConfigurationError: the engine that was asked for is not installed.
    """
    # imported late: the walker's machine has no physics engine
    from emulator.engine.catalogue import ENGINES, WITHOUT_PYBULLET, require_engine
    from nao_hil.runs.build import with_engine

    chosen = with_engine(settings)
    require_engine(chosen.engine)
    if settings.engine == "auto" and chosen.engine != ENGINES[0]:
        console.print(WITHOUT_PYBULLET, highlight=False)
    return chosen
