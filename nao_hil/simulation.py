"""A walk in this process, from options to its summary."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bridge.body import load_body
from bridge.errors import ConfigurationError
from bridge.recording.recorder import Recorder
from nao_hil.arguments import file_path, require_names, whole_seed
from nao_hil.runs.build import check_run, with_engine
from nao_hil.runs.config import run_config
from nao_hil.runs.description import robot_scene
from nao_hil.runs.in_process import walk_in_process
from nao_hil.runs.summary import Summary


def walk(
    gait: str = "omni",
    *,
    body: str = "nao-v3",
    seed: int = 0,
    wear: str = "nominal",
    scenario: str = "flat",
    engine: str = "auto",
    steps: int | None = None,
    duration: float | None = None,
    torso: str | None = None,
    parameters: dict[str, Any] | None = None,
    record: str | Path | None = None,
) -> Summary:
    """Walk an emulated robot in this process, as fast as it computes.

    Example:
        summary = nao_hil.walk("dynamic", seed=3, steps=20, record="walk.mcap")
        print(summary.fell, summary.distance)

    Args:
        gait: A name of `nao-hil gaits`.
        body: Name of a body (`nao-hil robots`), or path of a data sheet.
        seed: Of everything random.
        wear: State of drives and sensors: `ideal`, `nominal`, `worn`, `ensemble:K`, or path of a profile.
        scenario: World: a name (`nao-hil scenarios`), or path of a scenario.
        engine: Physics, `pybullet` or `mujoco`; `auto`: PyBullet where it is installed, else MuJoCo.
        steps: Steps to walk, the closing one included; None: 10, or no bound with a duration.
        duration: Time to walk, s; None: no bound.
        torso: Torso control: `none`, `thesis` or `robust`; None: the gait's own.
        parameters: Parameters of the gait that differ from the shipped ones.
        record: File to record the run in (.mcap); None: no recording.

    Raises:
        ConfigurationError: a wrong option, a walk without a bound, or parameters that cannot be walked.
    """
    options: dict[str, Any] = {"steps": steps, "duration": duration, "torso": torso, "parameters": parameters}
    options |= {"wear": wear, "scenario": scenario, "engine": engine}
    require_names(gait=gait, body=body, wear=wear, scenario=scenario, engine=engine)
    file = None if record is None else file_path("record", record)
    settings = with_engine(run_config(None, robot=body, gait=gait, seed=whole_seed(seed), **options))
    if not settings.steps and not settings.duration:
        raise ConfigurationError("A walk in this process needs an end; give steps or duration.")
    if file is None:
        return walk_in_process(settings)
    check_run(settings)  # before a file that is there is written anew
    with Recorder(file, settings, robot_scene(load_body(settings.robot))) as recorder:
        return walk_in_process(settings, [recorder])
