"""Behaviours of Choregraphe: events, stops, timelines and what scripts find, without a robot."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("qi")
pytest.importorskip("lib2to3", reason="Python 3.13 has no lib2to3")

from nao_hil.naoqi_programs.choregraphe.executables import ServiceManager
from nao_hil.naoqi_programs.choregraphe.play import BehaviorManager, home_of, project_of
from nao_hil.naoqi_programs.choregraphe.player import Player
from nao_hil.naoqi_programs.choregraphe.project import read_behaviour
from nao_hil.naoqi_programs.choregraphe.scripts import FrameManager
from tests.loops import TIMEOUT, until

INPUTS = (
    '<Input name="onLoad" nature="0" inner="1" id="1"/><Input name="onStart" nature="2" inner="0" id="2"/>'
    '<Input name="onStop" nature="3" inner="0" id="3"/>{more}'
    '<Output name="onStopped" nature="1" inner="0" id="4"/>'
)


def box(
    number: int, name: str, script: str = "", inside: str = "", more: str = "", parameters: str = ""
) -> str:
    """A box whose script is the body of its class; inputs 2 (start) and 3 (stop), output 4."""
    body = f"class MyClass(GeneratedClass):\n{script}" if script else ""
    return (
        f'<Box name="{name}" id="{number}"><script language="4"><content><![CDATA[{body}]]></content></script>'
        f"{INPUTS.format(more=more)}{parameters}{inside}</Box>"
    )


def diagram(boxes: str, *links: tuple[int, int, int, int]) -> str:
    """Boxes and links: from box, its output, to box, its input; 0 is the box around."""
    ends = "".join(
        f'<Link outputowner="{a}" indexofoutput="{b}" inputowner="{c}" indexofinput="{d}"/>'
        for a, b, c, d in links
    )
    return f"<Diagram>{boxes}{ends}</Diagram>"


def timeline(
    content: str, *, enable: int = 0, curves: str = "", frame: int = 1, limits: str = "", name: str = ""
) -> str:
    actuators = f"<ActuatorList>{curves}</ActuatorList>" if curves else ""
    keyframe = f'<BehaviorKeyframe name="{name}" index="{frame}">{content}</BehaviorKeyframe>'
    layer = f"<BehaviorLayer>{keyframe}</BehaviorLayer>"
    return f'<Timeline enable="{enable}" fps="25" {limits}>{actuators}{layer}</Timeline>'


def says(number: int, text: str) -> str:
    """A box that notes a text when it starts."""
    script = f"    def onInput_onStart(self): said.append({text!r}); self.onStopped()\n"
    return box(number, f"Say {text}", script)


class Robot:
    """Services that note their calls; events are raised by `tell`."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self.told: dict[str, list[Callable[[Any], None]]] = {}
        self.topics: dict[str, str] = {}
        self.free = threading.Event()

    def service(self, name: str) -> Any:
        return {"ALMotion": self, "ALMemory": self, "ALDialog": self, "ALTextToSpeech": self}[name]

    def getLanguage(self) -> str:
        return "English"

    def loadTopicContent(self, text: str) -> str:
        name = text.split("~")[1].split("(")[0]
        self.topics[name] = text.split("language: ")[1].strip()
        return name

    def getLoadedTopics(self, language: str) -> list[str]:
        assert language == "English"
        return [name for name, code in self.topics.items() if code == "enu"]

    def activateTopic(self, name: str) -> None:
        self.calls.append(("activate", name))

    def unloadTopic(self, name: str) -> None:
        self.calls.append(("unload", name, self.topics.pop(name)))

    def subscribe(self, name: str) -> None:
        self.calls.append(("subscribe", name))

    def unsubscribe(self, name: str) -> None:
        self.calls.append(("unsubscribe", name))

    def raiseEvent(self, event: str, value: Any) -> None:
        self.calls.append(("raise", event, value))

    def subscriber(self, event: str) -> Any:
        return SimpleNamespace(signal=SimpleNamespace(connect=self.told.setdefault(event, []).append))

    def tell(self, event: str, value: Any) -> None:
        for told in self.told.get(event, []):
            told(value)

    def getBodyNames(self, _: str) -> list[str]:
        return ["HeadYaw", "LHand"]

    def angleInterpolation(self, names: Any, angles: Any, times: Any, absolute: bool) -> None:
        self.calls.append(("move", names, angles, times, absolute))
        self.free.wait(max(row[-1] for row in times))

    def killTasksUsingResources(self, names: Any) -> None:
        self.calls.append(("kill", names))
        self.free.set()
        self.free = threading.Event()


