"""A guard with a robot of ideal joints behind it."""

from __future__ import annotations

from bridge.body import load_body
from bridge.body.joints import LEG_SLOTS, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.guard import Guard, GuardSettings
from bridge.messages import ActuatorFrame, SensorFrame
from tests.frames import standing_frame

BODY = load_body("nao-v3")
STAND = POSTURES["StandInit"]
SETTINGS = GuardSettings()
LEGS = sorted({slot for slots in LEG_SLOTS.values() for slot in slots})


def sensors(
    seq: int,
    position: tuple[float, ...] = STAND,
    angle: tuple[float, float] = (0.0, 0.0),
    heat: float = 30.0,
    charge: float = 1.0,
    stiffness: float = 1.0,
) -> SensorFrame:
    return standing_frame(
        seq,
        position=position,
        stiffness=(stiffness,) * N_JOINTS,
        temperature=(heat,) * N_JOINTS,
        angle=angle,
        battery=(charge, 0.0, 0.0, 25.0),
    )


def command(
    seq: int, position: tuple[float, ...] = STAND, stiffness: float = 1.0, lease: int = 1
) -> ActuatorFrame:
    return ActuatorFrame(reply_to=seq, position=position, stiffness=(stiffness,) * N_JOINTS, lease=lease)


class Robot:
    """Ideal joints: in the next cycle they are where they were asked to be, if they are stiff."""

    def __init__(self, guard: Guard, position: tuple[float, ...] = STAND, stiffness: float = 1.0) -> None:
        self.guard, self.seq = guard, 0
        self.position, self.stiffness = position, stiffness
        self.angle, self.heat, self.charge = (0.0, 0.0), 30.0, 1.0

    def cycle(self, wanted: ActuatorFrame | None, *, supervised: bool = True) -> ActuatorFrame | None:
        frame = sensors(self.seq, self.position, self.angle, self.heat, self.charge, self.stiffness)
        checked = self.guard.check(wanted, self.seq) if wanted is not None else None
        given = self.guard.cycle(frame, checked, supervised=supervised)
        if given is not None:
            moves = [stiffness > 0.0 for stiffness in given.stiffness]
            pairs = zip(given.position, self.position, moves, strict=True)
            self.position = tuple(new if stiff else old for new, old, stiff in pairs)
            self.stiffness = given.stiffness[LEGS[0]]
        self.seq += 1
        return given

    def command(self, position: tuple[float, ...] = STAND, lease: int = 1) -> ActuatorFrame | None:
        return self.cycle(command(self.seq, position, lease=lease))

    def silence(self, cycles: int, *, supervised: bool = True) -> list[str]:
        states = []
        for _ in range(cycles):
            self.cycle(None, supervised=supervised)
            states.append(self.guard.state)
        return states


def until_rest(robot: Robot) -> int:
    for n in range(3000):
        if robot.guard.state == "rest" and not robot.guard.busy:
            return n
        robot.cycle(None)
    raise AssertionError(robot.guard.status)
