"""Answers walk commands: checks and prepares in the query's thread, hands over to the controller's tick.

Everything that takes time (the bounds of a gait, the design of a torso controller) is done before the command
is handed over. The controller then decides by its own state, at a tick, how to act on it; so in lockstep a
command with `at` gives the same run each time.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

import msgspec

from bridge.body import Body
from bridge.errors import ConfigurationError, WalkRefused
from bridge.messages import decode_command, encode
from bridge.messages.walk import WalkCommand, WalkStatus
from bridge.motion import GET_UP, GetUp, Lying, MotionPlayer, get_up_motions, named_motion
from bridge.types import Vec3
from bridge.validation import unknown_name
from walker.controller import Controller
from walker.gaits import GAITS, Gait, gait_parameters
from walker.gaits.catalogue import walkable_gait
from walker.gaits.gait import GaitParameters, clipped_in_words
from walker.gaits.order import WalkOrder, target_order
from walker.parameters import ControllerParameters, controller_parameters, merged
from walker.states.setup import WalkSetup, set_up_walk
from walker.switches import switch_changes

_REPLY_TIMEOUT: Final = 3.0
"""s to wait for the tick that takes a command over, so that the reply contains its effect."""
_NO_ROBOT: Final = (
    "The walker does not hold a robot yet; start one, arm it after an emergency stop (Arm on the page, or "
    "`nao-hil arm`), or ask again in a moment."
)
HANGS: Final = (
    "No foot feels the ground: the robot hangs, or its force sensors are dead; put it on its feet first."
)
_PAUSE: Final = 0.0005
"""Duration of `_pause`, s."""


class WalkRequest(NamedTuple):
    """Parameters of the next walk."""

    gait: str
    torso: str | None
    """None: the gait's own choice."""
    admittance: bool | None
    velocity: Vec3 | None
    """m/s, m/s, rad/s; None: the gait's own."""


class _Order(NamedTuple):
    at: int
    act: Callable[[Controller], None]
    taken: threading.Event


class _Snapshot(NamedTuple):
    status: WalkStatus
    lies: bool
    """Fell, and is not upright again."""
    hangs: bool
    """Stands, and no foot touches the ground."""
    lying_side: Lying
    """Side on which the robot lies."""
    motion_waits: bool
    """An ordered motion has not begun yet."""


