"""`nao-hil world`: objects and things for the cameras of an emulated robot, its buttons, its reset."""

from __future__ import annotations

import math
import time
from typing import Annotated, Any, Literal, cast, get_args

import typer

from bridge.errors import ConfigurationError, FrameError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.client import WorldClient
from bridge.messages.frames import ELEMENTS
from bridge.messages.world import (
    LEAGUE_BALL_DIAMETER,
    LEAGUE_BALL_MASS,
    PlaceObject,
    PlaceThing,
    Press,
    Remove,
    Reset,
    SolidShape,
    Status,
    ThingKind,
    WorldCommand,
    require_command,
)
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
    bool,
    typer.Option("--floor", help="X and Y are of the floor, on whose origin a robot begins."),
]


def place(
    shape: Annotated[str, typer.Argument(help="ball, box or pole (an upright cylinder).", metavar="SHAPE")],
    x: X,
    y: Y,
    object_name: Annotated[
        str, typer.Option("--called", help="Its name; default: the shape's.", metavar="NAME")
    ] = "",
    size: Annotated[
        tuple[float, float, float] | None,
        typer.Option(
            "--size",
            help="Edges of the box around it, m; default: a ball and a box of 0.1, a pole 0.8 high.",
            metavar="X Y Z",
        ),
    ] = None,
    mass: Annotated[
        float | None,
        typer.Option(
            "--mass", help="kg, 0: fixed; default: that of the league's ball, else fixed.", metavar="KG"
        ),
    ] = None,
    yaw: Annotated[float, typer.Option("--yaw", help="About the vertical.", metavar="DEGREES")] = 0.0,
    height: Annotated[
        float | None,
        typer.Option("--height", help="Of its bottom over the floor, m; default: on the ground.", metavar="M"),
    ] = None,
    floor: OnFloor = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Place an object that can be touched and kicked; the one of its name is replaced.

    Example: nao-hil world place ball 0.3 0.05

    Example: nao-hil world place box 1.0 0.0 --size 0.2 0.3 0.1 --mass 0.5
    """
    if shape not in (known := get_args(SolidShape)):
        raise ConfigurationError(unknown_name("shape", shape, known))
    wide = LEAGUE_BALL_DIAMETER
    command = PlaceObject(
        name=object_name or shape,
        shape=cast("SolidShape", shape),
        size=size or (wide, wide, 0.8 if shape == "pole" else wide),
        at=(x, y),
        yaw=math.radians(yaw),
        height=height,
        mass=(LEAGUE_BALL_MASS if shape == "ball" else 0.0) if mass is None else mass,
        frame="floor" if floor else "robot",
    )
    return _send(command, name, connect)


def red_ball(
    x: X,
    y: Y,
    ball_name: Annotated[str, typer.Option("--called", help="Its name.", metavar="NAME")] = "red-ball",
    height: Height = None,
    size: Size = None,
    floor: OnFloor = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Show the cameras a red ball of 6 cm, which ALRedBallDetection finds and nothing can touch.

    Example: nao-hil world red-ball 0.5 0.1
    """
    return _send(_thing("ball", ball_name, x, y, floor, height=height, size=size), name, connect)


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
    thing = _thing("landmark", str(number), x, y, floor, yaw=yaw, height=height, size=size)
    return _send(thing, name, connect)


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
    return _send(_thing("face", person, x, y, floor, yaw=yaw, height=height, size=size), name, connect)


def remove(
    what: Annotated[str, typer.Argument(help="Name of a thing or of an object.")],
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Take a thing or an object away.

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
    """List the objects and things of the world.

    Example: nao-hil world list
    """
    with WorldClient(name, connect) as world:
        reply = world.send(Status())
    things = [
        *((thing.shape, thing.name, thing.position) for thing in reply.objects),
        *((thing.kind, thing.name, thing.position) for thing in reply.things),
    ]
    lines = (f"{kind} `{called}` at ({', '.join(f'{x:.3f}' for x in at)})" for kind, called, at in things)
    return Answer({"objects": reply.objects, "things": reply.things}, "\n".join(lines))


def _thing(
    kind: ThingKind, called: str, x: float, y: float, floor: bool, *, yaw: float | None = None, **more: Any
) -> PlaceThing:
    """A thing for the cameras; `yaw` in degrees."""
    angle = None if yaw is None else math.radians(yaw)
    frame: Literal["floor", "robot"] = "floor" if floor else "robot"
    return PlaceThing(name=called, kind=kind, at=(x, y), yaw=angle, frame=frame, **more)


def _send(command: WorldCommand, name: str, connect: str) -> Answer:
    try:
        require_command(command)
    except FrameError as error:  # what was typed, and not what a robot refuses
        raise ConfigurationError(str(error)) from None
    with WorldClient(name, connect) as world:
        return _text_answer(world.send(command).text)


def _text_answer(text: str) -> Answer:
    return Answer({"text": text}, text)
