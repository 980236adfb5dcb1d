"""Plays a Choregraphe project: run by `nao-hil run-choregraphe` where programs for NAOqi run.

Arguments: the `.xar` file, the file for the report, seconds without anything running after which it ends.
"""

from __future__ import annotations

import json
import os
import sys
from importlib import import_module
from pathlib import Path

import qi

from nao_hil.naoqi_programs.choregraphe.player import Player
from nao_hil.naoqi_programs.choregraphe.project import read_behaviour
from nao_hil.naoqi_programs.choregraphe.scripts import script_globals
from nao_hil.naoqi_programs.runner import load_modules


def play(file: Path, report: Path, idle: float) -> None:
    """Play one behaviour to its end, and list omitted steps."""
    session = qi.Session()
    session.connect(os.environ["NAO_HIL_NAOQI"])
    folder = file.resolve().parent
    sys.path[0:0] = [str(folder), str(folder.parent)]
    load_modules(old=True)
    names = script_globals(folder)
    player = Player(session.service, names, session, folder, import_module("naoqi").register)
    run_later = qi.runAsync
    qi.runAsync = lambda *arguments, **options: player.hold(run_later(*arguments, **options))
    player.play(read_behaviour(file))
    while not player.ended.wait(0.1) and player.idle < idle:
        pass
    if not player.ended.is_set():
        for sentence in player.waiting():
            player.cannot(f"{sentence}, which did not come within {idle:g} s")
    player.close()
    report.write_text(json.dumps(player.could_not))


if __name__ == "__main__":
    play(Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3]))
