"""Studies: a known best point is found, hopeless trials end early, a killed process loses and doubles none."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec
import optuna
import pytest
from sqlalchemy.exc import OperationalError

from bridge.config import read_toml
from bridge.errors import ConfigurationError
from nao_hil.campaigns.objective import BATCH_SIZE, Ensemble, judge, score
from nao_hil.campaigns.results import ask
from nao_hil.campaigns.study import Range, Stopped, count, enqueue, improve, open_study
from nao_hil.campaigns.tuned import compare, importances, read_space, write_tuned
from nao_hil.cli.main import run
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Ending, Walk, WalkEnd
from tests.loops import TIMEOUT, until
from tests.made_walks import walk_end
from tests.nao_hil.campaign.damping_study import ENSEMBLE, SPACE, attempt
from tests.ports import free_port

DONE = (optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED)
pytestmark = pytest.mark.usefixtures("connections_left_open")


def test_a_study_finds_the_best_point_and_ends_hopeless_trials_early(tmp_path: Path) -> None:
    study = open_study(f"sqlite:///{tmp_path / 'study.db'}", SPACE, ENSEMBLE)
    study.sampler = optuna.samplers.TPESampler(seed=1)
    enqueue(study, {"controller.damping.roll": 0.2, "controller.damping.pitch": 0.1})  # detuned
    improve(study, SPACE, ENSEMBLE, attempt, 24, lambda: False)
    assert count(study) == 24
    assert study.trials[0].params["controller.damping.roll"] == 0.2
    assert abs(study.best_params["controller.damping.roll"] - 0.05) < 0.02
    pruned = [trial for trial in study.trials if trial.state.name == "PRUNED"]
    assert pruned
    assert min(trial.user_attrs["walks"] for trial in pruned) == BATCH_SIZE
    shares = importances(study)
    assert shares["controller.damping.roll"] > shares["controller.damping.pitch"]
    # resumed: no trial more than asked for
    again = open_study(f"sqlite:///{tmp_path / 'study.db'}", SPACE, ENSEMBLE)
    improve(again, SPACE, ENSEMBLE, attempt, 26, lambda: False)
    assert count(again) == 26
    detuned = msgspec.structs.replace(ENSEMBLE.base, controller={"damping": {"roll": 0.15}})
    unseen = compare(msgspec.structs.replace(ENSEMBLE, base=detuned), study.best_params, attempt)
    assert unseen["before"]["survived"] == 0 and unseen["after"]["survived"] == 20
    # a roll damping that is not named counts as 0.2 in `ended`: it falls earlier than with 0.15
    assert unseen["shipped"]["score"] < unseen["before"]["score"] < unseen["after"]["score"]
    write_tuned(tmp_path / "tuned.toml", ENSEMBLE, study.best_params)
    tuned = read_toml(tmp_path / "tuned.toml")
    assert tuned["gait"] == "dynamic"
    assert abs(tuned["controller"]["damping"]["roll"] - 0.05) < 0.02


def test_a_trial_that_was_stopped_is_tried_again(tmp_path: Path) -> None:
    study = open_study(f"sqlite:///{tmp_path / 'study.db'}", SPACE, ENSEMBLE)
    first = {"controller.damping.roll": 0.05, "controller.damping.pitch": 0.1}
    enqueue(study, first)
    stop: list[bool] = []

    def stopped(walks: Sequence[Walk]) -> list[WalkEnd]:
        stop.append(True)
        raise Stopped

    improve(study, SPACE, ENSEMBLE, stopped, 2, lambda: bool(stop))
    assert count(study) == 0
    enqueue(study, first)  # the same command again
    improve(study, SPACE, ENSEMBLE, attempt, 1, lambda: False)
    assert [trial.params for trial in study.trials if trial.state in DONE] == [first]


def test_a_process_that_slept_too_long_leaves_its_trial_to_the_others_and_goes_on(tmp_path: Path) -> None:
    study = open_study(f"sqlite:///{tmp_path / 'study.db'}", SPACE, ENSEMBLE)
    slept: list[int] = []

    def sleepy(walks: Sequence[Walk]) -> list[WalkEnd]:
        if not slept:
            slept.append(study.trials[-1].number)
            study.tell(slept[0], state=optuna.trial.TrialState.FAIL)  # as another process does
        return attempt(walks)

    improve(study, SPACE, ENSEMBLE, sleepy, 3, lambda: False)
    assert count(study) == 3 and len(study.trials) == 4


def test_a_score_is_larger_the_longer_and_the_more_upright() -> None:
    def at(time: float, tilt: float, ending: Ending) -> float:
        return score(walk_end(ending, time, tilt_max=tilt), 10.0)

    scores = [at(0.0, 1.0, "fell"), at(9.0, 0.1, "fell"), at(10.0, 0.6, "walked"), at(10.0, 0.0, "walked")]
    assert scores == sorted(scores)
    assert scores[0] == 0.0 and scores[2] == 0.5 and scores[3] == 1.0


def test_an_ensemble_is_every_robot_in_every_world_with_every_seed() -> None:
    many = Ensemble(
        base=RunConfig(gait="dynamic"), robots=("nao-v3", "nao-v4"), wears=("nominal", "worn"),
        scenarios=("flat",), first_seed=3, seeds=5, duration=1.0,
    )  # fmt: skip
    walks = many.walks({"controller.damping.roll": 0.1})
    assert len({(w.config.robot, w.config.wear, w.config.seed) for w in walks}) == len(walks) == 20
    assert judge(walks, attempt, lambda n, total, bounds: n < 8)[0] == 8


def test_ranges_come_from_the_command_line_and_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "space.toml"
    file.write_text('"a.b" = [0, 1]\n[c]\nd = [0.1, 10, "log"]\n')
    assert read_space(["a.b=2:3", "e=1:2:log"], file) == {
        "a.b": Range(2.0, 3.0),
        "c.d": Range(0.1, 10.0, True),
        "e": Range(1.0, 2.0, True),
    }
    for wrong in ("a", "a=1", "a=2:1", "a=0:1:log", "a=x:y", "a=1:nan"):
        with pytest.raises(ConfigurationError, match="must be NAME=LOW:HIGH"):
            read_space([wrong], None)
    with pytest.raises(ConfigurationError, match="name at least one parameter"):
        read_space([], None)


def test_processes_that_begin_together_make_one_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each looks whether a table is there, then makes it; the error is what one of two processes saw."""
    made = []

    class Late(optuna.storages.RDBStorage):
        def __init__(self, *arguments: Any, **more: Any) -> None:
            super().__init__(*arguments, **more)
            made.append(self)
            if len(made) == 1:
                raise OperationalError("CREATE TABLE", None, Exception("table study_directions already exists"))

    monkeypatch.setattr(optuna.storages, "RDBStorage", Late)
    open_study(f"sqlite:///{tmp_path / 'study.db'}", SPACE, ENSEMBLE)
    assert len(made) == 2


