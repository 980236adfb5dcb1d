"""The page's parts without a browser: what buttons send, what charts draw, what a robot looks like."""

from __future__ import annotations

import contextlib
import math
import re
import subprocess
import sys
import threading
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
from nao_hil.view.charts import CHARTS, MARKS, Charts, mark
from nao_hil.view.controls import FAULTS, Controls
from nao_hil.view.gaps import with_breaks, with_gaps
from nao_hil.view.history import History
from nao_hil.view.joints import joint_table
from nao_hil.view.scene.push import level_way
from nao_hil.view.slow_motion import SlowMotion

from bridge.body import BODIES, load_body
from bridge.body.joints import JOINTS
from bridge.body.sole import sole_hull
from bridge.errors import LinkError
from bridge.messages import ActuatorFrame
from bridge.messages.faults import JointWeak
from bridge.messages.guard import GuardStatus
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.messages.world import (
    EndFault,
    Pause,
    PlateUnderFoot,
    Push,
    Resume,
    SetFriction,
    StartFault,
    Step,
    TiltFloor,
)
from bridge.messages.world_state import WorldReply
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from emulator.scenarios.ground import PlacedBox, ScenarioFloor
from emulator.scenarios.model import Scenario
from nao_hil import view
from nao_hil.analysis.diagnosis import BalanceEstimator, Diagnosis, Moment, MomentBuilder, Symptom
from nao_hil.analysis.diagnosis.symptoms import MEANING
from nao_hil.drive.driver import HOLD, SPEED_STEPS, TURN
from nao_hil.view.driving import KEYS, Driving
from nao_hil.view.hand import SPEED, Hand
from nao_hil.view.looks import link_parts, terrain_meshes
from nao_hil.view.page import verdict, walks_again
from nao_hil.view.recorded_run import first_run
from nao_hil.view.surroundings import initial_world
from tests.loops import TIMEOUT, until
from tests.ports import free_port
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

    def add_html(self, content: str) -> Widget:
        return self._add(content)

    def add_text(self, label: str, *, initial_value: str, **_: Any) -> Widget:
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

    def type(self, label: str, text: str) -> None:
        """As a person."""
        self.widgets[label].value = text
        self.widgets[label].update(SimpleNamespace(client="somebody"))


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
def aimed() -> list[tuple[float, float]]:
    """Impulses that are shown as an arrow."""
    return []


@pytest.fixture
def said(gui: FakeGui, commands: FakeCommands, driving: Driving, aimed: list[tuple[float, float]]) -> list[str]:
    """What the person is told, with all tabs built."""
    words: list[str] = []
    Controls(gui, commands, driving, words.append, aimed.append, 0.01).build(gui, world=True)  # type: ignore[arg-type]
    return words


def test_the_push_button_pushes_as_the_pad_says_and_an_arrow_shows_it_before(
    gui: FakeGui, commands: FakeCommands, said: list[str], aimed: list[tuple[float, float]]
) -> None:
    for unfinished in ("", "0", "0 2 3", "0 x", "0 nan"):
        gui.type("impulse, N s", unfinished)
    assert aimed == []
    gui.type("impulse, N s", "-0.5, 2")
    assert commands.sent == [] and aimed == [(-0.5, 2.0)]  # an arrow first
    gui.press("Push")
    (push,) = commands.sent
    assert isinstance(push, Push) and push.impulse == pytest.approx((-0.5, 2.0, 0.0))
    assert said == ["Done."]


def test_the_velocity_pad_walks_and_stop_puts_it_back_to_rest(
    gui: FakeGui, commands: FakeCommands, said: list[str]
) -> None:
    gui.type("velocity", "0.2 -0.05 0.4")
    gui.type("velocity", "0 0 0")
    gui.type("velocity", "0.1 0 0")
    gui.press("Stop")
    assert gui.widgets["velocity"].value == "0.00 0.00 0.00"
    first, rest, again, stop = commands.sent
    assert first.op == again.op == "walk" and first.velocity == pytest.approx((0.2, -0.05, 0.4))
    assert again.velocity == pytest.approx((0.1, 0.0, 0.0)) and again.hold == HOLD
    assert rest == stop == WalkCommand(op="stop")


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
        WalkCommand(
            op="walk", velocity=(pytest.approx(n * own / SPEED_STEPS), 0.0, 0.0), hold=HOLD, torso=torso
        )
        for n, torso in ((1, None), (2, None), (2, "thesis"))
    ] + [WalkCommand(op="stop")]
    assert set(driving_keys()) == set(KEYS)


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
    go, arm = gui.widgets["walk (Walk, Stop, Sit)"], gui.widgets["Arm"]
    assert (go.visible, arm.visible) == (True, False)
    gui.press("Emergency stop")
    assert (go.visible, arm.visible) == (False, True)
    gui.press("Arm")
    assert (go.visible, arm.visible) == (True, False)
    assert said == ["It goes down.", "Armed."]


