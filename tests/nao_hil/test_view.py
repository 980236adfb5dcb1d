"""The page's parts without a browser: what buttons send, what charts draw, what a robot looks like."""

from __future__ import annotations

import contextlib
import math
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.body import BODIES, load_body
from bridge.body.sole import sole_hull
from bridge.errors import LinkError
from bridge.messages.faults import JointWeak
from bridge.messages.guard import GuardStatus
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.messages.world import EndFault, PlateUnderFoot, Push, SetFriction, StartFault, TiltFloor
from bridge.messages.world_state import WorldReply
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from emulator.scenarios.ground import PlacedBox, ScenarioFloor
from emulator.scenarios.model import Scenario
from nao_hil import view
from nao_hil.analysis.diagnosis import BalanceEstimator, Diagnosis, Gatherer, Moment, Symptom
from nao_hil.analysis.diagnosis.symptoms import MEANING
from nao_hil.drive.driver import HOLD, NOTCHES
from nao_hil.view.charts import strip_charts
from nao_hil.view.controls import FAULTS, Controls
from nao_hil.view.driving import Driving
from nao_hil.view.film import first_run
from nao_hil.view.history import History
from nao_hil.view.looks import link_parts, terrain_meshes
from nao_hil.view.page import verdict
from nao_hil.view.surroundings import initial_world
from walker.planning import gait_parameters

BODY = load_body("nao-v3")
REPLY = WorldReply(
    text="Done.",
    seq=0,
    time=0.0,
    paused=False,
    floor=(0.0, 0.0),
    friction=0.8,
    objects=(),
    faults=(),
)
STATUS = WalkStatus(
    text="It walks.",
    seq=0,
    state="walk",
    gait="static",
    torso="none",
    admittance=True,
    velocity=(0.05, 0.0, 0.0),
    steps=0,
    distance=0.0,
    position=(0.0, 0.0, 0.0),
)


class Widget:
    """Anything that has been added to a page."""

    def __init__(self, value: Any = None) -> None:
        self.value = value
        self.visible = True
        self.click: Callable[[Any], None] = lambda _: None
        self.update: Callable[[object], None] = lambda _: None

    def on_click(self, act: Callable[[Any], None]) -> None:
        self.click = act

    def on_update(self, act: Callable[[object], None]) -> None:
        self.update = act


class FakeGui:
    """Keeps what is added by its label; also its own tab group."""

    def __init__(self) -> None:
        self.widgets: dict[str, Widget] = {}
        self.tabs: list[str] = []
        self.order = 1.0

    def _add(self, label: str, value: Any = None) -> Widget:
        self.widgets[label] = Widget(value)
        return self.widgets[label]

    def add_button(self, label: str, *, visible: bool = True, **_: Any) -> Widget:
        widget = self._add(label)
        widget.visible = visible
        return widget

    def add_button_group(self, label: str, options: tuple[str, ...], **_: Any) -> Widget:
        group = self._add(f"{label} ({', '.join(options)})")
        for option in options:
            self._add(option).click = lambda _, o=option: group.click(SimpleNamespace(target=Widget(o)))  # type: ignore[misc]
        return group

    def add_checkbox(self, label: str, *, initial_value: bool, **_: Any) -> Widget:
        return self._add(label, initial_value)

    def add_markdown(self, content: str, *, visible: bool) -> Widget:
        widget = self._add(content)
        widget.visible = visible
        return widget

    @contextlib.contextmanager
    def add_folder(self, label: str) -> Iterator[None]:
        yield

    def add_slider(self, label: str, *, min: float, max: float, initial_value: float, **_: Any) -> Widget:
        assert min <= initial_value <= max
        return self._add(label, initial_value)

    def add_number(self, label: str, *, initial_value: float, **_: Any) -> Widget:
        return self._add(label, initial_value)

    def add_dropdown(
        self, label: str, options: tuple[str, ...], initial_value: str | None = None, hint: str = ""
    ) -> Widget:
        return self._add(label, initial_value or options[0])

    @contextlib.contextmanager
    def add_tab(self, label: str) -> Iterator[None]:
        self.tabs.append(label)
        yield

    def press(self, label: str) -> None:
        self.widgets[label].click(None)


