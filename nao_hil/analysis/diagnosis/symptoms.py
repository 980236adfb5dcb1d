"""Signs of trouble in a walk, each with the time it began.

The bounds are set from recorded walks: an untroubled gait's every step, feet on their edges and a
capture point outside the support polygon for a moment included, is no symptom.
"""

from __future__ import annotations

import math
from typing import Final, Literal, NamedTuple

import numpy as np

from bridge.body.fall import has_fallen
from bridge.body.joints import JOINTS, LEGS
from bridge.messages.frames import ORDER
from bridge.types import SIDES, Side
from nao_hil.analysis.diagnosis.balance import Balance, BalanceEstimator, Stand
from nao_hil.runs.walk_figures import FallWatch

Kind = Literal["world", "order", "limp", "missed", "zmp", "slip", "late", "early", "tilt", "fall"]
OUTSIDE: Final = ("world", "order", "fall")
"""Kinds that are no sign of trouble in the robot: done by the world, ordered, and the fall itself."""
CAUSES: Final = ("world", "limp", "missed")
"""Kinds that are done to the robot and make it fall; its own signs follow from them."""
EVENT_CODES: Final[dict[str, Kind]] = {
    "world": "world",
    "fault": "world",
    ORDER: "order",
    "guard-stop": "order",
    "guard-armed": "order",
}
"""Code of a notice -> kind of its event."""
EDGE: Final = 0.003
"""Margin under which the zero moment point is at the edge of the support polygon, m."""
LOST: Final = 0.03
"""Distance of the capture point beyond the polygon from which the feet alone do not bring it back, m."""
GAP: Final = 0.05
"""Interruption that does not end a sign, s."""


class Symptom(NamedTuple):
    """Sign of a fall, or a disturbance from outside."""

    time: float
    """When it began, robot time, s."""
    kind: Kind
    text: str
    """Text for people, without the time."""
    counted: float = -math.inf
    """When it had lasted long enough to be one, s; not known: when it began."""


class LastingSign:
    """A condition that must last before it counts, and counts once until it has ended."""

    def __init__(self, lasting: float) -> None:
        self._lasting = lasting
        self._began: float | None = None
        self._seen = 0.0
        self._reported = False

    def update(self, time: float, present: bool) -> float | None:
        """The time it began, in the cycle in which it has lasted long enough; None otherwise."""
        if present:
            if self._began is None:
                self._began = time
            self._seen = time
        elif self._began is not None and time - self._seen > GAP:
            self._began, self._reported = None, False
        if self._began is None or self._reported or self._seen - self._began < self._lasting - 1e-9:
            return None
        self._reported = True
        return self._began


class TippingSign:
    """The zero moment point is pinned to the edge and the capture point runs away beyond it."""

    def __init__(self, lasting: float) -> None:
        self._edge = LastingSign(0.0)
        self._lost = LastingSign(lasting)
        self._began = 0.0

    def update(self, time: float, stand: Stand) -> float | None:
        """Time at which the zero moment point reached the edge, once it is a symptom."""
        at_edge = stand.margin is None or stand.margin < EDGE
        beyond = stand.support is not None and stand.support.margin(stand.capture) < 0.0
        began = self._edge.update(time, at_edge and beyond)
        if began is not None:
            self._began = began
        lost = stand.support is not None and stand.support.margin(stand.capture) < -LOST
        return self._began if self._lost.update(time, lost and at_edge) is not None else None


def lean_angle(balance: Balance) -> float:
    """Angle of the torso from the vertical, rad."""
    return math.acos(min(max(float(balance.best.robot.frames[0][2, 2]), -1.0), 1.0))


def fallen(balance: Balance, lean: float) -> bool:
    """Whether the robot is beyond help: by the ground truth, else by its lean (rad) or its walker's word."""
    if balance.cycle.truth is not None:
        return balance.cycle.truth.fell
    walk = balance.cycle.walk
    return has_fallen(lean) or (walk is not None and walk.state == "fallen")


