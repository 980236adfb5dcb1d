"""Other times and heights with more margin: a study that can be continued.

The search is over T_d, T_m, H_min, H_max and H_ao; each trial finds x_sd, x_ed, y_d and y_m by itself.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Final

import msgspec

from bridge.body import Body
from bridge.errors import ConfigurationError
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.search import search
from walker.gaits.catalogue import check_walkable
from walker.gaits.huang import HuangGait, HuangParameters
from walker.gaits.pose import ARMS

COARSE_GRID: Final = 12
"""Points of a trial's grid along each dimension; the refinement is between them."""


def improve(
    p: HuangParameters, body: Body, trials: int, file: Path | None, progress: Callable[[str], None]
) -> HuangParameters:
    """The parameters with the largest margin of a study, which includes those given.

    Args:
        p: parameters to begin with; the numbers that they name keep their values.
        body: data sheet.
        trials: number to add; 0: only the best of the file.
        file: SQLite file of the study; None: it is not kept.
        progress: called after each trial.

    Raises:
        ConfigurationError: optuna is not installed, or the file is no study of this configuration.
    """
    try:
        import optuna
    except ImportError:
        raise ConfigurationError("--trials needs optuna; install nao-hil[design].") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    storage = None if file is None else f"sqlite:///{file.absolute()}"
    try:
        study = optuna.create_study(
            storage=storage,
            study_name=_name(p, body),
            direction="maximize",
            load_if_exists=True,
        )
    except Exception as error:
        raise ConfigurationError(
            f"{file}: no study can be read or created there ({type(error).__name__}); give a file that --study "
            "made, or a new one in a folder that can be written."
        ) from None
    if not study.trials:
        study.enqueue_trial(_vector(p))
    # A continued study must not draw the same parameters again.
    study.sampler = optuna.samplers.TPESampler(seed=len(study.trials))

    def objective(trial: optuna.Trial) -> float:
        """Margin of one trial; a gait that cannot be walked is pruned."""
        tried = _tried(p, {name: trial.suggest_float(name, *_range(p, name)) for name in _vector(p)})
        try:
            plan = search(Cycle(tried, body, ARMS), COARSE_GRID)
            check_walkable(body, HuangGait(msgspec.structs.replace(tried, **plan.choice._asdict()), body))
        except ConfigurationError as error:
            trial.set_user_attr("refused", str(error))
            raise optuna.TrialPruned from None
        return plan.margin

    def tell(study: optuna.Study, trial: optuna.trial.FrozenTrial) -> None:
        done = [t for t in study.trials if t.value is not None]
        best = f", best margin {1e3 * max(t.value or 0.0 for t in done):.1f} mm" if done else ""
        progress(f"trial {trial.number + 1} of {before + trials}{best}")

    before = len(study.get_trials(states=(optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED)))
    study.optimize(objective, n_trials=trials, callbacks=[tell])
    if not any(trial.value is not None for trial in study.trials):
        raise ConfigurationError("gait huang: none of the trials can be walked; begin from other parameters.")
    return _tried(p, study.best_params)


def _name(p: HuangParameters, body: Body) -> str:
    """Name of the study of a configuration; ground and first foot make no difference to the cycle."""
    flat = msgspec.structs.replace(p, ground=type(p.ground)(), first_swing="R", progress=1.0)
    return f"huang-{hashlib.sha256(msgspec.json.encode((flat, body))).hexdigest()[:32]}"


def _vector(p: HuangParameters) -> dict[str, float]:
    """The parameters as the study's dimensions: fractions and differences, so that all orders hold."""
    return {
        "T_d_fraction": p.T_d / p.T_c,
        "T_m_fraction": (p.T_m - p.T_d) / (p.T_c - p.T_d),
        "H_min": p.H_min,
        "rise": p.H_max - p.H_min,
        "H_ao": p.H_ao,
    }


def _range(p: HuangParameters, name: str) -> tuple[float, float]:
    return {
        "T_d_fraction": (0.1, 0.5),
        "T_m_fraction": (0.3, 0.7),
        "H_min": (p.H_min - 0.02, p.H_min + 0.02),
        "rise": (0.0, 0.012),
        "H_ao": (p.H_ao - 0.01, p.H_ao + 0.02),
    }[name]


def _tried(p: HuangParameters, values: dict[str, float]) -> HuangParameters:
    lift = values["T_d_fraction"] * p.T_c
    return msgspec.structs.replace(
        p,
        T_d=lift,
        T_m=lift + values["T_m_fraction"] * (p.T_c - lift),
        H_min=values["H_min"],
        H_max=values["H_min"] + values["rise"],
        H_ao=values["H_ao"],
    )
