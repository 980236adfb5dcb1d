"""`nao-hil ros`: a robot of the link on ROS 2, without ROS."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.session import try_client
from nao_hil.cli import options
from nao_hil.cli.console import Answer, log_to_stderr, open_console
from nao_hil.cli.every_robot import Every, for_every_robot
from nao_hil.cli.signals import stop_event
from nao_hil.runs.folder import describe

RETRY = 0.1
"""s between two looks for a router"""


def ros(
    domain: Annotated[int, typer.Option("--domain", help="ROS_DOMAIN_ID of the other nodes.", metavar="N")] = 0,
    distro: Annotated[
        str, typer.Option("--distro", help="ROS distribution of the other nodes: humble, jazzy or kilted.")
    ] = "jazzy",
    router: Annotated[
        str | None,
        typer.Option(
            "--router",
            help="Zenoh router of the other nodes, for example rmw_zenohd; default: the robot itself is one.",
            metavar="ENDPOINT",
        ),
    ] = None,
    picture_rate: Annotated[
        float,
        typer.Option(
            "--picture-rate", help="Pictures a second of a camera that is listened to.", min=0.1, max=30.0
        ),
    ] = 10.0,
    every: Every = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer | int:
    """Put a robot on ROS 2 for nodes with rmw_zenoh; ROS need not be installed here.

    The topics of a robot of another id than `nao` are in a namespace of that id, as in /red/joint_states.

    Example: nao-hil ros --domain 3

    Example: nao-hil ros --all
    """
    if every:
        shared = ["ros", "--domain", str(domain), "--distro", distro, "--picture-rate", str(picture_rate)]
        shared += ["--router", router] if router else []
        return for_every_robot(connect, name, lambda _, robot: (f"/{robot}", shared))
    try:
        from bridge.adapters.ros.bridge import RosBridge
        from bridge.adapters.ros.wire import RosNode
    except ImportError as error:
        raise ConfigurationError(f"{error}; pip install 'nao-hil[ros]'.") from None

    log_to_stderr()
    stop = stop_event()
    while (session := try_client(router or connect, timestamps=True)) is None:
        if stop.wait(RETRY):
            return 130
    node = RosNode(session, name, domain, distro, namespace="" if name == DEFAULT_ROBOT else name)
    try:
        counts = RosBridge(name, connect, node, describe, picture_rate, stop).run()
    finally:
        node.close()
    return Answer(counts)


def rosbag(
    recording: options.Recording,
    out: Annotated[Path, typer.Option("--out", help="Folder to make for the bag.", metavar="DIR")],
    distro: Annotated[
        str, typer.Option("--distro", help="ROS distribution: humble, jazzy or kilted.")
    ] = "jazzy",
) -> Answer:
    """Write a recorded run as a ROS 2 bag: joint states, inertial unit, odometry, transforms, URDF.

    Example: nao-hil export rosbag runs/20260101T120000Z --out walk-bag
    """
    try:
        from bridge.adapters.ros.messages import write_bag
        from bridge.adapters.ros.wire import check_distro
    except ImportError as error:
        raise ConfigurationError(f"{error}; pip install 'nao-hil[ros]'.") from None
    from bridge.recording.playback import recorded_body

    body = recorded_body(recording)
    counts = write_bag(recording, out, body, describe(body), check_distro(distro))
    open_console().print(f"{sum(counts.values())} messages are in {out}.")
    return Answer({"bag": str(out), "messages": counts})