class FakeCommands:
    """Takes commands and keeps them."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.there = True

    def world(self, command: Any) -> WorldReply:
        self.sent.append(msgspec.msgpack.decode(msgspec.msgpack.encode(command), type=type(command)))
        return REPLY

    def walk(self, command: WalkCommand) -> WalkStatus:
        self.sent.append(command)
        return STATUS

    send = walk

    def status(self) -> WalkStatus:
        return msgspec.structs.replace(STATUS, state="stand")

    def stop(self) -> GuardStatus:
        if not self.there:
            raise LinkError("No robot `nao` at tcp/127.0.0.1:7447 answered `stop`.")
        return GuardStatus(seq=1, state="crouch", reason="stop", armed=False, text="It goes down.")

    def arm(self) -> GuardStatus:
        return GuardStatus(seq=2, state="idle", armed=True, text="Armed.")


@pytest.fixture
def gui() -> FakeGui:
    return FakeGui()


@pytest.fixture
def commands() -> FakeCommands:
    return FakeCommands()


@pytest.fixture
def lookers() -> list[str]:
    """Who looks at the page."""
    return ["somebody"]


@pytest.fixture
def driving(commands: FakeCommands, lookers: list[str]) -> Driving:
    return Driving(lambda: commands, lambda: bool(lookers))  # type: ignore[arg-type, return-value]


@pytest.fixture
def said(gui: FakeGui, commands: FakeCommands, driving: Driving) -> list[str]:
    """What the person is told, with all tabs built."""
    words: list[str] = []
    Controls(gui, commands, driving, words.append).build(gui, world=True)  # type: ignore[arg-type]
    return words


def test_the_push_button_pushes_as_the_sliders_say(
    gui: FakeGui, commands: FakeCommands, said: list[str]
) -> None:
    gui.widgets["impulse, N s"].value, gui.widgets["towards, deg"].value = 2.0, 90
    gui.press("Push")
    (push,) = commands.sent
    assert isinstance(push, Push) and push.impulse == pytest.approx((0.0, 2.0, 0.0))
    assert said == ["Done."]


def test_the_world_is_changed_in_si_units(gui: FakeGui, commands: FakeCommands, said: list[str]) -> None:
    gui.widgets["pitch, deg"].value = -6.0
    gui.widgets["height, mm"].value = 12
    gui.widgets["friction"].value = 0.2
    for button in ("Tilt the floor", "Plate under the swing foot", "Set friction", "Begin the fault"):
        gui.press(button)
    gui.press("End all faults")
    tilt, plate, friction, fault, end = commands.sent
    assert (
        isinstance(tilt, TiltFloor) and tilt.pitch == pytest.approx(math.radians(-6.0)) and tilt.duration >= 1.0
    )
    assert isinstance(plate, PlateUnderFoot) and plate.size[2] == pytest.approx(0.012)
    assert friction == SetFriction(friction=0.2)
    assert fault == StartFault(fault=JointWeak(joint="LKneePitch", fraction=0.5))
    assert end == EndFault()


def test_every_fault_on_offer_is_one_that_there_is(
    gui: FakeGui, commands: FakeCommands, said: list[str]
) -> None:
    for kind in FAULTS:
        gui.widgets["fault"].value = kind
        gui.press("Begin the fault")
    assert [msgspec.to_builtins(c.fault)["kind"] for c in commands.sent] == list(FAULTS)


def test_the_walk_button_leaves_as_it_is_what_nobody_chose(
    gui: FakeGui, commands: FakeCommands, said: list[str]
) -> None:
    gui.widgets["torso control"].value, gui.widgets["admittance"].value = "robust", "off"
    gui.press("Walk")
    gui.widgets["speed, m/s"].value = 0.05
    gui.press("Walk")
    as_it_is = WalkCommand(op="walk", steps=0, torso="robust", admittance=False)
    assert commands.sent == [as_it_is, msgspec.structs.replace(as_it_is, velocity=(0.05, 0.0, 0.0))]
    assert said == ["It walks."] * 2


def test_the_buttons_of_the_wheel_do_what_the_keys_of_drive_do(
    gui: FakeGui, commands: FakeCommands, said: list[str]
) -> None:
    for button in ("Faster", "Faster", "Torso control", "Stop"):
        gui.press(button)
    own = gait_parameters("static").periodic_step.velocity
    assert commands.sent == [
        WalkCommand(op="walk", velocity=(pytest.approx(n * own / NOTCHES), 0.0, 0.0), hold=HOLD, torso=torso)
        for n, torso in ((1, None), (2, None), (2, "thesis"))
    ] + [WalkCommand(op="stop")]
    assert set(driving_keys()) == {"Slower", "Faster", "Stop", "Gait", "Torso control", "Admittance"}


def driving_keys() -> list[str]:
    """Buttons that the script of keys and gamepad presses."""
    script = (Path(view.__file__).parent / "page.js").read_text()
    return re.findall(r'"([A-Z][^"]*)"', script.split("const FORWARDS")[0])


def test_a_driver_is_missed_when_nobody_looks_any_more_or_another_button_is_pressed(
    gui: FakeGui,
    commands: FakeCommands,
    driving: Driving,
    lookers: list[str],
    said: list[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("nao_hil.drive.session.SIGN", 0.0)

    def signs() -> list[WalkCommand]:
        before = len(commands.sent)
        driving.sign()
        sent: list[WalkCommand] = commands.sent[before:]
        return sent

    gui.press("Faster")
    assert [(c.op, c.hold) for c in signs()] == [("walk", HOLD)]
    lookers.clear()
    assert signs() == []
    lookers.append("somebody else")
    assert signs() == []
    gui.press("Faster")
    gui.press("Walk")
    assert signs() == []


def test_keys_do_nothing_until_the_box_is_ticked(gui: FakeGui, said: list[str]) -> None:
    (mark,) = [name for name in gui.widgets if "keys-drive" in name]
    assert not gui.widgets[mark].visible  # what the script looks for
    gui.widgets["keys, gamepad"].value = True
    gui.widgets["keys, gamepad"].update(None)
    assert gui.widgets[mark].visible


def test_after_an_emergency_stop_arm_is_where_walk_and_stop_were(gui: FakeGui, said: list[str]) -> None:
    go, arm = gui.widgets["walk (Walk, Stop)"], gui.widgets["Arm"]
    assert (go.visible, arm.visible) == (True, False)
    gui.press("Emergency stop")
    assert (go.visible, arm.visible) == (False, True)
    gui.press("Arm")
    assert (go.visible, arm.visible) == (True, False)
    assert said == ["It goes down.", "Armed."]


def test_what_is_refused_is_told(gui: FakeGui, commands: FakeCommands, said: list[str]) -> None:
    commands.there = False
    gui.press("Emergency stop")
    assert said == ["No robot `nao` at tcp/127.0.0.1:7447 answered `stop`."]


def test_a_real_robot_has_no_world_to_change(gui: FakeGui, commands: FakeCommands, driving: Driving) -> None:
    Controls(gui, commands, driving, print).build(gui, world=False)  # type: ignore[arg-type]
    assert gui.tabs == ["Walk"]
    assert "Push" not in gui.widgets and "Emergency stop" in gui.widgets


@pytest.fixture(scope="module")
def standing() -> list[Moment]:
    """Two seconds of a robot that stands."""
    gatherer, kept = Gatherer(), []
    with EmulatedRobot(BODY, seed=0) as robot:
        for _ in range(200):
            robot.advance(None)
            for message in (robot.frame, robot.truth()):
                if (moment := gatherer.add(message)) is not None:
                    kept.append(moment)
    return kept


def chart_of(history: History, end: float, symptoms: list[Symptom]) -> ElementTree.Element:
    """The charts as XML."""
    return ElementTree.fromstring(strip_charts(history, end, symptoms, symptoms[0] if symptoms else None))


def test_charts_draw_each_number_where_it_belongs_and_mark_what_went_wrong(standing: list[Moment]) -> None:
    observer, history = BalanceEstimator(BODY), History(1000)
    for moment in standing:
        history.add(observer.update(moment))
    end = standing[-1].sensors.time
    symptom = Symptom(end - 1.0, "slip", "the left foot slipped & <fell>")
    root = chart_of(history, end, [symptom])
    texts = [t.text or "" for t in root.iter("text")]
    weight = sum(standing[-1].sensors.fsr[:4])
    assert f"left {weight:.0f}" in texts
    assert any("first: the left foot slipped & <fell>" in t for t in texts)
    (mark,) = [line for line in root.iter("line") if line.get("stroke") == "#fa5252"]
    assert root.get("viewBox") is not None
    width = float(str(root.get("viewBox")).split()[2])
    assert float(str(mark.get("x1"))) == pytest.approx(width - 0.1 * (width - 28.0), abs=0.1)
    for line in root.iter("polyline"):
        points = np.array([[float(c) for c in p.split(",")] for p in str(line.get("points")).split()])
        assert (np.diff(points[:, 0]) > 0.0).all() and points[-1, 0] <= width


def test_a_history_begins_anew_with_its_robot(standing: list[Moment]) -> None:
    observer, history = BalanceEstimator(BODY), History(150)
    for moment in [*standing, *standing[:20]]:
        history.add(observer.update(moment))
    rows, phases = history.window(10.0, 20.0)
    assert len(rows) == len(phases) == 20
    assert rows[:, 0] == pytest.approx([m.sensors.time for m in standing[:20]])


def test_a_frame_is_late_against_the_earliest_one(standing: list[Moment]) -> None:
    observer, history = BalanceEstimator(BODY), History(150)
    for moment in standing[:10]:
        late = 0.003 if moment.sensors.seq == 5 else 0.0
        wall = round(1e9 * (1000.0 + moment.sensors.time + late))
        history.add(
            observer.update(moment._replace(sensors=msgspec.structs.replace(moment.sensors, wall=wall)))
        )
    rows, _ = history.window(10.0, 20.0)
    assert rows[:, 8].max() == pytest.approx(3.0, abs=1e-3) and np.sort(rows[:, 8])[-2] < 1e-3


@pytest.mark.parametrize("name", BODIES)
def test_a_body_is_drawn_with_its_own_sole_and_every_face_outward(name: str) -> None:
    body = load_body(name)
    parts = link_parts(body)
    for pieces in parts.values():
        for part in pieces:
            a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
            outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - part.vertices.mean(axis=0))
            assert (outward > -1e-12).all()
    plate = parts["LAnkleRoll"][0].vertices
    low = plate[plate[:, 2] < -body.lengths.FootHeight + 1e-9][:, :2]
    assert sorted(map(tuple, low.round(6))) == sorted(map(tuple, sole_hull(body, "L").round(6)))


def test_the_boxes_of_a_scenario_lie_on_its_floor() -> None:
    scenario = Scenario(
        floor=ScenarioFloor(pitch=10.0), boxes=(PlacedBox(name="step", size=(0.2, 0.4, 0.02), at=(1.0, 0.0)),)
    )
    world = initial_world(scenario, 0)
    (box,) = world.objects
    # Ry(10 deg) of (1, 0, 0.01): downhill ahead.
    s, c = math.sin(math.radians(10.0)), math.cos(math.radians(10.0))
    assert box.position == pytest.approx((c + 0.01 * s, 0.0, -s + 0.01 * c))
    assert box.orientation == pytest.approx(
        (0.0, math.sin(math.radians(5.0)), 0.0, math.cos(math.radians(5.0)))
    )
    assert world.floor == pytest.approx((0.0, math.radians(10.0)))


@pytest.mark.parametrize("name", ["tiles", "rough"])
def test_the_terrain_of_a_recording_is_the_one_the_robot_walked(name: str) -> None:
    scenario = load_scenario(name)
    terrain = initial_world(scenario, 3).terrain
    assert terrain is not None
    with EmulatedRobot(BODY, seed=3, scenario=scenario) as robot:
        assert robot.world.terrain == terrain
        (mesh,) = terrain_meshes(terrain)
        # over the middle of each upward face the ground is as high as the face, where no other tile is near
        corners = mesh[0][mesh[1]]
        upward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 1e-9
        middles = corners[upward].mean(axis=1)
        inside = middles[np.abs(middles[:, :2]).max(axis=1) < 0.4]
        heights = robot.world.ground([(float(x), float(y)) for x, y, _ in inside])
    assert len(inside) > 50
    np.testing.assert_allclose(heights, inside[:, 2], atol=1e-4)


def test_the_verdict_says_what_the_first_sign_means() -> None:
    first = Symptom(4.2, "zmp", "the ZMP left the support polygon")
    push = Symptom(4.0, "world", "Torso is pushed with 1 N s over 0.1 s")
    fall = Symptom(4.9, "fall", "the robot fell")
    words = verdict(Diagnosis(fell=4.9, chain=(push, first, fall), first=first, before=push))
    title, meaning, chain = words.split("\n\n")
    assert title == "#### It fell at 4.90 s. What went wrong first: the ZMP left the support polygon"
    assert meaning == MEANING["zmp"]
    assert chain.index("4.00") < chain.index("4.20") < chain.index("4.90")


def test_a_long_chain_keeps_its_beginning_and_its_end_and_says_that_something_is_left_out() -> None:
    signs = tuple(Symptom(1.0 + 0.5 * i, "early", "the left foot touched down early") for i in range(20))
    push = Symptom(0.9, "world", "Torso is pushed with 1 N s over 0.1 s")
    fall = Symptom(11.0, "fall", "the robot fell")
    diagnosis = Diagnosis(fell=11.0, chain=(push, *signs, fall), first=signs[0], before=push, torso_off=True)
    _, meaning, chain = verdict(diagnosis).split("\n\n")
    assert "torso control" in meaning and meaning.endswith("was off.")
    told = chain.split(" → ")
    assert [words[2:6] for words in told[:2]] == ["0.90", "1.00"]
    assert told[2] == "…" and chain.count("…") == 1
    assert told[-2].startswith("**10.50") and told[-1].startswith("**11.00")


def test_charts_of_a_recording_show_what_comes_and_write_out_what_is(standing: list[Moment]) -> None:
    observer, history = BalanceEstimator(BODY), History(1000)
    for moment in standing:
        history.add(observer.update(moment))
    now = standing[99].sensors.time
    later = Symptom(now + 0.5, "zmp", "later")
    root = ElementTree.fromstring(
        strip_charts(history, now, [Symptom(now - 0.5, "slip", "before"), later], later, ahead=1.0)
    )
    texts = [t.text or "" for t in root.iter("text")]
    assert f"left {round(sum(standing[99].sensors.fsr[:4]))}" in texts
    assert "before" in texts and "later" not in texts  # told; the mark's own words begin with `first`
    assert any("first: later" in t for t in texts)


SHARE = """
import socket, sys
from viser._messages import ShareUrlRequest
from nao_hil.view.server import open_server
with socket.socket() as probe:
    probe.bind(("127.0.0.1", 0))
    port = probe.getsockname()[1]
server = open_server("127.0.0.1", port, "test")
(handler,) = server._websock_server._incoming_handlers[ShareUrlRequest]
handler(0, ShareUrlRequest())
print(server._share_tunnel)
server.stop()
"""


def test_a_browser_cannot_have_the_page_shared_on_the_internet() -> None:
    done = subprocess.run(
        [sys.executable, "-c", SHARE], capture_output=True, text=True, timeout=120, check=False
    )
    assert (done.returncode, done.stdout.splitlines()[:1]) == (0, ["None"]), done.stderr


def test_a_film_shows_the_run_before_a_reset(standing: list[Moment]) -> None:
    assert first_run([*standing, *standing[:5]]) == standing
    assert first_run(standing) == standing
