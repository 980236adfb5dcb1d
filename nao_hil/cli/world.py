"""`nao-hil world`: things for the cameras of an emulated robot, its buttons, its reset."""

from __future__ import annotations

import math
import time
from typing import Annotated

import typer

from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.client import WorldClient
from bridge.messages.frames import ELEMENTS
from bridge.messages.world import PlaceThing, Press, Remove, Reset, Status, ThingKind, WorldCommand
from bridge.validation import unknown_name
from nao_hil.cli import options
from nao_hil.cli.console import Answer

X = Annotated[float, typer.Argument(help="Ahead of the robot, m; with --floor along the floor's x axis.")]
Y = Annotated[float, typer.Argument(help="To its left, m; with --floor along the floor's y axis.")]
Height = Annotated[float | None, typer.Option("--height", help="Of its middle over the floor, m.", metavar="M")]
Size = Annotated[float | None, typer.Option("--size", help="Diameter, m.", metavar="M")]
Yaw = Annotated[
    float | None,
    typer.Option("--yaw", help="Heading of its front; default: towards the robot.", metavar="DEGREES"),
]
OnFloor = Annotated[
    bool, typer.Option("--floor", help="X and Y are of the floor, whose origin is where the robot began.")
]


def ball(
    x: X,
    y: Y,
    ball_name: Annotated[str, typer.Option("--called", help="Its name.", metavar="NAME")] = "ball",
    height: Height = None,
    size: Size = None,
    floor: OnFloor = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Put a red ball of 6 cm on the floor.

    Example: nao-hil world ball 0.5 0.1
    """
    return _put("ball", ball_name, (x, y), height, None, size, floor, name, connect)


def landmark(
    number: Annotated[int, typer.Argument(help="Of the mark.", min=0)],
    x: X,
    y: Y,
    height: Height = None,
    yaw: Yaw = None,
    size: Size = None,
    floor: OnFloor = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Put a landmark of 10 cm at the height of the eyes, with its front to the robot.

    Example: nao-hil world landmark 80 1.0 0.2
    """
    return _put("landmark", str(number), (x, y), height, yaw, size, floor, name, connect)


def face(
    person: Annotated[str, typer.Argument(help="Name of the person.")],
    x: X,
    y: Y,
    height: Height = None,
    yaw: Yaw = None,
    size: Size = None,
    floor: OnFloor = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Put a face of 15 cm at the height of the eyes, with its front to the robot.

    Example: nao-hil world face Anna 1.0 -0.2 --height 0.6
    """
    return _put("face", person, (x, y), height, yaw, size, floor, name, connect)


def remove(
    what: Annotated[str, typer.Argument(help="Name of a thing or of a box.")],
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Take a thing or a box away.

    Example: nao-hil world remove ball
    """
    return _send(Remove(name=what), name, connect)


def reset(
    every: Annotated[
        bool, typer.Option("--all", help="Restart the world with all robots and objects.")
    ] = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Put one robot back to its start, while the others and the clock of the world go on; or restart the world.

    Example: nao-hil world reset --name blue
    """
    return _send(Reset(scope="world" if every else "robot"), name, connect)


def press(
    button: Annotated[str, typer.Argument(help=f"One of {', '.join(ELEMENTS['touch'])}.", metavar="BUTTON")],
    seconds: Annotated[
        float, typer.Option("--for", help="Seconds to its release.", min=0.05, max=60.0, metavar="S")
    ] = 0.3,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Press a button, a bumper or a touch surface, and release it.

    Example: nao-hil world press head_front
    """
    if button not in ELEMENTS["touch"]:
        raise ConfigurationError(unknown_name("button", button, ELEMENTS["touch"]))
    with WorldClient(name, connect) as world:
        world.send(Press(button=button))
        time.sleep(seconds)
        world.send(Press(button=button, pressed=False))
    return _text_answer(f"Button {button} was pressed for {seconds:g} s.")


def show(
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """List the boxes and things of the world.

    Example: nao-hil world list
    """
    with WorldClient(name, connect) as world:
        reply = world.send(Status())
    things = [("box", box.name, box.position) for box in reply.objects]
    things += ((thing.kind, thing.name, thing.position) for thing in reply.things)
    lines = (f"{kind} `{called}` at ({', '.join(f'{x:.3f}' for x in at)})" for kind, called, at in things)
    return Answer({"objects": reply.objects, "things": reply.things}, "\n".join(lines))


def _put(
    kind: ThingKind,
    called: str,
    at: tuple[float, float],
    height: float | None,
    yaw: float | None,
    size: float | None,
    floor: bool,
    name: str,
    connect: str,
) -> Answer:
    angle = None if yaw is None else math.radians(yaw)
    command = PlaceThing(
        name=called,
        kind=kind,
        at=at,
        height=height,
        yaw=angle,
        size=size,
        frame="floor" if floor else "robot",
    )
    return _send(command, name, connect)


def _send(command: WorldCommand, name: str, connect: str) -> Answer:
    with WorldClient(name, connect) as world:
        return _text_answer(world.send(command).text)


def _text_answer(text: str) -> Answer:
    return Answer({"text": text}, text)