def test_dragging_the_robot_pushes_it_once_it_is_let_go(
    gui: FakeGui, commands: FakeCommands, driving: Driving, aimed: list[tuple[float, float]]
) -> None:
    controls = Controls(gui, commands, driving, print, aimed.append, 0.01)  # type: ignore[arg-type]
    controls.drag((1.0, -9.0), False)
    assert commands.sent == [] and aimed == [(1.0, -3.0)]  # no farther than the pad goes
    controls.drag((1.0, -2.0), True)
    assert commands.sent == [Push(impulse=(1.0, -2.0, 0.0))]


def test_a_drag_goes_to_the_place_that_is_seen_under_the_pointer() -> None:
    start, place, eye = np.array([0.1, 0.0, 0.4]), np.array([0.3, 0.5, 0.4]), np.array([1.0, -2.0, 1.0])
    np.testing.assert_allclose(level_way(start, eye + 0.7 * (place - eye), eye), place - start, atol=1e-12)
    eye[2] = 0.4  # who looks along the floor sees no place on it
    np.testing.assert_allclose(level_way(start, place + np.array([0.0, 0.0, 0.2]), eye), place - start)


@pytest.mark.parametrize(("gait", "everywhere"), [("omni", True), ("static", False)])
def test_the_pad_shows_the_directions_that_the_gait_can_go(
    gui: FakeGui, commands: FakeCommands, driving: Driving, gait: str, everywhere: bool
) -> None:
    controls = Controls(gui, commands, driving, print, print, 0.01)  # type: ignore[arg-type]
    controls.build(gui, world=False)
    controls.show_gait(gait)
    assert gui.widgets["turn (Turn left, Turn right)"].visible == everywhere
    assert gui.widgets["velocity"].visible == everywhere
    assert gui.widgets["speed, m/s"].visible != everywhere  # one place for the speed
    assert gui.widgets["sideways (Left, Right)"].visible == everywhere
    assert gui.widgets["ahead (Slower, Faster)"].visible
    gui.press("Turn left")
    assert commands.sent[-1].velocity == pytest.approx((0.0, 0.0, TURN))


def test_slow_motion_steps_the_world_and_ends_with_any_command_to_its_time(
    gui: FakeGui, commands: FakeCommands, said: list[str]
) -> None:
    gui.widgets["slow motion"].value = "0.5"
    gui.widgets["slow motion"].update(None)
    until(lambda: len(commands.sent) > 3, "some steps")
    gui.press("Resume")
    first, *steps, last = commands.sent
    assert (first, set(map(type, steps)), last) == (Pause(), {Step}, Resume())
    assert "slow" not in [thread.name for thread in threading.enumerate()]


def test_a_page_that_ends_leaves_a_world_that_goes_on(commands: FakeCommands) -> None:
    slow = SlowMotion(commands.world, 0.01)
    slow.end()
    assert commands.sent == []  # it was not slowed down
    slow.set_speed(0.1)
    slow.end()
    assert commands.sent[-1] == Resume()


def test_the_joint_table_says_what_was_asked_and_what_is(standing: list[Moment]) -> None:
    frame = standing[-1].sensors
    asked = ActuatorFrame(position=tuple(0.01 * i for i in range(25)), stiffness=(1.0,) * 25, reply_to=1)
    table = ElementTree.fromstring(joint_table(standing[-1]._replace(asked=asked)))
    rows = {row[0].text: [cell.text for cell in row[1:]] for row in table.iter("tr") if row[0].text}
    assert len(rows) == 25
    i = JOINTS.index("LKneePitch")
    assert rows["LKneePitch"][:2] == [f"{math.degrees(0.01 * i):.1f}", f"{math.degrees(frame.position[i]):.1f}"]
    assert rows["LKneePitch"][2:] == [f"{frame.current[i]:.2f}", f"{frame.temperature[i]:.0f}"]


