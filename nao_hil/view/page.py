"""The page: takes moments, keeps their history, and shows the newest one."""

from __future__ import annotations

import html
import threading
from collections import deque
from collections.abc import Sequence
from typing import Any, Final

from bridge.body import Body
from bridge.messages.world_state import WorldReply
from nao_hil.analysis.diagnosis import Balance, BalanceEstimator, Diagnosis, Moment, Symptom, Symptoms, explain
from nao_hil.analysis.diagnosis.symptoms import MEANING
from nao_hil.view.charts import CHARTS, Charts
from nao_hil.view.history import History
from nao_hil.view.joints import JointView
from nao_hil.view.scene.palette import POINTS
from nao_hil.view.scene.push import Dragged
from nao_hil.view.scene.robot import RobotScene
from walker.estimation.odometry import GroundPlane

CAMERA: Final = ((0.50, -0.66, 0.42), (0.0, 0.0, 0.2))
"""Where the camera is and where it looks at first, m, the robot's place being the origin."""
TOP: Final = -1.0
"""Order of the first row of the panel."""
PANEL: Final = 400
"""Width of the panel, pixels of the browser."""
KEPT: Final = 12_000
"""Frames of history, two minutes."""
JOINT_ROWS: Final = 1000
"""Frames that the plot of a joint shows."""
CHART_EVERY: Final = 6
"""Pictures from one drawing of the charts to the next."""
MOST: Final = 200
"""Symptoms that are kept."""
CHAIN: Final = 6
"""Of the signs that led to a fall, so many are told: the first, and the last."""
AGAIN: Final = 3.0
"""A robot that walks this long after its fall has got up, s."""
HEADLINE: Final = '<span class="nao-headline"></span>{}'
"""First line of the panel's text, which `page.js` finds."""
LEGEND: Final = (
    "**robot**: where it truly is; a real one as its sensors say. **Orange ghost**: as its sensors say.",
    "**bars on the feet**: force cells, 6 mm per N. **Area on the ground**: what it stands on; red: it tips.",
    "**outlines**: footsteps, planned (blue) and made (grey).",
    "**phase**: DSL, DSR both feet down; SSL, SSR on one foot while the other swings.",
)


