"""`nao-hil tune`: a study that optimises parameters of a gait and its controllers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import typer

from bridge.body import load_body
from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.console import Answer, chosen_engine, open_console
from nao_hil.cli.progress import running_campaign
from nao_hil.runs.config import run_config
from nao_hil.runs.folder import RunDirectory

if TYPE_CHECKING:
    from optuna import Study
    from rich.console import Console

    from nao_hil.campaigns.objective import Ensemble
    from nao_hil.campaigns.study import Range
    from nao_hil.runs.walk import Walk, WalkEnd


def tune(
    ranges: Annotated[
        list[str] | None, typer.Argument(help="Parameters with their ranges.", metavar="NAME=LOW:HIGH[:log]...")
    ] = None,
    space: Annotated[
        Path | None, typer.Option("--space", help="TOML with the same: NAME = [LOW, HIGH].", metavar="FILE")
    ] = None,
    gait: options.Gait = None,
    engine: options.Engine = None,
    config: options.Config = None,
    robot: Annotated[list[str] | None, typer.Option("--robot", help="Body; may be repeated.")] = None,
    wear: Annotated[list[str] | None, typer.Option("--wear", help="Wear; may be repeated.")] = None,
    scenario: Annotated[list[str] | None, typer.Option("--scenario", help="World; may be repeated.")] = None,
    unseen_wear: Annotated[
        list[str] | None,
        typer.Option("--unseen-wear", help="Wear of the comparison; may be repeated; default: --wear."),
    ] = None,
    trials: Annotated[int, typer.Option("--trials", help="Of the whole study.", min=1, metavar="N")] = 100,
    seeds: Annotated[int, typer.Option("--seeds", help="Per robot and world.", min=1, metavar="N")] = 20,
    first_seed: Annotated[int, typer.Option("--first-seed", help="The first seed.", min=0, metavar="N")] = 0,
    duration: Annotated[float, typer.Option("--duration", help="Of a walk, s.", min=0.1, metavar="S")] = 10.0,
    study: Annotated[
        str | None,
        typer.Option("--study", help="Database that keeps it; default: study.db in its folder.", metavar="URL"),
    ] = None,
    cluster: options.Cluster = "local",
    out: options.Out = None,
) -> Answer | int:
    """Optimise parameters of a walk over an ensemble of robots, worlds and seeds.

    The same command with the same --out or --study continues it; several share one study. Ends with
    tuned.toml, importance.png, and before and after on seeds outside of the study.

    Example: nao-hil tune controller.damping.roll=0:0.15 controller.damping.pitch=0:0.15 --gait dynamic
    """
    try:
        from emulator.scenarios import load_scenario
        from emulator.wear import load_wear
        from nao_hil.campaigns.objective import Ensemble
        from nao_hil.campaigns.tuned import read_space
    except ModuleNotFoundError as error:
        raise ConfigurationError(f"`tune` needs {error.name}; install nao-hil[campaign].") from None
    dimensions: dict[str, Range] = read_space(ranges or [], space)
    console = open_console()
    base = chosen_engine(run_config(config, gait=gait, engine=engine))
    ensemble = Ensemble(
        base=base,
        robots=tuple(robot or [base.robot]),
        wears=tuple(wear or [base.wear]),
        scenarios=tuple(scenario or [base.scenario]),
        first_seed=first_seed,
        seeds=seeds,
        duration=duration,
    )
    others = msgspec.structs.replace(ensemble, wears=tuple(unseen_wear or ensemble.wears))
    for each in (ensemble, others):
        for name in each.robots:
            body = load_body(name)
            for profile in each.wears:
                load_wear(profile, body)
        for world in each.scenarios:
            load_scenario(world)
        each.walks({name: r.low for name, r in dimensions.items()})  # a wrong name is an error before all else
    directory = RunDirectory(out)
    directory.write_config(base)
    url = study or f"sqlite:///{(directory.path / 'study.db').absolute()}"
    return _improve(directory, url, dimensions, ensemble, others, trials, cluster, console)


def _improve(
    directory: RunDirectory,
    url: str,
    dimensions: dict[str, Range],
    ensemble: Ensemble,
    others: Ensemble,
    trials: int,
    cluster: str,
    console: Console,
) -> Answer | int:
    """Open the study at a URL, improve it on one ensemble, and compare its best parameters on the other."""
    from nao_hil.campaigns import study as studies
    from nao_hil.campaigns import tuned

    kept = studies.open_study(url, dimensions, ensemble)
    if (before := studies.shipped(dimensions, ensemble)) is not None:
        studies.enqueue(kept, before)
    with running_campaign("tune", directory, cluster) as (campaign, progress):
        progress.begin("tune", grows=True)

        def attempt(walks: Sequence[Walk]) -> list[WalkEnd]:
            done = campaign.walk(walks)
            if len(done) < len(walks):
                raise studies.Stopped
            return [result.end for result in done]

        studies.improve(kept, dimensions, ensemble, attempt, trials, lambda: campaign.interrupted)
        if campaign.interrupted:
            console.print("Interrupted: the same command goes on.")
            return 130
        best = kept.best_params
        tuned.write_tuned(directory.path / "tuned.toml", ensemble, best)
        unseen = tuned.compare(others, best, attempt)
    data = {"name": "tune", "parameters": best} | _summary(kept, len(ensemble.walks({}))) | {"unseen": unseen}
    tuned.draw(kept, data["importance"], directory.path / "importance.png")
    directory.write_summary(data)
    _show(console, data, directory.path / "tuned.toml")
    return Answer(data)


def _summary(kept: Study, walks_of_a_trial: int) -> dict[str, Any]:
    """Results of the study; `walks_of_a_trial` is the number in a trial that is not pruned."""
    from nao_hil.campaigns import study as studies
    from nao_hil.campaigns import tuned

    trials = studies.count(kept)
    walks = sum(trial.user_attrs.get("walks", 0) for trial in kept.trials)
    return {
        "objective": kept.best_value,
        "trials": trials,
        "pruned": sum(trial.state.name == "PRUNED" for trial in kept.trials),
        "walks": walks,
        "share": walks / (trials * walks_of_a_trial),
        "importance": tuned.importances(kept),
    }


def _show(console: Console, data: dict[str, Any], parameters: Path) -> None:
    """Print the comparison on seeds outside of the study, the walks saved by pruning, and the file."""
    for which in ("shipped", "before", "after"):
        robots = data["unseen"][which]
        console.print(
            f"{which:7} {robots['survived']} of {robots['n']} walk on, mean score {robots['score']:.3f}"
        )
    console.print(f"{data['walks']} walks, {100 * data['share']:.0f} % of those without pruning.")
    console.print(f"parameters: {parameters}", soft_wrap=True)
