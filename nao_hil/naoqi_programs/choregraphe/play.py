"""Plays a Choregraphe project: run by `nao-hil run-choregraphe` where programs for NAOqi run.

Arguments: the `.xar` file, the file for the report, seconds without anything running after which it ends.
"""

from __future__ import annotations

import json
import os
import sys
import time
from importlib import import_module
from pathlib import Path

import qi

from nao_hil.naoqi_programs.choregraphe.player import Player
from nao_hil.naoqi_programs.choregraphe.project import read_behaviour


def play(file: Path, report: Path, idle: float) -> None:
    """Play one behaviour to its end, and write what was not done."""
    session = qi.Session()
    session.connect(os.environ["NAO_HIL_NAOQI"])
    vendor = import_module("naoqi")  # of `nao_hil.naoqi_programs.modules`, where the runner finds it
    modules = {name: getattr(vendor, name) for name in ("ALProxy", "ALBroker", "ALModule")}
    modules |= {"qi": qi, "time": time}
    player = Player(session.service, modules, session)
    player.play(read_behaviour(file))
    while not player.ended.wait(0.1) and player.idle < idle:
        pass
    if not player.ended.is_set():
        player.cannot(f"the end of the behaviour was not reached: nothing had run for {idle:g} s")
    player.ended.set()
    report.write_text(json.dumps(player.could_not))


if __name__ == "__main__":
    play(Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3]))