class Page:
    """One page on one server; give it a body before moments.

    Args:
        server: A `viser.ViserServer`.
        title: What is shown, for the headline: a robot or a file.
    """

    def __init__(self, server: Any, title: str) -> None:
        self.server, self.gui = server, server.gui
        self._title = title
        self._lock = threading.Lock()
        self._scene: RobotScene | None = None
        self._dragged: Dragged | None = None
        self._dress(dark=True)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(PANEL)
        server.on_client_connect(_aim)
        # Shadows of translucent parts are hardly seen; drawn in software they took 16 of 17 parts of the time.
        server.scene.configure_default_lights(cast_shadow=False)
        self._headline = self.gui.add_markdown(HEADLINE.format(f"**{_plain(title)}**: waiting for the robot"))
        self._said = self.gui.add_markdown("")
        self._caption = self.gui.add_markdown("", visible=False)
        self.tabs = self.gui.add_tab_group()
        with self.tabs.add_tab("Charts"):
            self._verdict = self.gui.add_markdown("", visible=False)
            self._charts = Charts(self.gui)
        self._joints: JointView | None = None
        self._count = 0
        self._begin()

    def meet(self, body: Body) -> None:
        """The robot is of this body; all begins anew."""
        self.server.scene.reset()
        with self.server.atomic():
            self._scene = RobotScene(self.server, body, self._dark)
            if self._dragged is not None:
                self._scene.on_drag(self._dragged)
        self._observer = BalanceEstimator(body)
        self._watch = Symptoms(self._observer)
        self._history = History(KEPT)
        self._begin()

    def _begin(self) -> None:
        self.symptoms: list[Symptom] = []
        self.diagnosis: Diagnosis | None = None
        self._newest: Balance | None = None
        self._recent: deque[Moment] = deque(maxlen=JOINT_ROWS)

    def add_view_tab(self) -> None:
        """Add what changes the picture only."""
        with self.tabs.add_tab("View"):
            follow = self.gui.add_checkbox("follow the robot", initial_value=True)
            ghost = self.gui.add_checkbox("ghost (as its sensors say)", initial_value=True)
            through = self.gui.add_checkbox("see through", initial_value=True)
            dark = self.gui.add_checkbox("dark", initial_value=True)
            with self.gui.add_folder("Charts"):
                shown = [self.gui.add_checkbox(c.title, initial_value=c in self._charts.chosen) for c in CHARTS]
            self.gui.add_markdown(legend())

        def choose_charts(_: object) -> None:
            self._charts.choose([chart for chart, box in zip(CHARTS, shown, strict=True) if box.value])

        for box in shown:
            box.on_update(choose_charts)

        def choose(_: object) -> None:
            if self._scene is not None:
                self._scene.follow, self._scene.ghost = follow.value, ghost.value

        def see_through(_: object) -> None:
            if self._scene is not None:
                self._scene.see_through(through.value)

        dark.on_update(lambda _: self._dress(dark=dark.value))
        through.on_update(see_through)
        follow.on_update(choose)
        ghost.on_update(choose)

    def _dress(self, dark: bool) -> None:
        self._dark = dark
        self.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)
        if self._scene is not None:
            self._scene.ground.dress(dark)

    def add_joint_tab(self) -> Any:
        """Add the table and the plot of the joints; returns the tab."""
        self._joints = JointView(self.gui, self.tabs)
        return self._joints.tab

    def show_joints(self, moments: Sequence[Moment], now: bool = False) -> None:
        """The joints of the last of some moments, drawn every so often, or `now`."""
        if self._joints is not None:
            self._joints.show(moments, now)

    @property
    def walks(self) -> bool:
        """Whether a walker has said anything of the newest moment."""
        return self._newest is not None and self._newest.moment.walk is not None

    def aim(self, impulse: tuple[float, float]) -> None:
        """Show for a while, by an arrow, the impulse of a push, N s, ahead and to the left of the robot."""
        if self._scene is not None:
            self._scene.arrow.aim(impulse)

    def on_drag(self, act: Dragged) -> None:
        """What is done when a person drags the robot; as of `PushArrow.on_drag`."""
        self._dragged = act
        if self._scene is not None:
            self._scene.on_drag(act)

    def say(self, text: str) -> None:
        """Tell the person what came of a button."""
        self._said.content = _answer(text)

    def caption(self, text: str) -> None:
        """Show a line over the picture, until another takes its place."""
        self._caption.content = f'<span class="nao-caption">{_plain(text)}</span>'
        self._caption.visible = True

    def take(self, moment: Moment) -> None:
        """The next moment, drawn or not."""
        balance = self._observer.update(moment)
        if self._newest is not None and moment.sensors.seq < self._newest.moment.sensors.seq:
            self._begin()
            self.forget()
        found = self._watch.update(balance)
        self.symptoms += found
        del self.symptoms[:-MOST]
        if any(s.kind == "fall" for s in found):
            last = self.diagnosis.fell if self.diagnosis else -1.0
            since = [s for s in self.symptoms if s.time > last]
            self.diagnosis = explain(since, torso_off=self._watch.torso_off) or self.diagnosis
        self._history.add(balance)
        self._recent.append(moment)
        self._newest = balance

    def forget(self) -> None:
        """Footprints go: what is shown next was before what is shown now."""
        if self._scene is not None:
            self._scene.marks.forget()

    def show(self) -> None:
        """Draw the newest moment, if anybody looks."""
        if self._newest is not None and self.server.get_clients():
            self.draw(self._newest, self._history, self.symptoms, self.diagnosis)
            self.show_joints(list(self._recent))

    def draw(
        self,
        balance: Balance,
        history: History,
        symptoms: list[Symptom],
        diagnosis: Diagnosis | None,
        now: bool = False,
        ahead: float = 0.0,
    ) -> None:
        """Draw a moment; the charts every so often, or `now`, with so much of what comes after it (s)."""
        if self._scene is None:
            return
        with self.server.atomic():
            self._scene.draw(balance)
        self._count += 1
        if self._count % CHART_EVERY == 0 or now:
            time = balance.moment.sensors.time
            first = diagnosis.first if diagnosis else None
            self._charts.draw(history, time, symptoms, first, ahead)
            title, *rest = verdict(diagnosis).split("\n\n") if diagnosis is not None else ("",)
            lies = diagnosis is None or not walks_again(balance.moment, diagnosis)
            head = HEADLINE.format(headline(self._title, balance))
            self._headline.content = f"{head}\n\n{title}" if lies else head
            self._verdict.content = "\n\n".join(rest if lies else [f"**{title.strip('# ')}**", *rest])
            self._verdict.visible = bool(rest)

    def set_world(self, world: WorldReply) -> None:
        """The world is like this."""
        if self._scene is None:
            return
        floor = GroundPlane(*world.floor, 0.0)
        self._observer.ground = floor
        with self.server.atomic():
            self._scene.ground.set_floor(floor)
            self._scene.ground.set_objects(world.objects)
            if world.terrain is not None:
                self._scene.ground.set_terrain(world.terrain)


