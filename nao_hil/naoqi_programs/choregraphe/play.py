"""Plays a Choregraphe project: run by `nao-hil run-choregraphe` where programs for NAOqi run.

Arguments: the `.xar` file, the file for the report, seconds without anything running after which it ends.
"""

from __future__ import annotations

import json
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import qi

from nao_hil.naoqi_programs.choregraphe.manager import BehaviorManager, project_of
from nao_hil.naoqi_programs.choregraphe.player import Player
from nao_hil.naoqi_programs.choregraphe.project import read_behaviour
from nao_hil.naoqi_programs.choregraphe.scripts import FrameManager, OwnSession, script_globals
from nao_hil.naoqi_programs.runner import load_modules


def play(file: Path, report: Path, idle: float) -> None:
    """Play one behaviour to its end, and list omitted steps."""
    session = qi.Session()
    session.connect(os.environ["NAO_HIL_NAOQI"])
    folder, project = file.resolve().parent, project_of(file)
    sys.path[0:0] = [str(folder), str(folder.parent)]
    load_modules(old=True)
    own: dict[str, Any] = {"ALFrameManager": FrameManager()}
    names = script_globals(own)
    scripts_session = OwnSession(session, own)
    player = Player(session.service, names, scripts_session, folder, import_module("naoqi").register)
    run_later = qi.runAsync
    qi.runAsync = lambda *arguments, **options: player.hold(run_later(*arguments, **options))
    own["ALBehaviorManager"] = BehaviorManager(player, project, idle)
    player.play_to_end(read_behaviour(file), idle)
    report.write_text(json.dumps(player.could_not))


if __name__ == "__main__":
    play(Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3]))