class WalkService:
    """The walker's answers to `walk/command`.

    Args:
        gait: to begin with.
        parameters: of that gait that differ from the shipped ones.
        controller: parameters of its controllers that differ.
        recover: get up after a fall, see `Controller`.
        standby: leave the robot to others until a `take` command.

    Raises:
        ConfigurationError: a wrong parameter.
    """

    def __init__(
        self,
        gait: str,
        parameters: Mapping[str, Any] | None = None,
        controller: Mapping[str, Any] | None = None,
        *,
        recover: bool = False,
        standby: bool = False,
    ) -> None:
        self._wanted, self._held, self._released = threading.Event(), threading.Event(), threading.Event()
        """Set while the robot is to be held; while it is held; once it is released."""
        if not standby:
            self._wanted.set()
        self._first_gait, self._recover = gait, recover
        self._changes = dict(parameters or {})
        self._controller_changes = dict(controller or {})
        self._request = WalkRequest(gait, None, None, None)
        self._answer_lock = threading.Lock()
        self._orders_lock = threading.Lock()
        self._orders: list[_Order] = []
        self._due: list[_Order] = []
        self._notes: list[str] = []
        self._controllers_thread = 0
        self._robot: tuple[Body, float] | None = None
        self._snapshot: _Snapshot | None = None
        self._refusal = _NO_ROBOT
        self._bounded_by: str | None = None
        """Bound of the walk under way: `target` or `distance`."""
        self._played = ""
        """Name of the last motion."""
        self._walkable: dict[tuple[str, GaitParameters], Gait[Any]] = {}
        self._gait_parameters(self._request)
        self._controllers(self._request)

    def make(self, body: Body, cycle: float) -> Controller:
        """A controller that waits at a stand, for a robot that has begun; orders to an earlier one are dropped.

        Raises:
            ConfigurationError: this body cannot walk the gait.
        """
        with self._orders_lock:
            self._orders.clear()
            if self._robot != (body, cycle):
                self._walkable.clear()
            self._robot, self._snapshot, self._refusal = (body, cycle), None, _NO_ROBOT
            self._held.clear()
        gait = self._gait(self._request, self._gait_parameters(self._request))
        return Controller(body, gait, None, cycle, self._controllers(self._request), recover=self._recover)

    def lose_robot(self, why: str) -> None:
        """Refuse all commands until there is a robot again.

        Args:
            why: one sentence.
        """
        self._snapshot, self._refusal = None, why

    def before(self, controller: Controller, seq: int) -> None:
        """Carry out, before the tick of frame `seq`, the orders that are due; in the controller's thread."""
        with self._orders_lock:
            due = [order for order in self._orders if order.at <= seq]
            self._orders = [order for order in self._orders if order.at > seq]
        for order in due:
            order.act(controller)
        self._due = due

    def after(self, controller: Controller, seq: int) -> None:
        """Note the controller's state since the tick of frame `seq`; in the controller's thread."""
        walk, moving = controller.walk, controller.state in ("walk", "stopping")
        status = WalkStatus(
            text="",
            seq=seq,
            state=controller.state,
            gait=walk.gait.name,
            torso=walk.parameters.switches.torso,
            admittance=walk.parameters.switches.leg_admittance,
            velocity=walk.velocity if moving else (0.0, 0.0, 0.0),
            steps=controller.plan.step,
            distance=controller.walked,
            position=controller.odometry_pose,
            failure=controller.failure,
        )
        self._snapshot = _Snapshot(
            status,
            controller.lies,
            status.state == "stand" and controller.airborne,
            controller.lying_side,
            controller.motion_waits,
        )
        self._controllers_thread = threading.get_ident()
        self._held.set()
        for order in self._due:
            order.taken.set()

    @property
    def wanted(self) -> bool:
        """Whether the walker is to hold the robot."""
        return self._wanted.is_set()

    def wait_wanted(self, seconds: float) -> bool:
        """Wait until the walker is to hold the robot; whether it is."""
        return self._wanted.wait(seconds)

    def note_released(self) -> None:
        """Note that the robot is released."""
        self._released.set()

    def take_notes(self) -> list[str]:
        """Sentences on the orders since the last call that change what the walker does."""
        with self._orders_lock:
            notes, self._notes = self._notes, []
        return notes

    def _note(self, command: WalkCommand, state: str, text: str) -> None:
        """Note an order for the timeline; a keepalive, or another velocity of a walk under way, is none."""
        steers = command == WalkCommand(
            op=command.op, velocity=command.velocity, hold=command.hold, at=command.at
        )
        quiet = {"walk": steers and state == "walk", "set": steers, "stop": state in ("stand", "fallen")}
        if not quiet.get(command.op, command.op in ("status", "take")):
            with self._orders_lock:
                self._notes.append(text)

    def answer(self, payload: bytes) -> bytes:
        """A `bridge.messages.walk.WalkCommand` to a `WalkStatus`, both as msgpack; any thread.

        Raises:
            FrameError: not a walk command.
            WalkRefused: one that cannot be carried out; names the bound.
        """
        command: WalkCommand = decode_command(payload, WalkCommand, "Walk command")
        with self._answer_lock:
            try:
                state = self._snapshot.status.state if self._snapshot is not None else ""
                status = self._execute(command)
                self._note(command, state, status.text)
                return encode(status)
            except ConfigurationError as error:
                raise WalkRefused(_sentence(str(error))) from None

    def _execute(self, command: WalkCommand) -> WalkStatus:
        if command.op == "take":
            self._released.clear()
            self._wanted.set()
            self._held.wait(_REPLY_TIMEOUT)
        if self._robot is None or self._snapshot is None:
            raise WalkRefused(self._refusal)
        if command.op == "release":
            return self._release()
        if command.op in ("status", "take"):
            return self._reply("")
        if command.op == "stop" or command.velocity == (0.0, 0.0, 0.0):
            still = self._snapshot.status.state in ("stand", "fallen")
            self._hand_over(command.at, Controller.stop)
            return self._reply("Nothing is under way." if still else "Closes the feet and stands.")
        if command.op == "motion":
            return self._play(command)
        request = self._changed_request(command)
        if command.op == "set":
            return self._set(request, command)
        if self._snapshot.lies:
            raise WalkRefused("The robot fell; put it on its feet first, an emulated one with `stand-up`.")
        if self._snapshot.hangs:
            raise WalkRefused(HANGS)
        walk = self._prepare(request, command)
        self._request = request
        self._bounded_by = next((n for n in ("target", "distance") if getattr(command, n) is not None), None)
        hold = command.hold if command.hold is not None else math.inf
        self._hand_over(command.at, lambda controller: controller.begin(walk, hold))
        first = "Closes the feet first; then walks" if self._snapshot.status.state == "stopping" else "Walks"
        return self._reply(f"{first} {_description(walk)}{_clipped(command.velocity, walk)}.")

    def _release(self) -> WalkStatus:
        """Release the robot from a stand."""
        assert self._snapshot is not None
        reply = self._reply("The robot is free.")
        if reply.state in ("walk", "stopping"):
            raise WalkRefused("The robot walks; stop it before the walker gives it back.")
        self._wanted.clear()
        if not self._released.wait(_REPLY_TIMEOUT):
            raise WalkRefused("The walker still holds the robot; ask again in a moment.")
        self._held.clear()
        self._snapshot = None
        return reply

    def _play(self, command: WalkCommand) -> WalkStatus:
        assert self._robot is not None and self._snapshot is not None
        body, name, below = self._robot[0], command.motion, self._snapshot.lying_side
        player: GetUp | MotionPlayer
        if name is None:
            raise WalkRefused("`motion` takes the name of a motion, for example `sit-down`.")
        if name == GET_UP:
            motions = get_up_motions(body)
            begins, player = tuple(motions), GetUp(motions, body)
        else:
            motion = named_motion(name, body, (GET_UP,))
            begins, player = motion.begins, MotionPlayer(motion, body)
        if self._snapshot.status.state == "motion":
            raise WalkRefused(f"A motion is under way; order {name} when it has ended.")
        if below not in begins:
            raise WalkRefused(f"No motion `{name}` of a {body.name} begins with the torso as it is: {below}.")
        if self._snapshot.status.state == "rest" and name == self._played:
            return self._reply(f"The robot rests where the motion {name} ended.")
        instead = f" in place of {self._played}" if self._snapshot.motion_waits else ""
        self._played = name
        self._hand_over(command.at, lambda controller: controller.play(player))
        return self._reply(f"Plays the motion {name}{instead}; from a walk it closes the feet first.")

    def _set(self, request: WalkRequest, command: WalkCommand) -> WalkStatus:
        assert self._snapshot is not None
        if any(each is not None for each in (command.steps, command.distance, command.target)):
            raise WalkRefused("`set` begins no walk: steps, distance and target belong to `walk`.")
        if (hold := command.hold) is not None:
            self._hand_over(command.at, lambda controller: controller.extend_hold(hold))
            if msgspec.structs.replace(command, at=None) == WalkCommand(op="set", hold=hold):
                return self._reply("")
        if self._bounded_by and command.velocity and self._snapshot.status.state == "walk":
            raise WalkRefused(
                f"A walk with a {self._bounded_by} is under way, its steps made to fit; stop it to change its "
                "velocity."
            )
        walk = self._prepare(request, command)
        self._request = request
        self._hand_over(command.at, lambda controller: controller.adjust(walk))
        text = f"{_description(walk)}{_clipped(command.velocity, walk)}"
        return self._reply(f"The next walk is {text}; the changes possible in stride are in force now.")

    def _changed_request(self, command: WalkCommand) -> WalkRequest:
        """The last request, changed by a command; another gait resets controllers and velocity to its own."""
        request = self._request
        if command.gait is not None and command.gait != request.gait:
            if command.gait not in (*GAITS, self._first_gait):
                # a sheet names files of the walker's machine, which its user chooses, not the link
                known = (*GAITS, self._first_gait)
                raise WalkRefused(_sentence(unknown_name("gait", command.gait, dict.fromkeys(known))))
            request = WalkRequest(command.gait, None, None, None)
        if command.torso is not None:
            request = request._replace(torso=command.torso)
        if command.admittance is not None:
            request = request._replace(admittance=command.admittance)
        if command.velocity is not None:
            request = request._replace(velocity=command.velocity)
        return request

    def _prepare(self, request: WalkRequest, command: WalkCommand) -> WalkSetup:
        """A walk with all its parts that take time to make."""
        assert self._robot is not None
        body, cycle = self._robot
        parameters = self._gait_parameters(request)
        gait = self._gait(request, parameters)
        step, order = parameters.periodic_step, _steps(command.steps or 0)
        if parameters.limits is not None:
            order = _with_target(order, command, parameters)
        elif command.target is not None:
            raise WalkRefused(f"The {request.gait} gait walks straight ahead; a target takes the gait `omni`.")
        elif command.distance is not None:
            if not step.length:
                raise WalkRefused(f"The {request.gait} gait stays where it is; leave the distance out.")
            count = math.ceil(command.distance / step.length - 1e-9)
            order = _steps(min(command.steps or count + 1, count + 1))
            parameters = parameters.with_velocity((command.distance / count / step.duration, 0.0, 0.0))
            gait = self._gait(request, parameters)
            step = parameters.periodic_step
        controllers = self._controllers(request)
        return set_up_walk(body, gait, order, cycle, controllers, step, parameters.velocity)

    def _gait_parameters(self, request: WalkRequest) -> GaitParameters:
        parameters = gait_parameters(request.gait, self._changes if request.gait == self._first_gait else None)
        if request.velocity is not None:
            parameters = parameters.with_velocity(request.velocity)
        return parameters

    def _controllers(self, request: WalkRequest) -> ControllerParameters:
        own = dict(self._controller_changes) if request.gait == self._first_gait else {}
        changes = switch_changes(torso=request.torso, admittance=request.admittance)
        return controller_parameters(request.gait, merged(own, changes))

    def _gait(self, request: WalkRequest, parameters: GaitParameters) -> Gait[Any]:
        """The gait; refuses one that the body cannot walk, and checks each walk once."""
        assert self._robot is not None
        body, known = self._robot[0], (request.gait, parameters)
        if known not in self._walkable:
            self._walkable[known] = walkable_gait(request.gait, parameters, body, _pause)
        return self._walkable[known]

    def _hand_over(self, at: int | None, act: Callable[[Controller], None]) -> None:
        assert self._snapshot is not None
        order = _Order(at or 0, act, threading.Event())
        with self._orders_lock:
            self._orders.append(order)
        own = threading.get_ident() == self._controllers_thread  # it would wait for itself
        if order.at <= self._snapshot.status.seq + 1 and not own:
            order.taken.wait(_REPLY_TIMEOUT)

    def _reply(self, text: str) -> WalkStatus:
        """State of the controller; at rest with the parameters of the next walk."""
        assert self._snapshot is not None
        status = self._snapshot.status
        if status.state in ("stand", "fallen"):
            on = self._controllers(self._request).switches
            status = msgspec.structs.replace(
                status, gait=self._request.gait, torso=on.torso, admittance=on.leg_admittance
            )
        ended = f"; the last walk ended: {status.failure}" if status.failure else ""
        return msgspec.structs.replace(status, text=text or f"The robot is in state `{status.state}`{ended}.")


