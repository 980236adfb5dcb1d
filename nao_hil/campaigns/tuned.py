"""Parameters of a study with their ranges, and its results: values as TOML, importance, before and after."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
import optuna

from bridge.config import read_toml
from bridge.errors import ConfigurationError
from nao_hil.analysis.statistics import few_words, paired, score_bounds, wilson
from nao_hil.campaigns.objective import Ensemble, score
from nao_hil.campaigns.study import Range, table
from nao_hil.files import save_figure, write_bytes
from nao_hil.runs.walk import Walk, WalkEnd
from walker.parameters import merged


def read_space(texts: Sequence[str], file: Path | None) -> dict[str, Range]:
    """Ranges by name.

    Args:
        texts: `NAME=LOW:HIGH`, or `NAME=LOW:HIGH:log` for a logarithmic one.
        file: TOML: `NAME = [LOW, HIGH]` or `[LOW, HIGH, "log"]`, in tables or with quoted dotted names.

    Raises:
        ConfigurationError: not of these forms, or no parameter at all.
    """
    space = dict(_flat(read_toml(file), str(file))) if file else {}
    for text in texts:
        name, equals, values = text.partition("=")
        if not equals or not name:
            raise _wrong(text)
        space[name] = _range(text, values.split(":"))
    if not space:
        raise ConfigurationError("tune: name at least one parameter, such as controller.damping.roll=0:0.15.")
    return space


def _flat(table: dict[str, Any], where: str, prefix: str = "") -> list[tuple[str, Range]]:
    ranges = []
    for key, value in table.items():
        if isinstance(value, dict) and value:
            ranges += _flat(value, where, f"{prefix}{key}.")
        elif isinstance(value, list):
            ranges.append((prefix + key, _range(f"{where}: {prefix}{key}", value)))
        else:
            raise _wrong(f"{where}: {prefix}{key}")
    return ranges


def _range(where: str, values: Sequence[Any]) -> Range:
    log = len(values) == 3 and values[2] == "log"
    try:
        low, high = map(float, values[:2] if log else values)
    except (TypeError, ValueError):
        raise _wrong(where) from None
    if not (math.isfinite(low) and math.isfinite(high) and low < high) or (log and low <= 0.0):
        raise _wrong(where)
    return Range(low, high, log)


def _wrong(where: str) -> ConfigurationError:
    return ConfigurationError(
        f"{where}: must be NAME=LOW:HIGH with LOW < HIGH, or NAME=LOW:HIGH:log with 0 < LOW < HIGH."
    )


UNSEEN_SEED_OFFSET: Final = 1_000_000
"""Added to the first seed for the comparison: no study sees those seeds."""


def write_tuned(path: Path, ensemble: Ensemble, point: dict[str, float]) -> None:
    """A configuration file with the best parameters; `--config` takes it."""
    base = msgspec.to_builtins(ensemble.base)
    data: dict[str, Any] = {"gait": base["gait"]}
    for name, tables in (("parameters", base["parameters"]), ("controller", base["controller"])):
        data[name] = merged(tables, table(point).get(name, {}))
    write_bytes(path, msgspec.toml.encode({key: value for key, value in data.items() if value}))


def compare(
    ensemble: Ensemble, point: dict[str, float], attempt: Callable[[Sequence[Walk]], Sequence[WalkEnd]]
) -> dict[str, Any]:
    """Shipped parameters of the gait, those before, those after, on the same seeds that the study never saw."""
    first = ensemble.first_seed + UNSEEN_SEED_OFFSET
    bare = msgspec.structs.replace(ensemble.base, parameters={}, controller={})
    shipped = attempt(msgspec.structs.replace(ensemble, base=bare).walks({}, first))
    before = list(attempt(ensemble.walks({}, first)))
    after = list(attempt(ensemble.walks(point, first)))
    pair = paired([end.survived for end in after], [end.survived for end in before])
    return {
        "seeds": f"{first} to {first + ensemble.seeds - 1}{few_words(ensemble.seeds)}",
        "shipped": _condition(shipped, ensemble.duration),
        "before": _condition(before, ensemble.duration),
        "after": _condition(after, ensemble.duration),
        "p_value": pair.p_value,
    }


def _condition(ends: Sequence[WalkEnd], duration: float) -> dict[str, Any]:
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
    return save_figure(figure, path)