MEANING: Final[dict[Kind, str]] = {
    "limp": "The motor of a joint is off while the others hold, so the joint gives way under the robot.",
    "zmp": "The ground pushes back at the very edge of the feet, and the robot begins to tip over that edge.",
    "slip": "A foot that bears weight slides over the ground, so the robot is not where its plan has it.",
    "late": "The foot is still in the air when the plan already puts weight on it.",
    "early": "The foot meets the ground too soon, and the ground pushes the robot off its way.",
    "missed": "No commands came in time: the joints held their last ones in mid-motion.",
    "tilt": "The torso leans further than this walk ever does when it goes well.",
}
"""Meaning of a symptom, for a first reader."""
TIPPING: Final = {True: 0.1, False: 0.2}
"""How long it stays there in a symptom, s, by the ground truth and by the sensors: an untroubled dynamic gait
comes to 0.06 and 0.19 s."""
SLIP_SPEED: Final = 0.1
"""Speed of the loaded part of a sole over the ground, m/s; rolling over an edge reaches 0.08 in a good walk."""
SLIP_TIME: Final = 0.05
"""Time of slipping that counts, s."""
LOADED: Final = 12.0
"""Vertical force under which a foot that moves does not count as slipping, N."""
LATE_TIME: Final = 0.15
"""After the planned touch-down, s."""
LATE_HEIGHT: Final = 0.005
"""Height over the other sole under which a foot without load is not late but only unloaded, m."""
EARLY_HEIGHT: Final = 0.004
"""Planned height over which a touch-down is early, m."""
EARLY_TIME: Final = 0.05
"""Time before the planned touch-down that counts, s."""
TILT: Final = math.radians(12.0)
"""Tilt of the torso from the vertical, more than an untroubled walk of a nominal robot."""
MISSED: Final = 5
"""Cycles without an answer within `MISSED_TIME`."""
MISSED_TIME: Final = 0.2
"""Time without a command that counts, s."""
LIMP: Final = (0.1, 0.5)
"""Stiffness under which a leg joint is limp, and over which another one must be."""
STARTING: Final = 0.5
"""Time after a start in which cycles that a controller misses are no sign of anything: it is only coming, s."""
UNUSED: Final = 1.0
"""Time of a walk in which a torso control that corrects nothing at all counts as off, s."""