def test_what_is_refused_is_told(gui: FakeGui, commands: FakeCommands, said: list[str]) -> None:
    commands.there = False
    gui.press("Emergency stop")
    assert said == ["No robot `nao` at tcp/127.0.0.1:7447 answered `stop`."]


def test_a_real_robot_has_no_world_to_change(gui: FakeGui, commands: FakeCommands, driving: Driving) -> None:
    Controls(gui, commands, driving, print, print, 0.01).build(gui, world=False)  # type: ignore[arg-type]
    assert gui.tabs == ["Walk"]
    assert "Push" not in gui.widgets and "Emergency stop" in gui.widgets


@pytest.fixture(scope="module")
def standing() -> list[Moment]:
    """Two seconds of a robot that stands."""
    builder, kept = MomentBuilder(), []
    with EmulatedRobot(BODY, seed=0, engine="mujoco") as robot:
        for _ in range(200):
            robot.advance(None)
            for message in (robot.frame, robot.truth()):
                if (moment := builder.add(message)) is not None:
                    kept.append(moment)
    return kept


class FakePlots:
    """Keeps the plots that are added, by their title."""

    def __init__(self) -> None:
        self.plots: dict[str, Any] = {}
        self.html = SimpleNamespace(content="")

    def add_uplot(self, data: Any, series: Any, *, title: str, **_: Any) -> Any:
        self.plots[title] = SimpleNamespace(data=data, series=series, visible=True)
        return self.plots[title]

    def add_html(self, _: str) -> Any:
        return self.html


def history_of(moments: list[Moment]) -> History:
    observer, history = BalanceEstimator(BODY), History(1000)
    for moment in moments:
        history.add(observer.update(moment))
    return history


def test_charts_draw_each_number_where_it_belongs_and_mark_what_went_wrong(standing: list[Moment]) -> None:
    gui, now = FakePlots(), standing[99].sensors.time
    signs = [Symptom(now - 0.5, "slip", "the left foot slipped & <fell>"), Symptom(now + 0.5, "zmp", "later")]
    charts = Charts(gui)
    charts.draw(history_of(standing), now, signs, signs[1], ahead=1.0)
    forces = gui.plots["foot sensors, N"]
    times, left, right, *marks = forces.data
    assert [line["label"] for line in forces.series] == ["s", "left", "right", *MARKS]
    row = int(np.searchsorted(times, standing[50].sensors.time))
    assert left[row] == pytest.approx(sum(standing[50].sensors.fsr[:4]))
    assert right[row] == pytest.approx(sum(standing[50].sensors.fsr[4:]))
    lines = {name: times[curve > 1.0] for name, curve in zip(MARKS, marks, strict=True)}
    assert lines["now"] == pytest.approx([now]) and lines["sign"] == pytest.approx([now - 0.5], abs=0.01)
    assert lines["first"] == pytest.approx([now + 0.5], abs=0.01) and len(lines["world"]) == 0
    assert "slipped &amp; &lt;fell&gt;" in gui.html.content and "later" not in gui.html.content
    assert {c.title for c in CHARTS if gui.plots[c.title].visible} <= {c.title for c in charts.chosen}
    assert not gui.plots["cycle late, ms"].visible  # these moments have no wall clock
    assert not gui.plots["gyroscope, deg/s"].visible
    charts.choose(CHARTS[4:5])
    assert gui.plots["gyroscope, deg/s"].visible and not gui.plots["torso, deg"].visible


def test_a_curve_ends_where_no_value_is_known_and_at_a_break_of_the_recording() -> None:
    cycles = np.delete(0.01 * np.arange(100), slice(40, 60))
    rows = np.column_stack([cycles, np.where(cycles < 0.1, np.nan, 1.0), np.ones(80)])
    broken, phases = with_breaks(rows, ["SSL"] * 80)
    times, late, always = with_gaps(list(broken.T))
    assert list(times) == pytest.approx([*cycles[:40], 0.495, *cycles[40:]])
    assert late == [*[None] * 10, *[1.0] * 30, None, *[1.0] * 40]
    assert always == [*[1.0] * 40, None, *[1.0] * 40]
    assert phases == [*["SSL"] * 40, "", *["SSL"] * 40]
    assert isinstance(times, np.ndarray)  # a curve without a gap is sent as numbers


