"""A study: optuna searches the parameters with the best lower bound; resumable, shared through a database."""

from __future__ import annotations

import hashlib
import itertools
import re
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import msgspec
import optuna

from bridge.errors import ConfigurationError
from nao_hil.analysis.statistics import score_bounds
from nao_hil.campaigns.objective import Ensemble, judge
from nao_hil.runs.fingerprint import source_hash
from nao_hil.runs.walk import Walk, WalkEnd

HEARTBEAT_INTERVAL: Final = 30
"""s between signs of life of a trial; another process repeats one without them for twice as long."""
_ATTEMPTS: Final = 10
_DONE: Final = (optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED)


class Range(NamedTuple):
    """Range of a parameter."""

    low: float
    high: float
    log: bool = False


def open_study(storage: str, space: Mapping[str, Range], ensemble: Ensemble) -> optuna.Study:
    """The study of a space and an ensemble; made if it is not there.

    Args:
        storage: URL of a database as SQLAlchemy has it, such as `sqlite:///study.db`.
        space: Ranges by quantity.
        ensemble: Of walks.

    Raises:
        ConfigurationError: the database cannot be opened.
    """
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    what = repr((sorted(space.items()), ensemble, source_hash()))
    try:
        study = optuna.create_study(
            storage=_database(storage),
            study_name=f"tune-{hashlib.sha256(what.encode()).hexdigest()[:32]}",
            direction="maximize",
            load_if_exists=True,
        )
    except Exception as error:
        raise ConfigurationError(
            f"--study {storage}: no study can be read or made there ({type(error).__name__}: "
            f"{str(error).splitlines()[0]}); give a URL such as sqlite:///study.db."
        ) from None
    # Without a seed: processes that share a study would draw the same points.
    study.sampler = optuna.samplers.TPESampler(constant_liar=True)
    return study


def _database(url: str) -> optuna.storages.RDBStorage:
    """The database. Of processes that begin together all make its tables, and all but one may fail."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        for attempt in itertools.count():
            try:
                return optuna.storages.RDBStorage(
                    url,
                    heartbeat_interval=HEARTBEAT_INTERVAL,
                    grace_period=2 * HEARTBEAT_INTERVAL,
                    heartbeat_stale_trial_callback=_try_again,
                )
            except Exception as error:
                if attempt == _ATTEMPTS or not re.search("exists|duplicate|UNIQUE", str(error)):
                    raise
                time.sleep(0.3)


def enqueue(study: optuna.Study, point: Mapping[str, float]) -> None:
    """Have a point tried, unless it is a trial already."""
    study.enqueue_trial(dict(point), skip_if_exists=True)


def improve(
    study: optuna.Study,
    space: Mapping[str, Range],
    ensemble: Ensemble,
    attempt: Callable[[Sequence[Walk]], Sequence[WalkEnd]],
    trials: int,
    stopped: Callable[[], bool],
) -> None:
    """Try points until the study has so many, of whichever process.

    A trial ends early when it is hopeless: the upper bound of its mean score is below the best lower bound.

    Args:
        study: Of `open_study`.
        space: Ranges by quantity.
        ensemble: Of walks for each point.
        attempt: Walks some walks; raises `optuna.TrialPruned` when stopped.
        trials: Of the whole study, those before included.
        stopped: Whether to begin no further trial.
    """

    def objective(trial: optuna.Trial) -> float:
        """Score of one trial, to be maximized."""
        point = {name: trial.suggest_float(name, r.low, r.high, log=r.log) for name, r in space.items()}
        best = max((t.value for t in study.trials if t.value is not None), default=0.0)

        def go_on(n: int, total: float, bounds: tuple[float, float]) -> bool:
            trial.report(total / n, n)
            return bounds[1] >= best

        try:
            walks = ensemble.walks(point)
            n, total = judge(walks, attempt, go_on)
        except ConfigurationError as error:  # cannot be walked
            trial.set_user_attr("refused", str(error))
            raise optuna.TrialPruned from None
        trial.set_user_attr("walks", n)
        if n < len(walks):
            raise optuna.TrialPruned
        return score_bounds(total, n)[0]

    def end(study: optuna.Study, trial: optuna.trial.FrozenTrial) -> None:
        if trial.state == optuna.trial.TrialState.FAIL:  # stopped in its middle
            _try_again(study, trial)
        if stopped() or count(study) >= trials:
            study.stop()

    while count(study) < trials and not stopped():
        try:
            study.optimize(objective, callbacks=[end], catch=(Stopped,))
        except ValueError as error:
            # This process slept for longer than the heartbeat allows: another one has its trial.
            if str(error) != "Cannot tell a FAIL trial.":
                raise


def _try_again(study: optuna.Study, trial: optuna.trial.FrozenTrial) -> None:
    """Queue the point of a failed trial again, for any process."""
    study.add_trial(
        optuna.create_trial(
            state=optuna.trial.TrialState.WAITING,
            params=trial.params,
            distributions=trial.distributions,
            system_attrs=trial.system_attrs,
        )
    )


class Stopped(Exception):
    """The command is stopped in the middle of a trial, which will be repeated."""


def count(study: optuna.Study) -> int:
    """Trials that are done."""
    return len(study.get_trials(deepcopy=False, states=_DONE))


def table(point: Mapping[str, float]) -> dict[str, Any]:
    """Parameters by dotted name as the tables of a configuration file."""
    nested: dict[str, Any] = {}
    for name, value in point.items():
        *tables, last = name.split(".")
        at = nested
        for part in tables:
            at = at.setdefault(part, {})
        at[last] = value
    return nested


def shipped(space: Mapping[str, Range], ensemble: Ensemble) -> dict[str, float] | None:
    """The values of the base configuration; None: one of them is outside its range or no number."""
    from walker.gaits import gait_parameters
    from walker.parameters import controller_parameters

    base = ensemble.base
    values = {
        "parameters": msgspec.to_builtins(gait_parameters(base.gait, base.parameters)),
        "controller": msgspec.to_builtins(controller_parameters(base.gait, base.controller)),
    }
    point = {}
    for name, allowed in space.items():
        at: Any = values
        for part in name.split("."):
            at = at.get(part) if isinstance(at, dict) else None
        if not isinstance(at, float | int) or not allowed.low <= at <= allowed.high:
            return None
        point[name] = float(at)
    return point
