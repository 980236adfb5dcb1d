"""World commands over Zenoh to a running robot, in real time and in lockstep."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from bridge.body import load_body
from bridge.body.postures import POSTURES
from bridge.dcm.actuators import led_names
from bridge.guard import Guard
from bridge.link import ControllerLink, RobotLink
from bridge.link.client import WorldClient
from bridge.messages import ActuatorFrame, LedFrame, Notice, SensorFrame, TruthFrame
from bridge.messages.faults import SensorDead
from bridge.messages.world import (
    EndFault,
    Pause,
    PlaceObject,
    Press,
    Push,
    Remove,
    Reset,
    Resume,
    SetFriction,
    StartFault,
    Status,
    Step,
    TiltFloor,
)
from bridge.recording.observer import Observer
from emulator.process import RobotSide, WorldProcess
from emulator.robot import EmulatedRobot
from emulator.timing import CycleTimer
from tests.frames import info_of_robot
from tests.loops import TIMEOUT, repeat_while, until
from tests.ports import free_endpoint

BODY = load_body("nao-v3")
START = POSTURES["StandInit"]


class Ear(Observer):
    """Keeps what an observer is told."""

    def __init__(self) -> None:
        self.frames: list[SensorFrame] = []
        self.leds: list[tuple[int, ...]] = []
        self.notices: list[Notice] = []

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        self.frames.append(frame)
        self.leds.append(truth.leds)

    def notice(self, message: Notice) -> None:
        self.notices.append(message)


@contextmanager
def running(mode: str) -> Iterator[tuple[WorldClient, Ear, str]]:
    """A robot that runs in a thread of its own, and a client of its world."""
    endpoint, ear, stop = free_endpoint(), Ear(), threading.Event()
    info = info_of_robot(body=BODY.name, mode=mode, cycle=BODY.cycle)
    with EmulatedRobot(BODY, seed=0, settle=0.1) as robot, RobotLink(info, endpoint) as link:
        process = WorldProcess([RobotSide(robot, link, Guard(BODY), [ear])], stop)
        loop = process.lockstep if mode == "lockstep" else lambda: process.real_time(CycleTimer(BODY.cycle))
        thread = threading.Thread(target=loop)
        thread.start()
        try:
            with WorldClient("nao", endpoint) as client:
                yield client, ear, endpoint
        finally:
            stop.set()
            thread.join(TIMEOUT)
    assert not thread.is_alive()


def test_a_world_in_real_time_obeys_between_two_cycles() -> None:
    with running("real-time") as (world, ear, _):
        assert not world.send(Status()).paused
        held = world.send(Pause())
        assert held.paused
        assert world.send(Status()).seq == held.seq
        stepped = world.send(Step(cycles=7))
        assert (stepped.seq, stepped.paused) == (held.seq + 7, True)
        assert stepped.time == pytest.approx(stepped.seq * BODY.cycle)
        placed = world.send(PlaceObject(name="box", size=(0.1, 0.1, 0.1), at=(0.5, 0.0), mass=0.2))
        assert [(box.name, box.mass) for box in placed.objects] == [("box", 0.2)]
        world.send(Push(target="box", impulse=(0.2, 0.0, 0.0), duration=0.01))
        moved = world.send(Step(cycles=20))
        assert moved.objects[0].position[0] > placed.objects[0].position[0] + 0.01
        assert world.send(SetFriction(friction=0.3)).friction == 0.3
        world.send(TiltFloor(pitch=0.05, duration=0.3))
        assert world.send(Step(cycles=31)).floor == pytest.approx((0.0, 0.05))
        world.send(StartFault(fault=SensorDead(sensor="fsr")))
        world.send(Press(button="chest"))
        assert world.send(Step()).faults == ("sensor-dead:fsr",)
        # observers are told beside the robot's work, perhaps after the answer
        until(lambda: (ear.frames[-1].fsr, ear.frames[-1].touch[0]) == ((0.0,) * 8, 1.0), "the fault")
        assert world.send(EndFault(name="sensor-dead:fsr")).faults == ()
        assert world.send(Remove(name="box")).objects == ()
        again = world.send(Reset())
        assert (again.seq, again.friction, again.floor, again.objects) == (0, 0.8, (0.0, 0.0), ())
        until(lambda: ear.frames[-1].seq == 0, "the first frame again")
        world.send(Resume())
        assert not world.send(Status()).paused
    assert "Fault sensor-dead:fsr begins." in [notice.text for notice in ear.notices]


def test_a_button_is_pressed_from_the_command_line() -> None:
    """LoLA's order of the buttons: the second is the head's front one."""
    with running("real-time") as (_, ear, endpoint):
        command = ["world", "press", "head_front", "--for", "0.2", "--connect", endpoint, "--json"]
        done = subprocess.run([sys.executable, "-m", "nao_hil.cli", *command], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        pressed = until(lambda: [frame.touch for frame in ear.frames if any(frame.touch)], "the press")
        until(lambda: ear.frames[-1].touch[1] == 0.0, "its release")
    assert set(pressed) == {(0.0, 1.0, *(0.0,) * 12)}


def test_leds_are_in_the_truth_and_move_nothing() -> None:
    chest = tuple(255 if name == "ChestBoard/Led/Red" else 0 for name in led_names())
    with running("real-time") as (_, ear, endpoint), ControllerLink("nao", endpoint) as controller:
        assert controller.wait_robot(lambda: False) is not None
        until(lambda: ear.leds, "a frame")
        assert ear.leds[-1] == ()
        controller.publish(LedFrame(leds=chest))
        until(lambda: ear.leds[-1] == chest, "the red light")
        controller.publish(LedFrame(leds=(0,) * 89))
        until(lambda: ear.leds[-1] == (), "darkness")


def test_lockstep_without_a_controller_steps_when_told_and_waits_otherwise() -> None:
    with running("lockstep") as (world, _, _):
        assert world.send(Step(cycles=5)).seq == 5
        world.send(Resume())
        assert world.send(Status()).seq == 5


def test_lockstep_with_a_controller_stands_still_in_a_pause_and_loses_no_frame() -> None:
    with running("lockstep") as (world, ear, endpoint), ControllerLink("nao", endpoint) as controller:
        assert controller.wait_robot(lambda: False) is not None
        controller.acquire()
        ended = threading.Event()

        def serve() -> None:
            for _ in repeat_while(lambda: not ended.is_set(), 100_000):
                frame = controller.next(0.05)
                if frame is not None:
                    controller.send(ActuatorFrame(reply_to=frame.seq, position=START, stiffness=(1.0,) * 25))

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            held = world.send(Pause())
            assert world.send(Status()).seq == held.seq
            assert world.send(Step(cycles=10)).seq == held.seq + 10
            world.send(Resume())
            until(lambda: world.send(Status()).seq >= held.seq + 30, "30 more frames")
        finally:
            ended.set()
            thread.join()
            controller.release()  # one that dies leaves a robot that goes on without it
    published = [frame.seq for frame in ear.frames]
    assert published == list(range(len(published)))
    # each frame but the first was computed with the answer to the one before
    assert all(frame.command == frame.seq - 1 for frame in ear.frames[1:])