def play(folder: Path, inside: str, more: str = "") -> tuple[Player, Robot, list[Any]]:
    """Play a root box; the player, the robot, and what scripts append to `said`."""
    file = folder / "behavior.xar"
    file.write_text(f"<ChoregrapheProject>{box(-1, 'root', '', inside, more)}</ChoregrapheProject>")
    robot, said = Robot(), list[Any]()
    names = {"said": said, "starts": list[int](), "go": threading.Event(), "sys": sys}
    names["ALFrameManager"] = FrameManager(1.0)
    player = Player(robot.service, names, robot, folder, lambda name, module: said.append((name, module)))
    player.play(read_behaviour(file))
    return player, robot, said


EVENT = '<Input name="touched" nature="4" stm_value_name="FrontTactilTouched" inner="{}" id="5"/>'


def test_an_event_of_almemory_stimulates_the_input_of_a_box_that_was_started(tmp_path: Path) -> None:
    head = box(
        1, "Head", "    def onInput_touched(self, v): said.append(v); self.onStopped()\n", "", EVENT.format(0)
    )
    later = box(2, "Later", "    def onInput_onStart(self): said.append('waits')\n")
    links = ((0, 2, 2, 2), (2, 4, 1, 2), (1, 4, 0, 4))
    player, robot, said = play(tmp_path, timeline(diagram(head + later, *links)))
    until(lambda: said == ["waits"] and "FrontTactilTouched" in robot.told)
    robot.tell("FrontTactilTouched", 1.0)  # before its start: as a box that is not active
    time.sleep(0.1)
    assert said == ["waits"]
    assert list(player.waiting()) == []


def test_an_event_ends_a_behaviour_and_a_box_that_waits_is_named(tmp_path: Path) -> None:
    script = "    def onInput_onStart(self): said.append('on')\n"
    script += "    def onInput_touched(self, v): self.onStopped(v)\n"
    head = box(1, "Head", script, "", EVENT.format(0))
    player, robot, said = play(tmp_path, timeline(diagram(head, (0, 2, 1, 2), (1, 4, 0, 4))))
    until(lambda: said == ["on"])
    assert list(player.waiting()) == ["the box Head waits for FrontTactilTouched"]
    robot.tell("FrontTactilTouched", 1.0)
    assert player.ended.wait(TIMEOUT) and list(player.waiting()) == []


def test_stop_ends_the_boxes_inside_and_unloads_their_scripts(tmp_path: Path) -> None:
    script = (
        "    def onInput_onStart(self): said.append('begins')\n    def onUnload(self): said.append('ends')\n"
    )
    inside = timeline(diagram(box(1, "Inner", script), (0, 2, 1, 2)))
    stop = "    def onInput_onStart(self):\n        while not said: pass\n        self.onStopped()\n"
    boxes = box(1, "Outer", "", inside) + box(2, "Stop", stop)
    links = ((0, 2, 1, 2), (0, 2, 2, 2), (2, 4, 1, 3), (1, 4, 0, 4))
    player, _, said = play(tmp_path, timeline(diagram(boxes, *links)))
    assert player.ended.wait(TIMEOUT) and said == ["begins", "ends"]