def test_marks_are_vertical_lines_between_points_that_stay_in_order() -> None:
    times = np.array([0.0, 1.0, 2.0, 3.0])
    order, (one, two) = mark(times, [[1.0, 5.0], [1.0, 3.0]])
    assert (np.diff(times[order]) >= 0.0).all() and set(order) == {0, 1, 2, 3}
    for curve, at in ((one, [1.0]), (two, [1.0, 3.0])):
        (peaks,) = np.nonzero(curve > 1.0)
        assert list(times[order[peaks]]) == at
        assert (times[order[peaks - 1]] == times[order[peaks]]).all()  # upright
        assert (times[order[peaks + 1]] == times[order[peaks]]).all()


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
        paused = 20.0 if moment.sensors.seq > 8 else 0.0
        late = paused + (0.003 if moment.sensors.seq == 5 else 0.0)
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


@pytest.mark.parametrize(
    ("seconds", "state", "again"), [(0.5, "walk", False), (9.0, "motion", False), (9.0, "walk", True)]
)
def test_the_verdict_leaves_the_headline_once_the_robot_walks_again(
    standing: list[Moment], seconds: float, state: str, again: bool
) -> None:
    moment = standing[-1]
    fell = Diagnosis(fell=moment.sensors.time - seconds, chain=(), first=None, before=None)
    walk = SimpleNamespace(state=state)
    assert walks_again(moment._replace(walk=walk), fell) == again  # type: ignore[arg-type]


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


SHARE = """
import sys
from viser._messages import ShareUrlRequest
from nao_hil.view.server import open_server
server = open_server("127.0.0.1", int(sys.argv[1]), "test")
(handler,) = server._websock_server._incoming_handlers[ShareUrlRequest]
handler(0, ShareUrlRequest())
print(server._share_tunnel)
server.stop()
"""


def test_a_browser_cannot_have_the_page_shared_on_the_internet() -> None:
    done = subprocess.run(
        [sys.executable, "-c", SHARE, str(free_port())],
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    assert (done.returncode, done.stdout.splitlines()[:1]) == (0, ["None"]), done.stderr


def test_a_film_shows_the_run_before_a_reset(standing: list[Moment]) -> None:
    assert first_run([*standing, *standing[:5]]) == standing
    assert first_run(standing) == standing


class HeldRobot:
    """Follows what it is asked for; the page lets go after some cycles."""

    def __init__(self, cycles: int, first: Callable[[], None]) -> None:
        self.frame = SimpleNamespace(position=(0.1,) * len(JOINTS))
        self.asked: list[Any] = []
        self.cycles, self.first = cycles, first

    @contextlib.contextmanager
    def connect(self, *_: Any, **__: Any) -> Iterator[HeldRobot]:
        yield self

    def step(self, target: Any) -> None:
        if not self.asked:
            self.first()
        self.asked.append(np.array(target))
        if len(self.asked) == self.cycles:
            raise LinkError("The robot went away.")


class HandGui(FakeGui):
    """With the folder and the buttons of the joints' sliders."""

    def add_folder(self, label: str, **_: Any) -> Any:  # type: ignore[override]
        self.widgets[label] = FolderWidget()
        return self.widgets[label]


class FolderWidget(Widget):
    """A folder that is kept."""

    def __enter__(self) -> FolderWidget:
        return self

    def __exit__(self, *_: object) -> None: ...


def test_a_held_robot_s_joints_go_where_their_sliders_are_no_faster_than_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gui, words = HandGui(), list[str]()

    def move() -> None:
        gui.widgets["LKneePitch"].value = math.degrees(0.5)
        gui.widgets["LKneePitch"].update(SimpleNamespace(client="somebody"))

    robot = HeldRobot(100, move)
    monkeypatch.setattr("nao_hil.view.hand.connect", robot.connect)
    Hand(gui, contextlib.nullcontext(), BODY, "nao", "tcp/127.0.0.1:1", words.append)
    gui.press("Take the joints")
    until(lambda: "The robot went away." in words, "the page's word")
    asked = np.array(robot.asked)
    knee = asked[:, JOINTS.index("LKneePitch")]
    assert knee[0] == pytest.approx(0.1) and knee[-1] == pytest.approx(0.5)
    assert np.diff(knee).max() == pytest.approx(SPEED * BODY.cycle)
    assert np.ptp(np.delete(asked, JOINTS.index("LKneePitch"), axis=1)) == 0.0
    until(lambda: not gui.widgets["Joints, deg"].visible, "the sliders to go")
