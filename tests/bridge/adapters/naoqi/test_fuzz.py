"""Any method with any arguments: a result or one sentence, and the robot's cycle goes on."""

from __future__ import annotations

import random
from concurrent.futures import Future
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from bridge.errors import NaoHilError
from tests.bridge.adapters.naoqi.served import Robot
from tests.fuzz.values import some

FITTING: dict[str, list[Any]] = {
    "names": ["LArm", "Body", "Head", ["HeadYaw"], "Torso", ["LArm", "RArm"], "FaceLeds"],
    "name": [
        "LArm",
        "Head",
        "Body",
        "LHand",
        "FaceLeds",
        "AllLeds",
        "HeadYaw",
        "Stand",
        "me",
        "MyEvent",
        "speed",
    ],
    "space": [0, 1, 2],
    "spaces": [0, 1, 2, [0, 2]],
    "values": [[0.2, 0.1, 0.1, 0.0, 0.0, 0.0], [1.0, 0, 0, 0.2, 0, 1.0, 0, 0.1, 0, 0, 1.0, 0.1]],
    "paths": [[0.2, 0.1, 0.1, 0.0, 0.0, 0.0], [[0.1] * 6, [0.2] * 6], [[[0.1] * 6], [[0.2] * 6]]],
    "mask": [7, 63, 56],
    "masks": [7, 63, [7, 7]],
    "speed": [0.1, 0.5, 1.0],
    "times": [0.5, [0.5], [0.5, 1.0], [[0.5], [1.0]]],
    "duration": [0.0, 0.1, 2.0],
    "handle": ["me_0"],
    "angles": [0.1, -3.0, [0.1], [0.1, 0.2], [[0.1, 0.2], [0.3]]],
}
"""By the parameter's name: arguments that get further than the first check."""


def fitting(draw: random.Random, robot: Robot, service: str, method: str) -> list[Any]:
    """As many arguments as the method takes, most of them of its kind."""
    entry = robot.services._table[service].get(method)
    parameters = entry.signature.parameters.values() if entry else ()
    wanted = [p.name for p in parameters if p.kind is not p.VAR_POSITIONAL and p.kind is not p.KEYWORD_ONLY]
    return [
        draw.choice(FITTING[name]) if name in FITTING and draw.random() < 0.85 else some(draw)
        for name in wanted
    ]


def attempt(robot: Robot, draw: random.Random) -> None:
    """One call of any method; it must end in a result or in one sentence."""
    names = robot.services.names()
    service = draw.choice([*sorted(names), *["ALMotion"] * 10, *["ALLeds", "ALTracker", "NaoHil"] * 2])
    method = draw.choice([*names[service], "nothing"])
    any_ = [some(draw) for _ in range(draw.randrange(7))]
    arguments = fitting(draw, robot, service, method) if draw.random() < 0.6 else any_
    try:
        result = robot.call(service, method, *arguments)
    except NaoHilError as error:
        require_sentence(str(error), service, method, arguments)
        return
    if isinstance(result, Future) and result.done():
        error_ = result.exception()
        if error_ is not None:
            assert isinstance(error_, NaoHilError), (service, method, arguments, error_)
            require_sentence(str(error_), service, method, arguments)


def require_sentence(text: str, *call: Any) -> None:
    assert text.endswith(".") and "\n" not in text and "Traceback" not in text, (text, *call)


@settings(max_examples=15)
@given(st.integers(0, 2**32))
def test_no_call_does_more_than_refuse(seed: int) -> None:
    draw, robot = random.Random(seed), Robot()
    for _ in range(50):
        attempt(robot, draw)
        robot.run(0.01)


def test_every_method_refuses_what_does_not_fit() -> None:
    """Each method once, with more arguments than any takes, except those that take any number."""
    draw, robot, taken = random.Random(0), Robot(), []
    for service, methods in robot.services.table().items():
        for method, entry in methods.items():
            arguments = [some(draw) for _ in range(12)]
            try:
                robot.call(service, method, *arguments)
            except NaoHilError as error:
                require_sentence(str(error), service, method, arguments)
            else:
                if not any(p.kind is p.VAR_POSITIONAL for p in entry.signature.parameters.values()):
                    taken.append(method)
    assert taken == []