def test_a_script_makes_its_timeline_loop(tmp_path: Path) -> None:
    """25 frames a second: the curve ends at 2.4 s, and a box at frame 6 goes back to frame 1 twice."""
    keys = '<Key frame="5" value="90"/><Key frame="60" value="0"/>'
    curve = f'<ActuatorCurve actuator="HeadYaw">{keys}</ActuatorCurve>'
    again = (
        "    def onInput_onStart(self):\n        said.append(len(said))\n"
        "        if len(said) < 3: self.gotoAndPlayParent(1)\n"
    )
    first = "    def onInput_onStart(self): starts.append(1)\n"
    inside = timeline(diagram(box(1, "Again", again), (0, 1, 1, 2)), enable=1, curves=curve, frame=6)
    inside += timeline(diagram(box(1, "First", first), (0, 1, 1, 2)), enable=1)
    moves = box(1, "Dance", "", inside)
    player, robot, said = play(tmp_path, timeline(diagram(moves, (0, 2, 1, 2), (1, 4, 0, 4))))
    assert player.ended.wait(TIMEOUT) and said == [0, 1, 2], player.could_not
    assert player._names["starts"] == [1, 1, 1]
    sent = [call for call in robot.calls if call[0] == "move"]
    assert len(sent) == 3 and sent[0][1:] == (
        ["HeadYaw"],
        [[pytest.approx(1.5708, abs=1e-4), 0.0]],
        [[0.2, 2.4]],
        True,
    )
    assert sent[1][3] == [[pytest.approx(0.16), pytest.approx(2.36)]]


def test_a_timeline_plays_from_its_start_frame_to_its_end_frame(tmp_path: Path) -> None:
    """25 frames a second: frames 26 to 51 last 1 s. The curve is cut at 51, 1 / 200 of the way from 0 to 90."""
    keys = "".join(f'<Key frame="{f}" value="{v}"/>' for f, v in ((25, -60), (50, 0), (250, 90)))
    curve = f'<ActuatorCurve actuator="HeadYaw">{keys}</ActuatorCurve>'
    limits = 'start_frame="26" end_frame="51"'
    inside = timeline(diagram(says(1, "before"), (0, 1, 1, 2)), enable=1, curves=curve, limits=limits)
    for frame in (40, 60):
        inside += timeline(diagram(says(1, str(frame)), (0, 1, 1, 2)), enable=1, frame=frame)
    moves = box(1, "Dance", "", inside)
    player, robot, said = play(tmp_path, timeline(diagram(moves, (0, 2, 1, 2), (1, 4, 0, 4))))
    assert player.ended.wait(TIMEOUT)
    until(lambda: sorted(said) == ["40", "before"], "both boxes, whose threads may run late")
    (sent,) = robot.calls
    assert sent[2] == [[0.0, pytest.approx(math.radians(90.0 / 200.0))]]
    assert sent[3] == [[pytest.approx(0.96), pytest.approx(1.0)]]


def test_a_script_pauses_the_timeline_around_it_and_goes_to_a_frame_by_its_name(tmp_path: Path) -> None:
    """As the boxes Stop and Goto (name) of Choregraphe 2; a paused timeline loads the diagram there."""
    script = (
        "    def onInput_onStart(self):\n        said.append('waits')\n"
        "        self.getParentTimeline().pause()\n"
        "        go.wait()\n        self.getParentTimeline().goTo('story')\n"
    )
    nested = box(1, "Group", "", timeline(diagram(box(1, "Goto", script), (0, 2, 1, 2))))
    inside = timeline(diagram(nested, (0, 1, 1, 2)), enable=1)
    inside += timeline(diagram(says(1, "story"), (0, 1, 1, 2), (1, 4, 0, 4)), enable=1, frame=26, name="story")
    moves = box(1, "Play", "", inside)
    player, _, said = play(tmp_path, timeline(diagram(moves, (0, 2, 1, 2), (1, 4, 0, 4))))
    until(lambda: said == ["waits"])
    time.sleep(1.5)  # frame 26 would be at 1 s
    assert said == ["waits"]
    player._names["go"].set()
    assert player.ended.wait(TIMEOUT) and said == ["waits", "story"] and player.could_not == []


