"""Sensor-to-command round trip over the link, against a bare Zenoh ping-pong of the same sizes.

Both are measured in one run, in alternating blocks, against a peer in another process; once per 10 ms as the
robot does it, and back to back as lockstep does it. The bare floor uses Zenoh's own channels, no schema and
no lease; the difference to it is the cost of the link and the walker's tick.
"""

from __future__ import annotations

import contextlib
import secrets
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import zenoh

from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.errors import LinkError
from bridge.link import ControllerLink, RobotLink
from bridge.link.session import open_client, open_robot
from bridge.messages import ActuatorFrame, Info, SensorFrame, encode
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from tests.ports import free_endpoint

_BLOCKS = 6
_PACED, _BACK_TO_BACK = 100, 400
_PERIOD = 0.01


def measure() -> dict[str, Any]:
    """Time the round trips.

    Returns:
        For `paced` (one per 10 ms) and `back_to_back`: median and 99th percentile of link and floor, s, their
        ratio, and the ratio with the walker's own tick taken off.
    """
    with _peer("walker") as walker_at, _peer("echo") as echo_at:
        return _alternate(walker_at, echo_at)


@contextlib.contextmanager
def _peer(kind: str) -> Iterator[str]:
    endpoint = free_endpoint()
    code = f"from tests.bench.round_trip import {kind}; {kind}({endpoint!r})"
    process = subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parents[2])
    try:
        yield endpoint
    finally:
        process.kill()
        process.wait()


def _alternate(walker_at: str, echo_at: str) -> dict[str, Any]:
    body = load_body("nao-v3")
    info = Info(
        robot="nao",
        body=body.name,
        side="emulator",
        mode="lockstep",
        cycle=body.cycle,
        absent=(),
        boot=secrets.randbits(31),
        software="bench",
    )
    times: dict[str, list[float]] = {n: [] for n in ("link", "floor", "link_fast", "floor_fast")}
    ticks: list[float] = []
    with RobotLink(info, walker_at) as link, contextlib.closing(open_robot(echo_at)) as session:
        publisher = session.declare_publisher("bench/sensors")
        replies = session.declare_subscriber("bench/actuators", zenoh.handlers.FifoChannel(16))
        payload = encode(standing_frame(0))
        seq = 0

        def by_link() -> None:
            """A sensor frame, and the walker's answer."""
            nonlocal seq
            seq += 1
            link.publish(standing_frame(seq))
            # The first wait may end early, because a granted lease wakes it.
            if link.wait_command(5.0) is None and link.wait_command(5.0) is None:
                raise LinkError("the benchmark's walker did not answer within 5 s")
            ticks.extend(message.tick for message in link.telemetry())

        def bare() -> None:
            publisher.put(payload)
            replies.handler.recv()

        _wait_for(link, bare, publisher, payload, replies)
        paced_ticks: list[float] = []
        for _ in range(_BLOCKS):
            ticks.clear()
            times["link"] += _paced(by_link)
            paced_ticks += ticks
            times["floor"] += _paced(bare)
            ticks.clear()
            times["link_fast"] += [trip_time(by_link) for _ in range(_BACK_TO_BACK)]
            times["floor_fast"] += [trip_time(bare) for _ in range(_BACK_TO_BACK)]
    return {
        "paced": _compare(times["link"], times["floor"], statistics.median(paced_ticks)),
        "back_to_back": _compare(times["link_fast"], times["floor_fast"], statistics.median(ticks)),
    }


def _wait_for(link: RobotLink, bare: Callable[[], None], publisher: Any, payload: bytes, replies: Any) -> None:
    """Both peers are up and warm."""
    deadline = time.monotonic() + 20.0
    while link.holder is None and time.monotonic() < deadline:
        time.sleep(0.01)
    while replies.handler.try_recv() is None:
        publisher.put(payload)
        time.sleep(0.02)
        if time.monotonic() > deadline:
            raise LinkError("the benchmark's echo did not answer within 20 s")
    while replies.handler.try_recv() is not None:
        pass
    bare()


def trip_time(trip: Callable[[], None]) -> float:
    """Of one round trip, s."""
    began = time.perf_counter()
    trip()
    return time.perf_counter() - began


def _paced(trip: Callable[[], None]) -> list[float]:
    times = []
    deadline = time.monotonic()
    for _ in range(_PACED):
        deadline += _PERIOD
        time.sleep(max(0.0, deadline - time.monotonic()))
        times.append(trip_time(trip))
    return times


def _compare(link: list[float], floor: list[float], tick: float) -> dict[str, float]:
    def p99(values: list[float]) -> float:
        return sorted(values)[int(0.99 * len(values))]

    ours, bare = statistics.median(link), statistics.median(floor)
    return {
        "link_p50": ours,
        "link_p99": p99(link),
        "floor_p50": bare,
        "floor_p99": p99(floor),
        "tick_p50": tick,
        "ratio": ours / bare,
        "ratio_without_tick": (ours - tick) / bare,
    }


def standing_frame(seq: int) -> SensorFrame:
    """A sensor frame of a standing robot with all joints at 0; every number as long as in a real one."""
    third = (1.0 / 3.0,) * N_JOINTS
    return SensorFrame(
        seq=seq,
        time=seq * 0.01,
        position=(0.0,) * N_JOINTS,
        stiffness=third,
        current=third,
        temperature=third,
        fsr=(5.7,) * 8,
        accelerometer=(0.0, 0.0, 9.81),
        gyroscope=(0.0, 0.0, 0.0),
        angle=(0.0, 0.0),
        touch=(0.0,) * 14,
        battery=(1.0, 0.0, 0.0, 25.0),
        sonar=(2.55, 2.55),
    )


def walker(endpoint: str) -> None:
    """The other end of the link: a controller that answers every frame."""
    body = load_body("nao-v3")
    controller = controller_maker(RunConfig(steps=0))(body, body.cycle)
    with ControllerLink(connect=endpoint, name="bench") as link:
        link.wait_robot()
        link.acquire()
        while True:
            frame = link.next(1.0)
            if frame is None:
                continue
            began = time.perf_counter()
            command = controller.tick(frame)
            tick = time.perf_counter() - began
            link.send(command)
            link.publish(msgspec.structs.replace(controller.telemetry, tick=tick))


def echo(endpoint: str) -> None:
    """The other end of the floor: sends back as many bytes as an actuator frame has."""
    session = open_client(endpoint)
    zeros = (1.0 / 3.0,) * N_JOINTS
    reply = encode(ActuatorFrame(reply_to=0, position=zeros, stiffness=zeros))
    publisher = session.declare_publisher("bench/actuators")
    with session.declare_subscriber("bench/sensors", zenoh.handlers.FifoChannel(16)) as sensors:
        for _ in sensors:
            publisher.put(reply)
