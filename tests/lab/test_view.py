"""The page's parts without a browser: what buttons send, what charts draw, what a robot looks like."""

from __future__ import annotations

import contextlib
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.datasheet import BODIES, load_body
from bridge.datasheet.sole import sole_hull
from bridge.errors import LinkError
from bridge.faults import JointWeak
from bridge.guard.messages import GuardStatus
from bridge.walk import WalkCommand, WalkStatus
from bridge.world import EndFault, PlateUnderFoot, Push, SetFriction, StartFault, TiltFloor, WorldReply
from emulator.robot import EmulatedRobot
from emulator.scenarios.model import Floor, PlacedBox, Scenario
from lab.diagnosis import Gatherer, Moment, Observer, Symptom
from lab.view.charts import strip_charts
from lab.view.controls import FAULTS, Controls
from lab.view.film import first_run
from lab.view.history import History
from lab.view.looks import link_parts
from lab.view.surroundings import initial_world

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
        self.click: Callable[[object], None] = lambda _: None

    def on_click(self, act: Callable[[object], None]) -> None:
        self.click = act


class FakeGui:
    """Keeps what is added by its label; also its own tab group."""

    def __init__(self) -> None:
        self.widgets: dict[str, Widget] = {}
        self.tabs: list[str] = []

    def _add(self, label: str, value: Any = None) -> Widget:
        self.widgets[label] = Widget(value)
        return self.widgets[label]

    def add_button(self, label: str, **_: Any) -> Widget:
        return self._add(label)

    def add_slider(self, label: str, *, min: float, max: float, initial_value: float, **_: Any) -> Widget:
        assert min <= initial_value <= max
        return self._add(label, initial_value)

    def add_number(self, label: str, *, initial_value: float, **_: Any) -> Widget:
        return self._add(label, initial_value)

    def add_dropdown(self, label: str, options: tuple[str, ...], initial_value: str | None = None) -> Widget:
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

    def world(self, command: Any) -> WorldReply:
        self.sent.append(msgspec.msgpack.decode(msgspec.msgpack.encode(command), type=type(command)))
        return REPLY

    def walk(self, command: WalkCommand) -> WalkStatus:
        self.sent.append(command)
        return STATUS

    def stop(self) -> GuardStatus:
        raise LinkError("No robot `nao` at tcp/127.0.0.1:7447 answered `stop`.")


@pytest.fixture
def gui() -> FakeGui:
    return FakeGui()


@pytest.fixture
def commands() -> FakeCommands:
    return FakeCommands()


@pytest.fixture
def said(gui: FakeGui, commands: FakeCommands) -> list[str]:
    """What the person is told, with all tabs built."""
    words: list[str] = []
    Controls(gui, commands, words.append).build(gui, world=True)  # type: ignore[arg-type]
    return words


def test_the_push_button_pushes_as_the_sliders_say(
    gui: FakeGui, commands: FakeCommands, said: list[str]
) -> None:
    gui.widgets["push, N s"].value, gui.widgets["direction, deg"].value = 2.0, 90
    gui.press("Push")
    (push,) = commands.sent
    assert isinstance(push, Push) and push.impulse == pytest.approx((0.0, 2.0, 0.0))
    assert said == ["Done."]


def test_the_world_is_changed_in_si_units(gui: FakeGui, commands: FakeCommands, said: list[str]) -> None:
    gui.widgets["floor pitch, deg"].value = -6.0
    gui.widgets["plate, mm"].value = 12
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
    assert fault == StartFault(fault=JointWeak(joint="LKneePitch", share=0.5))
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
    assert commands.sent == [
        WalkCommand(op="walk", velocity=(0.05, 0.0, 0.0), steps=0, torso="robust", admittance=False)
    ]
    assert said == ["It walks."]


def test_what_is_refused_is_told(gui: FakeGui, said: list[str]) -> None:
    gui.press("Emergency stop")
    assert said == ["No robot `nao` at tcp/127.0.0.1:7447 answered `stop`."]


def test_a_real_robot_has_no_world_to_change(gui: FakeGui, commands: FakeCommands) -> None:
    Controls(gui, commands, print).build(gui, world=False)  # type: ignore[arg-type]
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
    """The charts as XML: MDX takes what XML takes, but for the braces of a style."""
    text = strip_charts(history, end, symptoms, symptoms[0] if symptoms else None)
    assert "\n" not in text
    return ElementTree.fromstring(text.replace('style={{display: "block"}}', ""))


def test_charts_draw_each_number_where_it_belongs_and_mark_what_went_wrong(standing: list[Moment]) -> None:
    observer, history = Observer(BODY), History(1000)
    for moment in standing:
        history.add(observer.update(moment))
    end = standing[-1].sensors.time
    symptom = Symptom(end - 1.0, "slip", "the left foot {slipped} & <fell>")
    root = chart_of(history, end, [symptom])
    texts = [t.text or "" for t in root.iter("text")]
    weight = sum(standing[-1].sensors.fsr[:4])
    assert f"left {weight:.0f}" in texts
    assert any("first: the left foot (slipped) & <fell>" in t for t in texts)
    (mark,) = [line for line in root.iter("line") if line.get("stroke") == "#fa5252"]
    assert root.get("viewBox") is not None
    width = float(str(root.get("viewBox")).split()[2])
    assert float(str(mark.get("x1"))) == pytest.approx(width - 0.1 * (width - 28.0), abs=0.1)
    for line in root.iter("polyline"):
        points = np.array([[float(c) for c in p.split(",")] for p in str(line.get("points")).split()])
        assert (np.diff(points[:, 0]) > 0.0).all() and points[-1, 0] <= width


def test_a_history_begins_anew_with_its_robot(standing: list[Moment]) -> None:
    observer, history = Observer(BODY), History(150)
    for moment in [*standing, *standing[:20]]:
        history.add(observer.update(moment))
    rows, phases = history.window(10.0, 20.0)
    assert len(rows) == len(phases) == 20
    assert rows[:, 0] == pytest.approx([m.sensors.time for m in standing[:20]])


def test_a_frame_is_late_against_the_earliest_one(standing: list[Moment]) -> None:
    observer, history = Observer(BODY), History(150)
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
        floor=Floor(pitch=10.0), boxes=(PlacedBox(name="step", size=(0.2, 0.4, 0.02), at=(1.0, 0.0)),)
    )
    world = initial_world(scenario)
    (box,) = world.objects
    # Ry(10 deg) of (1, 0, 0.01): downhill ahead.
    s, c = math.sin(math.radians(10.0)), math.cos(math.radians(10.0))
    assert box.position == pytest.approx((c + 0.01 * s, 0.0, -s + 0.01 * c))
    assert box.orientation == pytest.approx(
        (0.0, math.sin(math.radians(5.0)), 0.0, math.cos(math.radians(5.0)))
    )
    assert world.floor == pytest.approx((0.0, math.radians(10.0)))


def test_a_film_shows_the_run_before_a_reset(standing: list[Moment]) -> None:
    assert first_run([*standing, *standing[:5]]) == standing
    assert first_run(standing) == standing
