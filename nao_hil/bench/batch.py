"""A batch of robots beside the single robot and the bare engine, in one run.

Blocks of a single robot, of MuJoCo's own steps of that robot (the floor), of a batch in one thread and of the
same batch in all threads take turns; each robot is commanded to stand. Real-time factors are summed over the
robots: by the wall clock, and per second of the processor, which tells what threads cost where others use the
machine.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.messages import ActuatorFrame
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from nao_hil.batch import Batch


def measure(robots: int = 16, body: str = "nao-v6", blocks: int = 8, cycles: int = 25) -> dict[str, Any]:
    """Medians over the blocks, nominal robots that stand, on MuJoCo.

    Returns:
        By arm: the real-time factor, the same per second of the processor, and that over the floor's.
    """
    with (
        EmulatedRobot(load_body(body), seed=0, wear=load_wear("nominal"), engine="mujoco") as single,
        Batch(range(robots), body=body, threads=1) as serial,
        Batch(range(robots), body=body) as threaded,
    ):
        stand, engine = single.frame.position, single.engine

        def advance() -> None:
            single.advance(ActuatorFrame(reply_to=single.seq, position=stand, stiffness=(1.0,) * N_JOINTS))

        steps = round(serial.cycle / engine.settings.step)
        floor = "engine's own steps, 1 robot"
        arms: dict[str, tuple[int, Callable[[], object]]] = {
            floor: (1, lambda: [engine.bare_step() for _ in range(steps)]),
            "1 robot": (1, advance),
            f"batch of {robots}, 1 thread": (robots, lambda: serial.step(stand)),
            f"batch of {robots}, {threaded.threads} threads": (robots, lambda: threaded.step(stand)),
        }
        wall: dict[str, list[float]] = {name: [] for name in arms}
        processor: dict[str, list[float]] = {name: [] for name in arms}
        for _ in range(blocks):
            for name, (number, step) in arms.items():
                spent = used = 0.0
                count = cycles * robots // number
                for _ in range(count):
                    if name == floor:
                        advance()  # its drives hold it; not timed
                    began, before = time.perf_counter(), time.process_time()
                    step()
                    spent += time.perf_counter() - began
                    used += time.process_time() - before
                wall[name].append(number * count * serial.cycle / spent)
                processor[name].append(number * count * serial.cycle / used)
    per_second = {name: statistics.median(values) for name, values in processor.items()}
    return {
        name: {
            "real_time_factor": statistics.median(wall[name]),
            "per_processor_second": per_second[name],
            "over_floor": per_second[name] / per_second[floor],
        }
        for name in arms
    }