def _pause() -> None:
    """Between two poses of the check: else the controller waits for Python's lock and misses cycles."""
    time.sleep(_PAUSE)


def _steps(steps: int) -> WalkOrder:
    if steps == 1:
        raise WalkRefused("A walk has at least 2 steps, one out and one to close the feet; 1 was asked for.")
    return WalkOrder(steps=steps)


def _with_target(order: WalkOrder, command: WalkCommand, parameters: GaitParameters) -> WalkOrder:
    """The order of a walk to a place, or over a distance along a velocity; as fast as the velocity."""
    target, (x, y, turn) = command.target, parameters.velocity
    if command.distance is not None:
        speed = math.hypot(x, y)
        if target is not None:
            raise WalkRefused("A walk has a target or a distance, not both.")
        if turn or not speed:
            raise WalkRefused(
                f"A distance takes a velocity without a turn, not {x:g} m/s, {y:g} m/s and {turn:g} rad/s; a "
                "target takes any."
            )
        target = (command.distance * x / speed, command.distance * y / speed, 0.0)
    return order if target is None else target_order(order, target, parameters)


def _description(walk: WalkSetup) -> str:
    assert walk.step is not None
    order, gait = walk.order, f"by the {walk.gait.name} gait"
    bound = f"{order.steps} steps" if order.steps else ""
    if order.target is not None:
        place = "to {:.3g} m ahead, {:.3g} m to the left, {:.3g} rad".format(*order.target)
        return ", ".join(filter(None, (f"{gait} at {order.share:.0%} of its limits", place, bound)))
    x, y, turn = walk.velocity
    speed = f"{x:.3f} m/s" if y == turn == 0.0 else f"{x:.3f} m/s, {y:.3f} m/s to the left, {turn:.3f} rad/s"
    return f"{gait} at {speed}, {bound or 'until it is told to stop'}"


def _clipped(wanted: Vec3 | None, walk: WalkSetup) -> str:
    """Sentence part on the velocity cut off by the gait's limits."""
    lost = clipped_in_words(wanted or walk.velocity, walk.velocity)
    return f"; {lost}" if lost else ""


def _sentence(text: str) -> str:
    """The text with a capital and a full stop."""
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."
