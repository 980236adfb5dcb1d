"""ALRobotPosture, and ALMotion's waking and resting: the published postures, and the motions between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from typing import Annotated, Any, Final, Literal

from bridge.adapters.naoqi.core.joints import slot
from bridge.adapters.naoqi.core.motion_tasks import MotionTask
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import Fraction, OneOf, offers
from bridge.body.joints import INDEX_WITH_MIRROR, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import HANDS
from bridge.errors import NaoqiRefused
from bridge.motion import GetUp, Motion, MotionPlayer, get_up_motions, lying, motion_for
from bridge.stance import stands

Family = Literal["Standing", "Sitting", "LyingBelly", "LyingBack", "Unknown"]
_LYING_FAMILIES: Final[dict[str, Family]] = {"front": "LyingBelly", "back": "LyingBack"}
_TRANSITIONS: Final[dict[str, tuple[Family, str]]] = {
    "Sitting": ("Standing", "sit-down"),
    "LyingBelly": ("Standing", "lie-down-front"),
    "LyingBack": ("Sitting", "lie-down-back"),
}
"""Family -> the family before it, and the motion from there; all ways lead through a stand."""


FAMILIES: Final[dict[str, Family]] = {
    "Stand": "Standing",
    "StandInit": "Standing",
    "StandZero": "Standing",
    "Crouch": "Standing",
    "Sit": "Sitting",
    "SitRelax": "Sitting",
    "LyingBelly": "LyingBelly",
    "LyingBack": "LyingBack",
}
"""Posture -> its family: standing, sitting or lying."""
LEG_SPEED: Final = 1.0
"""rad/s of a leg joint between postures at most, at speed 1: the robot tips over at faster ones (the robot's
own planner is not published; assumed)."""
_SIT_LEG_SPEED: Final = 0.3
"""rad/s, the same into `Sit` at any speed: with its knees up an emulated robot leans back by 20 degrees, and
tips over from 25 on."""
_MAX_DEVIATION: Final = 0.25
"""Largest deviation of the legs from a posture, rad (assumed)."""
_STIFFEN_TIME: Final = 0.5
"""Duration of a change of the stiffness by waking and resting, s."""
_SETTLE_TIME: Final = 300
"""ms from a command to its measurement (assumed)."""
_MAX_STILL_RATE: Final = 0.1
"""rad/s; the torso may be falling if it turned faster within the last `_SETTLE_TIME` (assumed)."""
_MAX_SETTLE_TIME: Final = 3000
"""ms after which the posture is judged in any motion: a fall takes less."""
REST_SPEED: Final = 0.6
REST_STIFFNESS: Final = 0.1
"""Stiffness of the legs at rest; all else gets 0, as all does on the robot. Without it, knees and ankles rest
at the ends of their ranges, and the torso turns backwards about the limp hips within 4 s (V5 and V6 on
PyBullet, V3 on MuJoCo). From 0.05 on it stays, as it does with twice the assumed dry friction (V5 on
PyBullet)."""
_LEGS: Final = tuple(j for j in INDEX_WITH_MIRROR if j[1:].startswith(("Hip", "Knee", "Ankle")))


Posture = Annotated[str, OneOf("posture", POSTURES)]


class Postures(Service):
    """Postures of one robot."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        joints = self._joints
        self.leaning = False
        """The torso leans because of a transition, which is no fall."""
        self._all = joints.names.all
        self.awake = all(joints.stiffness(joint) > 0.0 for joint in self._all)
        """Whether the last of waking and resting is waking."""

    @offers("ALRobotPosture.getPosture")
    def now(self) -> str:
        """The robot's posture by legs and fused angle, or `Unknown`."""
        best, off = "Unknown", _MAX_DEVIATION
        for name in POSTURES:
            furthest = self._deviation(name)
            if furthest <= off and FAMILIES[name] == self._legs_family():
                best, off = name, furthest
        return best

    @offers("ALRobotPosture.getPostureFamily")
    def family(self) -> str:
        """The family of `now`, or `Unknown`."""
        posture = self.now()
        return "Crouching" if posture == "Crouch" else FAMILIES.get(posture, "Unknown")

    @offers("ALRobotPosture.goToPosture", kind="posture")
    def go_to(self, name: Posture, speed: Fraction) -> Future[Any]:
        """Move to a posture: get up, sit down or lie down, then joint by joint; true: the robot rests in it."""
        way = self._play_all(self._players(FAMILIES[name]), FAMILIES[name])

        def task() -> MotionTask:
            if not (yield from way):
                return False
            self.awake = True
            return (yield from self._stiffen_and_reach(name, speed))

        return self._tasks.begin(task(), "goToPosture", self._all, locks=True, stopped=False)

    @offers("ALRobotPosture.applyPosture", kind="posture")
    def apply(self, name: Posture, speed: Fraction) -> Future[Any]:
        """Move the joints to a posture's angles from any pose; true: they are reached."""
        task = self._stiffen_and_reach(name, speed)
        return self._tasks.begin(task, "applyPosture", self._all, locks=True, stopped=False)

    @offers("ALMotion.wakeUp", kind="posture")
    def wake_up(self) -> Future[Any]:
        """Switch the stiffness on, and stand up from a crouch."""

        def task() -> MotionTask:
            yield from self._stiffen(1.0, legs=1.0)
            self.awake = True
            if self.now() == "Crouch":
                yield from self._reach("StandInit", REST_SPEED)

        return self._announced("wakeUp", task(), self._all)

    @offers("ALMotion.rest", kind="posture")
    def rest(self, part: Any = "Body") -> Future[Any]:
        """Crouch, if the robot is upright, and switch the stiffness off; without legs only the latter."""
        joints = self._joints.names.resolve(part)
        if not set(joints) & set(_LEGS):
            limp = self._motion.stiffen(joints, [[0.0]] * len(joints), [[_STIFFEN_TIME]] * len(joints))
            return self._announced("rest", limp, joints)

        def task() -> MotionTask:
            if self._legs_family() == "Standing" and self.now() != "Crouch":
                yield from self._reach("Crouch", REST_SPEED)
            yield from self._stiffen(0.0, legs=REST_STIFFNESS)
            self.awake = False

        return self._announced("rest", task(), self._all)

    def _announced(self, name: str, task: MotionTask, joints: Sequence[str]) -> Future[Any]:
        """Begin a task, with events of its beginning and its end: `<name>Started` and `<name>Finished`."""
        done = self._tasks.begin(task, name, joints)
        self._events.raise_event(f"ALMotion/Stiffness/{name}Started", True)
        finished = f"ALMotion/Stiffness/{name}Finished"
        done.add_done_callback(lambda _: self._events.raise_event(finished, True))
        return done

    def _stiffen(self, value: float, legs: float) -> MotionTask:
        values = [[legs if joint in _LEGS else value] for joint in self._all]
        yield from self._motion.stiffen(self._all, values, [[_STIFFEN_TIME]] * len(self._all))

    def _stiffen_and_reach(self, posture: str, speed_fraction: float) -> MotionTask:
        """Stiffen limp joints and move; whether the robot is in the posture then, upright if it should be."""
        if min(self._joints.stiffness(joint) for joint in self._all) <= REST_STIFFNESS:
            yield from self._stiffen(1.0, legs=1.0)
            self.awake = True
        yield from self._reach(posture, speed_fraction)
        yield from self._settle()
        return self._deviation(posture) <= _MAX_DEVIATION and self._legs_family() == FAMILIES[posture]

    def _settle(self) -> MotionTask:
        """Wait until the torso is still."""
        begin = moved = self._joints.now
        while self._joints.now < min(moved + _SETTLE_TIME, begin + _MAX_SETTLE_TIME):
            if max(map(abs, self._joints.frame.gyroscope)) > _MAX_STILL_RATE:
                moved = self._joints.now
            yield self._joints.now + 1

    def _deviation(self, posture: str) -> float:
        """Largest measured deviation of a leg joint from a posture, rad."""
        position = POSTURES[posture]
        return max(abs(position[INDEX_WITH_MIRROR[j]] - self._joints.measured(j)) for j in _LEGS)

    def _reach(self, posture: str, speed_fraction: float) -> MotionTask:
        position = POSTURES[posture]
        targets = {j: position[INDEX_WITH_MIRROR[j]] for j in self._all}
        angles = (abs(targets[j] - self._joints.commanded(j)) for j in _LEGS if j in targets)
        speed = LEG_SPEED * speed_fraction
        slowest = max(angles) / (min(speed, _SIT_LEG_SPEED) if posture == "Sit" else speed)
        seconds = max(slowest, self._motion.time_to(self._all, list(targets.values()), speed_fraction))
        values = [[value] for value in targets.values()]
        yield from self._motion.interpolate(self._all, values, [[seconds]] * len(self._all))
        return True

    def _legs_family(self) -> Family:
        """Posture family by the fused angle and the legs; on a side `Unknown`."""
        frame = self._joints.frame
        lying_side = lying(frame.angle)
        if lying_side == "upright":
            return "Standing" if stands(self._joints.body, frame) else "Sitting"
        return _LYING_FAMILIES.get(lying_side, "Unknown")

    def _players(self, family: Family) -> list[GetUp | MotionPlayer]:
        """Remaining motions."""
        body, here = self._joints.body, self._legs_family()
        if here == family:
            return []
        if family == "Standing":
            motions = get_up_motions(body)
            if lying(self._joints.frame.angle) not in motions:
                raise NaoqiRefused(f"ALRobotPosture.goToPosture: no motion gets a {body.name} up from here.")
            return [GetUp(motions, body)]
        before, kind = _TRANSITIONS[family]
        motion: Motion | None = motion_for(kind, body)
        if motion is None:
            raise NaoqiRefused(
                f"ALRobotPosture.goToPosture: no motion brings a {body.name} from {before} to {family}; "
                "applyPosture moves the joints there as they are."
            )
        return [*self._players(before), MotionPlayer(motion, body)]

    def _play_all(self, players: list[GetUp | MotionPlayer], family: Family) -> MotionTask:
        try:
            for player in players:
                self.leaning = True
                yield from self._play(player)
                if player.failed:
                    break
        finally:
            self.leaning = False
        return self._legs_family() == family

    def _play(self, player: GetUp | MotionPlayer) -> Iterator[int]:
        joints, before = self._joints, self._joints.frame.time
        while True:
            frame = joints.frame
            position = list(player.advance(frame, frame.time - before))
            before = frame.time
            if player.done:
                return
            for hand in HANDS:
                position[slot(hand)] = frame.position[slot(hand)]
            joints.dcm.put_frame(position, (player.stiffness,) * N_JOINTS)
            yield joints.now

    _robot_is_wake_up = offers("ALMotion.robotIsWakeUp")(lambda self: self.awake)
    _get_posture_list = offers("ALRobotPosture.getPostureList")(lambda self: sorted(POSTURES))