class Symptoms:
    """Watches a robot cycle by cycle.

    Args:
        observer: The one that makes the balances: it knows the body.
    """

    def __init__(self, observer: BalanceEstimator) -> None:
        self._kinematics, self._cycle = observer.kinematics, observer.body.cycle
        self._begin()

    def _begin(self) -> None:
        self._last: Balance | None = None
        self._tipping = {known: TippingSign(lasting) for known, lasting in TIPPING.items()}
        self._slip: dict[Side, LastingSign] = {side: LastingSign(SLIP_TIME) for side in SIDES}
        self._late: dict[Side, LastingSign] = {side: LastingSign(LATE_TIME) for side in SIDES}
        self._early: dict[Side, LastingSign] = {side: LastingSign(EARLY_TIME) for side in SIDES}
        self._flown: dict[Side, bool] = {side: False for side in SIDES}
        self._tilt, self._pause = LastingSign(0.0), LastingSign(0.0)
        self._limp = {slot: LastingSign(0.0) for slot in LEGS}
        self._watch = FallWatch()
        self._missed: list[tuple[float, int]] = []
        self._lies = False
        self._controlled = -math.inf
        self._walked: tuple[float, float] | None = None

    @property
    def torso_off(self) -> bool:
        """Whether the last walk did without torso control, by its walker's word."""
        if self._walked is None:
            return False
        began, last = self._walked
        return last - max(self._controlled, began) > UNUSED

    def update(self, balance: Balance) -> list[Symptom]:
        """New symptoms in this cycle."""
        if self._last is not None and balance.cycle.sensors.seq < self._last.cycle.sensors.seq:
            self._begin()
        self._note_control(balance)
        signs = [
            *self._world(balance),
            *self._limp_joints(balance),
            *self._missing(balance),
            *self._balance(balance),
            *(s for side in SIDES for s in self._foot(balance, side)),
            *self._posture(balance),
        ]
        if self._lies:  # motions of a robot that lies are no symptom
            signs = [s for s in signs if s.kind in ("world", "order")]
        signs = [s._replace(counted=balance.cycle.sensors.time) for s in signs]
        lean = lean_angle(balance)
        self._lies = fallen(balance, lean) or (self._lies and lean > TILT)
        self._last = balance
        return signs

    def _note_control(self, balance: Balance) -> None:
        """When the torso control last did something in a walk."""
        walk, time = balance.cycle.walk, balance.cycle.sensors.time
        if walk is None or walk.state not in ("walk", "stopping"):
            return
        if self._walked is None or time - self._walked[1] > UNUSED:
            self._walked = time, time
        self._walked = self._walked[0], time
        if any(walk.torso_control):
            self._controlled = time

    def _world(self, balance: Balance) -> list[Symptom]:
        time = balance.cycle.sensors.time
        return [
            Symptom(time, EVENT_CODES[notice.code], notice.text.rstrip("."))
            for notice in balance.cycle.notices
            if notice.code in EVENT_CODES
        ]

    def _limp_joints(self, balance: Balance) -> list[Symptom]:
        frame = balance.cycle.sensors
        off, on = LIMP
        holds = max(frame.stiffness[slot] for slot in self._limp) > on
        limp = [
            JOINTS[slot]
            for slot, sign in self._limp.items()
            if sign.update(frame.time, holds and frame.stiffness[slot] < off) is not None
        ]
        return [Symptom(frame.time, "limp", f"{', '.join(limp)} went limp")] if limp else []

    def _missing(self, balance: Balance) -> list[Symptom]:
        frame = balance.cycle.sensors
        if frame.time < STARTING:
            return []
        walk, age = balance.cycle.walk, frame.seq - frame.command if frame.command >= 0 else 0
        paused = age > MISSED and walk is not None and walk.state in ("walk", "stopping")
        if self._pause.update(frame.time, paused) is not None:
            return [Symptom(frame.time - age * self._cycle, "missed", "no more commands came")]
        if paused:
            return []
        self._missed = [(t, n) for t, n in self._missed if frame.time - t <= MISSED_TIME]
        self._missed.append((frame.time, frame.missed))
        time, before = self._missed[0]
        if frame.missed - before < MISSED:
            return []
        self._missed = []
        return [Symptom(time, "missed", f"the controller missed {frame.missed - before} cycles")]

    def _balance(self, balance: Balance) -> list[Symptom]:
        began = self._tipping[balance.true is not None].update(balance.cycle.sensors.time, balance.best)
        return [] if began is None else [Symptom(began, "zmp", "the ZMP left the support polygon")]

    def _foot(self, balance: Balance, side: Side) -> list[Symptom]:
        signs = []
        time, word = balance.cycle.sensors.time, {"L": "left", "R": "right"}[side]
        slipping = self._slip[side].update(time, self._slip_speed(balance, side) > SLIP_SPEED)
        if slipping is not None:
            signs.append(Symptom(slipping, "slip", f"the {word} foot slipped"))
        plan, walk = balance.plan, balance.cycle.walk
        if plan is None or walk is None or walk.state not in ("walk", "stopping"):
            return signs
        touches, lift = balance.best.contacts.of(side), plan.lift[side]
        due = max(plan.lift.values()) < 1e-4
        late = self._late[side].update(time, due and not touches and self._height(balance, side) > LATE_HEIGHT)
        if late is not None:
            signs.append(Symptom(late, "late", f"the {word} foot touched down late"))
        swings = lift > EARLY_HEIGHT
        self._flown[side] = swings and (self._flown[side] or not touches)
        early = self._early[side].update(time, self._flown[side] and touches)
        if early is not None:
            signs.append(Symptom(early, "early", f"the {word} foot touched down early"))
        return signs

    def _slip_speed(self, balance: Balance, side: Side) -> float:
        """Speed over the ground of the point of the sole that bears the load, m/s; 0 without ground truth."""
        last, now = self._last, balance
        if last is None or last.true is None or now.true is None or now.cycle.truth is None:
            return 0.0
        contact = now.cycle.truth.left if side == "L" else now.cycle.truth.right
        dt = now.cycle.sensors.time - last.cycle.sensors.time
        if contact.cop is None or contact.force[2] < LOADED or dt <= 0.0:
            return 0.0
        point = np.array([*contact.cop, self._kinematics.centres[side][2], 1.0])
        way = (now.true.robot.feet[side] - last.true.robot.feet[side]) @ point
        return float(np.hypot(way[0], way[1])) / dt

    def _height(self, balance: Balance, side: Side) -> float:
        """Height of a sole's lowest corner over that of the other sole, m."""
        feet = balance.best.robot.feet
        low = {s: float(self._kinematics.sole_in_world(s, feet[s])[:, 2].min()) for s in SIDES}
        return low[side] - min(low.values())

    def _posture(self, balance: Balance) -> list[Symptom]:
        time = balance.cycle.sensors.time
        lean = lean_angle(balance)
        signs = []
        if (tilted := self._tilt.update(time, lean > TILT)) is not None:
            signs.append(Symptom(tilted, "tilt", f"the torso tilted over {math.degrees(TILT):.0f}°"))
        if balance.cycle.walk is not None:
            self._watch.telemetry(balance.cycle.walk)
        for notice in balance.cycle.notices:
            self._watch.notice(notice)
        if self._watch.update(down=fallen(balance, lean)):
            signs.append(Symptom(time, "fall", "the robot fell"))
        return signs