@pytest.mark.parametrize("codes", ["frf enu", "enu frf"])
def test_the_topic_of_a_dialogue_answers_until_it_sets_on_stopped(tmp_path: Path, codes: str) -> None:
    """Its file of topics is beside the behaviour; those of all languages may have one name."""
    (tmp_path / "Talk").mkdir()
    listed = "".join(f"  {code}:Talk_{code}.top\n" for code in codes.split())
    (tmp_path / "Talk" / "Talk.dlg").write_text(f"multilanguage:Talk\n{listed}")
    for code in codes.split():
        (tmp_path / "Talk" / f"Talk_{code}.top").write_text(f"topic: ~Talk()\nlanguage: {code}\n")
    outputs = '<dialogFile>../Talk/Talk.dlg</dialogFile><Output name="game" nature="2" id="6"/>'
    boxes = box(1, "Talk", inside=outputs) + says(2, "game")
    folder = tmp_path / "behavior_1"
    folder.mkdir()
    player, robot, said = play(folder, timeline(diagram(boxes, (0, 2, 1, 2), (1, 6, 2, 2), (1, 4, 0, 4))))
    until(lambda: ("raise", "onStart", 1) in robot.calls)
    assert [call for call in robot.calls if call[0] == "activate"] == [("activate", "Talk")]
    assert [sentence.split(" waits")[0] for sentence in player.waiting()] == ["the box Talk"]
    robot.tell("game", 1)
    until(lambda: said == ["game"])
    robot.tell("onStopped", 1)
    assert player.ended.wait(TIMEOUT) and player.could_not == []
    assert robot.calls[-1] == ("unload", "Talk", "enu")


def test_a_script_finds_its_resources_and_its_module_is_registered(tmp_path: Path) -> None:
    script = (
        "    def __init__(self): GeneratedClass.__init__(self, False)\n"
        "    def onLoad(self): self.BIND_PYTHON(self.getName(), 'heard', 3)\n"
        "    def heard(self, key, value, message): pass\n"
        "    def onInput_onStart(self):\n"
        "        said.append(ALFrameManager.getBehaviorPath(self.behaviorId) + self.getParameter('File'))\n"
        "        said.append(self.getParameter('Own') / 2)\n        self.onStopped()\n"
    )
    inherited = (
        '<Parameter name="File" inherits_from_parent="1" content_type="3" value=""/>'
        '<Parameter name="Own" inherits_from_parent="0" content_type="1" value="7"/>'
    )
    own = '<Parameter name="File" inherits_from_parent="0" content_type="3" value="song.wav"/>'
    inside = timeline(diagram(box(1, "Play Sound", script, parameters=inherited), (0, 2, 1, 2), (1, 4, 0, 4)))
    outer = box(1, "Outer", "", inside, parameters=own)
    player, _, said = play(tmp_path, timeline(diagram(outer, (0, 2, 1, 2), (1, 4, 0, 4))))
    assert player.ended.wait(TIMEOUT), player.could_not
    (name, module), path, half = said
    assert name.startswith("Play_Sound__") and module.getName() == name
    assert (path, half) == (f"{tmp_path.resolve()}/song.wav", 3)


