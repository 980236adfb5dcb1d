"""Results of a study: the parameters as TOML, their importance, and before and after on unseen seeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
import optuna

from nao_hil.analysis.statistics import few_words, paired, score_bounds, wilson
from nao_hil.campaigns.objective import Ensemble, score
from nao_hil.campaigns.study import table
from nao_hil.files import atomic_path, write_bytes
from nao_hil.runs.walk import Walk, WalkEnd

UNSEEN: Final = 1_000_000
"""Added to the first seed for the comparison: no study sees those seeds."""


def write_tuned(path: Path, ensemble: Ensemble, point: dict[str, float]) -> None:
    """A configuration file with the best parameters; `--config` takes it."""
    base = msgspec.to_builtins(ensemble.base)
    data: dict[str, Any] = {"gait": base["gait"]}
    for name, tables in (("parameters", base["parameters"]), ("controller", base["controller"])):
        data[name] = _merged(tables, table(point).get(name, {}))
    write_bytes(path, msgspec.toml.encode({key: value for key, value in data.items() if value}))


def _merged(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    both = dict(base)
    for name, value in changes.items():
        at = both.get(name)
        both[name] = _merged(at, value) if isinstance(at, dict) and isinstance(value, dict) else value
    return both


def compare(
    ensemble: Ensemble, point: dict[str, float], attempt: Callable[[Sequence[Walk]], Sequence[WalkEnd]]
) -> dict[str, Any]:
    """Shipped parameters of the gait, those before, those after, on the same seeds that the study never saw."""
    first = ensemble.first_seed + UNSEEN
    bare = msgspec.structs.replace(ensemble.base, parameters={}, controller={})
    shipped = attempt(msgspec.structs.replace(ensemble, base=bare).walks({}, first))
    before = list(attempt(ensemble.walks({}, first)))
    after = list(attempt(ensemble.walks(point, first)))
    pair = paired([end.survived for end in after], [end.survived for end in before])
    return {
        "seeds": f"{first} to {first + ensemble.seeds - 1}{few_words(ensemble.seeds)}",
        "shipped": _arm(shipped, ensemble.duration),
        "before": _arm(before, ensemble.duration),
        "after": _arm(after, ensemble.duration),
        "p_value": pair.p_value,
    }


def _arm(ends: Sequence[WalkEnd], duration: float) -> dict[str, Any]:
    survived, scores = sum(end.survived for end in ends), [score(end, duration) for end in ends]
    return {
        "n": len(ends),
        "survived": survived,
        "interval": wilson(survived, len(ends)),
        "score": float(np.mean(scores)),
        "score_interval": score_bounds(sum(scores), len(scores)),
    }


def importances(study: optuna.Study) -> dict[str, float]:
    """Importance of each parameter for good trials (PED-ANOVA); empty for few trials."""
    done = study.get_trials(deepcopy=False, states=(optuna.trial.TrialState.COMPLETE,))
    if len(done) < 4 or len({trial.value for trial in done}) < 2:
        return {}
    evaluator = optuna.importance.PedAnovaImportanceEvaluator()
    return {k: float(v) for k, v in optuna.importance.get_param_importances(study, evaluator=evaluator).items()}


def draw(study: optuna.Study, shares: dict[str, float], path: Path) -> Path:
    """Objective by trial with the best so far, and the importance of the parameters."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 4.0), layout="constrained")
    history, bars = figure.subplots(1, 2)
    done = study.get_trials(deepcopy=False, states=(optuna.trial.TrialState.COMPLETE,))
    numbers, values = [t.number for t in done], [t.value or 0.0 for t in done]
    history.plot(numbers, values, ".", label="trial")
    history.step(numbers, np.maximum.accumulate(values), where="post", label="best")
    history.set(xlabel="trial", ylabel="lower bound of the mean score")
    history.legend()
    bars.barh(list(shares), list(shares.values()))
    bars.set(xlabel="importance")
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)
    return path