def _aim(client: Any) -> None:
    client.camera.position, client.camera.look_at = CAMERA


def headline(title: str, balance: Balance) -> str:
    """What is going on, in markdown."""
    frame, walk = balance.moment.sensors, balance.moment.walk
    words = [f"**{_plain(title)}**", f"{frame.time:.1f} s"]
    if walk is not None:
        of = f" of {walk.steps}" if walk.steps else ""
        words += [walk.state] if walk.phase == walk.state else [walk.state, walk.phase]
        words += [f"step {walk.step}{of}"] if walk.step else []
    words += [f"cycles missed: {frame.missed}"] if frame.missed else []
    return " · ".join(words)


def walks_again(moment: Moment, diagnosis: Diagnosis) -> bool:
    """Whether the robot got up after its fall and walks."""
    late = moment.sensors.time > diagnosis.fell + AGAIN
    return late and moment.walk is not None and moment.walk.state == "walk"


def verdict(diagnosis: Diagnosis) -> str:
    """Why it fell, for somebody who has never seen the project, in markdown."""
    fell = f"It fell at {diagnosis.fell:.2f} s."
    if diagnosis.first is None:
        return f"#### {fell} There was no sign before."
    meaning = MEANING[diagnosis.first.kind]
    if diagnosis.torso_off:
        meaning += " The torso control was off."
    return "\n\n".join(
        [
            f"#### {fell} What went wrong first: {_plain(diagnosis.first.text)}",
            meaning,
            " → ".join(_chain(diagnosis)),
        ]
    )


def _chain(diagnosis: Diagnosis) -> list[str]:
    """The first sign, what was done before it, and the last signs up to the fall; dots for what is left out."""
    chain = diagnosis.chain
    kept = [i for i, s in enumerate(chain) if s in (diagnosis.before, diagnosis.first)]
    last = [i for i in range(len(chain)) if i not in kept]
    kept = sorted(kept + last[max(len(last) - CHAIN + len(kept), 0) :])
    words: list[str] = []
    for before, i in zip([-1, *kept], kept, strict=False):
        if i > before + 1:
            words.append("…")
        words.append(f"**{chain[i].time:.2f}\u00a0s** {_plain(chain[i].text)}")
    return words


def legend() -> str:
    """What the colours mean, in markdown."""
    dots = [f'<span style="color: rgb{p.colour}">●</span> **{p.label}**: {p.meaning}' for p in POINTS]
    return "\n\n".join([*dots, *LEGEND])


def _answer(text: str) -> str:
    return f"▸ {_plain(text)}"


def _plain(text: str) -> str:
    """Text that markdown takes as it is."""
    return html.escape(text, quote=False).replace("*", "").replace("_", "-")