def test_a_service_of_the_manifest_runs_until_it_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the box Run App Executable starts it; the run lasts as long as the service."""
    (tmp_path / "scripts").mkdir()
    (tmp_path / "scripts" / "main.py").write_text("print 'started'\n")
    service = '<service name="main" execStart="/usr/bin/python2 scripts/main.py --quiet" autorun="false"/>'
    (tmp_path / "manifest.xml").write_text(f"<package><services>{service}</services></package>")
    runs = "import os, sys, time; open('ran', 'w').write(' '.join(sys.argv[1:]))"
    waits = "[time.sleep(0.01) for _ in iter(lambda: os.path.exists('end'), True)]"
    command = [sys.executable, "-c", f"{runs}; {waits}"]
    popen = subprocess.Popen
    monkeypatch.setattr(subprocess, "Popen", lambda given, **how: popen([*command, *given[3:]], **how))
    names = {"ALFrameManager": FrameManager(1.0)}
    player = Player(Robot().service, names, None, tmp_path, min)
    manager = ServiceManager(player, tmp_path)
    stopped: list[str] = []
    manager.serviceStopped.connect(lambda name, _: stopped.append(name))
    assert manager.startService("my_package.main") is True and player.idle == 0.0
    (tmp_path / "end").touch()
    until(lambda: stopped == ["my_package.main"])
    assert (tmp_path / "ran").read_text() == f"{tmp_path / 'scripts' / 'main.py'} --quiet"
    assert not manager.isServiceRunning("my_package.main") and player.could_not == []
    assert manager.startService("other") is False and len(player.could_not) == 1


def party(folder: Path) -> tuple[BehaviorManager, Player, list[Any]]:
    """A project of two behaviours, its player, and the words that they say."""
    for name, value in (("main", "first"), ("songs/birthday", "sung")):
        (folder / name).mkdir(parents=True)
        says = f"    def onInput_onStart(self): said.append({value!r}); self.onStopped()\n"
        root = box(-1, "root", "", timeline(diagram(box(1, "Say", says), (0, 2, 1, 2), (1, 4, 0, 4))))
        (folder / name / "behavior.xar").write_text(f"<ChoregrapheProject>{root}</ChoregrapheProject>")
    described = "".join(f'<BehaviorDescription src="{name}"/>' for name in ("main", "songs/birthday"))
    (folder / "party.pml").write_text(f"<Package>{described}</Package>")
    file = folder / "main" / "behavior.xar"
    said: list[Any] = []
    player = Player(
        Robot().service, {"said": said, "ALFrameManager": FrameManager(1.0)}, None, file.parent, min
    )
    return BehaviorManager(player, project_of(file), 5.0), player, said


def test_a_behaviour_runs_another_of_its_project(tmp_path: Path) -> None:
    manager, player, said = party(tmp_path)
    assert manager.getInstalledBehaviors() == ["main", "songs/birthday"]
    manager.runBehavior("songs/birthday")
    manager.runBehavior("party/songs/birthday")
    assert said == ["sung", "sung"] and not player.ended.is_set()
    manager.post.runBehavior("main/.")
    until(lambda: said[2:] == ["first"], "the behaviour that was not waited for")


def test_a_text_starts_a_behaviour_of_the_project(tmp_path: Path) -> None:
    manager, player, said = party(tmp_path)
    manager.run_for_text("party/songs/birthday")
    assert said == ["sung"] and player.could_not == []
    manager.run_for_text("party/songs/wedding")
    assert said == ["sung"] and len(player.could_not) == 1


def test_the_home_of_scripts_is_the_robot_s(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another server's may be on another machine, or it does not tell."""
    monkeypatch.setattr(f"{home_of.__module__}.ROBOT_HOME", tmp_path / "nao")

    def session(home: str) -> Any:
        def service(_: str) -> Any:
            if not home:
                raise RuntimeError("no such service")
            return SimpleNamespace(home=lambda: home)

        return SimpleNamespace(service=service)

    served = tmp_path / "served"
    served.mkdir()
    assert home_of(session(str(served)), tmp_path / "other") == served
    for unknown in ("", str(tmp_path / "elsewhere")):
        assert home_of(session(unknown), tmp_path / "other") == tmp_path / "other"
        assert (tmp_path / "other").is_dir()