def test_the_command_walks_and_writes_what_it_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = tmp_path / "run.toml"
    config.write_text('engine = "mujoco"\ngait = "dynamic"\n')
    what = ["controller.damping.roll=0:0.2", "--config", str(config), "--trials", "2", "--seeds", "1"]
    what += ["--wear", "nominal", "--unseen-wear", "worn", "--unseen-wear", "ideal"]
    where = ["--duration", "0.2", "--cluster", "inline", "--out", str(tmp_path), "--json"]
    assert run(["tune", *what, *where]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["trials"] == 2 and data["unseen"]["after"]["n"] == 2
    assert data["walks"] == 2 and data["share"] == 1.0
    rows = ask("SELECT DISTINCT wear FROM walks WHERE seed = 1000000 ORDER BY wear", tmp_path).rows
    assert rows == [("ideal",), ("worn",)]
    assert data["unseen"]["seeds"] == "1000000 to 1000000 (only 1 of 20 seeds)"
    assert (tmp_path / "tuned.toml").exists() and (tmp_path / "importance.png").stat().st_size > 5000


WORKER = """
import sys, time, warnings
warnings.simplefilter("ignore")
from nao_hil.campaigns.study import improve, open_study
from tests.nao_hil.campaign.damping_study import ENSEMBLE, SPACE, attempt
def slowly(walks):
    time.sleep(0.05)
    return attempt(walks)
improve(open_study(sys.argv[1], SPACE, ENSEMBLE), SPACE, ENSEMBLE, slowly, 1000, lambda: False)
"""
BINARIES = sorted(Path("/usr/lib/postgresql").glob("*/bin"))


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path / 'study.db'}"
        return
    if not BINARIES or (os.geteuid() == 0 and shutil.which("runuser") is None):
        pytest.skip("needs PostgreSQL (Debian's package postgresql)")
    port = free_port()
    folder = Path("/tmp") / f"nao-hil-postgres-{os.getpid()}-{port}"
    folder.mkdir()
    if os.geteuid() == 0:
        shutil.chown(folder, "postgres")
    prefix = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []

    def control(*arguments: str) -> None:
        subprocess.run([*prefix, *arguments], check=True, cwd="/", stdout=subprocess.DEVNULL, timeout=TIMEOUT)

    data, bin_ = str(folder / "data"), BINARIES[-1]
    control(str(bin_ / "initdb"), "-D", data, "-U", "study", "-A", "trust", "--no-sync")
    options = f"-p {port} -h 127.0.0.1 -k {folder}"
    control(str(bin_ / "pg_ctl"), "-D", data, "-o", options, "-l", str(folder / "log"), "-w", "start")
    try:
        yield f"postgresql+psycopg://study@127.0.0.1:{port}/postgres"
    finally:
        control(str(bin_ / "pg_ctl"), "-D", data, "-m", "immediate", "stop")
        shutil.rmtree(folder)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # optuna leaves connections open
def test_processes_share_a_study_and_one_that_is_killed_loses_and_doubles_no_trial(database: str) -> None:
    """This process and another one, which is killed in a trial while this one is in its own."""
    study = open_study(database, SPACE, ENSEMBLE)

    def under_way() -> int:
        return len(study.get_trials(deepcopy=False, states=(optuna.trial.TrialState.RUNNING,)))

    with subprocess.Popen([sys.executable, "-c", WORKER, database], cwd=Path(__file__).parents[3]) as other:

        def beside(walks: Sequence[Walk]) -> list[WalkEnd]:
            if other.returncode is None and count(study) >= 4:
                until(lambda: under_way() == 2, "a trial of the other process")
                other.kill()
                other.wait()
            return attempt(walks)

        until(under_way, "the first trial", pause=0.1)
        improve(study, SPACE, ENSEMBLE, beside, 12, lambda: False)
    assert other.returncode == -signal.SIGKILL
    trials = open_study(database, SPACE, ENSEMBLE).trials
    assert [trial.number for trial in trials] == list(range(len(trials)))
    # on a busy machine this process outlives the heartbeats: a killed trial has failed, another has its point
    points = [tuple(trial.params.values()) for trial in trials if trial.state in DONE]
    assert len(points) == len(set(points)) >= 12
    left = [trial for trial in trials if trial.state == optuna.trial.TrialState.RUNNING]
    assert len(left) <= 1  # of the killed one, at most; done again once its heartbeat is stale
