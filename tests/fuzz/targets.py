"""Everything that reads what others wrote, as functions of bytes: only errors meant for people may come out.

`fuzz.py` feeds them what a coverage-guided fuzzer thinks of, `test_corpus.py` what was found before.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
from collections.abc import Callable
from http import HTTPStatus
from pathlib import Path
from typing import Any, Final

import msgspec
from rosbags.typesys import Stores, get_typestore
from websockets.http11 import Request
from websockets.server import ServerProtocol

from bridge.adapters.gamecontroller import packets
from bridge.adapters.gamecontroller.referee import Schedule
from bridge.adapters.lola.client import Setpoints
from bridge.adapters.lola.codec import MapStream
from bridge.adapters.lola.packets import identity_of, sensor_frame
from bridge.adapters.naoqi import qi_values
from bridge.adapters.ros.orders import JointPath
from bridge.body import Body
from bridge.body.joints import N_JOINTS
from bridge.config import load_toml, parse_toml
from bridge.dcm import requests
from bridge.errors import ConfigurationError, DcmRefused, FrameError, NaoHilError
from bridge.guard import ArmRequest, GuardSettings, StopRequest
from bridge.link.certificates import CA, CERTIFICATE, PRIVATE_KEY, load_certificates
from bridge.link.session import check_endpoint
from bridge.messages import (
    ActuatorFrame,
    Info,
    LeaseReply,
    LeaseRequest,
    Notice,
    SensorFrame,
    TruthFrame,
    WalkTelemetry,
    decode,
    decode_command,
    encode,
)
from bridge.messages.dcm import DcmCall, DcmCommand, DcmRead, DcmTime
from bridge.messages.walk import WalkCommand
from bridge.messages.world import ReportGame, WorldCommand
from bridge.recording.playback import read_recording, recording_end
from emulator.scenarios import Scenario
from emulator.wear import WearProfile
from nao_hil.runs.config import RunConfig
from nao_hil.view.access import Access, Answer
from nao_hil.view.server import door
from tests.bridge.adapters.naoqi.served import Robot
from tests.frames import STANDING, standing_frame

FRAMES: Final = (
    SensorFrame,
    ActuatorFrame,
    Info,
    LeaseRequest,
    LeaseReply,
    Notice,
    TruthFrame,
    WalkTelemetry,
    DcmRead,
    DcmTime,
    DcmCall,
)
COMMANDS: Final = (WalkCommand, ArmRequest, StopRequest, WorldCommand)
DCM: Final = (requests.alias_request, requests.set_request, requests.set_alias_request)
TABLES: Final = (RunConfig, Scenario, WearProfile, Body, GuardSettings, Schedule)

ROS_TYPES: Final = get_typestore(Stores.ROS2_JAZZY)


def frames(data: bytes) -> None:
    """Every message of the contract; what is accepted encodes and decodes to itself."""
    for kind in FRAMES:
        try:
            message: Any = decode(data, kind)
        except FrameError:
            continue
        assert decode(encode(message), kind) == message


def queries(data: bytes) -> None:
    """Commands to walker, DCM and world."""
    for kind in COMMANDS:
        _only(FrameError, decode_command, data, kind, "Command")
    try:
        command = decode(data, DcmCommand).command
    except FrameError:
        return
    for read in DCM:
        _only(DcmRefused, read, command)


def lola(data: bytes) -> None:
    """LoLA's stream in pieces of some bytes, and what is made of its maps on both sides."""
    size = 1 + (data[0] if data else 0)
    stream, whole = MapStream(("Position", "Stiffness")), MapStream(("Position", "Stiffness"))
    found = [value for at in range(0, len(data), size) for value in stream.feed(data[at : at + size])]
    demand = Setpoints((0.0,) * N_JOINTS)
    for value in (*found, *whole.feed(data)):
        demand.update(value)
        _only(NaoHilError, sensor_frame, value, seq=0)
        _only(NaoHilError, identity_of, value)
    assert whole.dropped <= len(data)


def tables(data: bytes) -> None:
    """Every kind of TOML file, as text and as a file."""
    for kind in TABLES:
        _only(ConfigurationError, parse_toml, data.decode(errors="replace"), "file", kind)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "file.toml"
        path.write_bytes(data)
        _only(ConfigurationError, load_toml, path, RunConfig)


def endpoints(data: bytes) -> None:
    """Endpoints as given on a command line."""
    _only(ConfigurationError, check_endpoint, data.decode(errors="replace"))


def certificates(data: bytes) -> None:
    """A folder of certificates whose files hold anything: the three of them, cut at zero bytes."""
    parts = [*data.split(b"\0", 2), b"", b""]
    with tempfile.TemporaryDirectory() as folder:
        for name, part in zip((CA, CERTIFICATE, PRIVATE_KEY), parts, strict=False):
            (Path(folder) / name).write_bytes(part)
        _only(ConfigurationError, load_certificates, Path(folder), "controller")


def recordings(data: bytes) -> None:
    """A recording that holds anything."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frames.mcap"
        path.write_bytes(data)
        _only(ConfigurationError, lambda: list(read_recording(path)))
        _only(ConfigurationError, recording_end, path)


def naoqi(data: bytes) -> None:
    """Calls of NAOqi's clients, `[service, method, [argument, ...]]` each, and a robot's cycle after it."""
    try:
        calls = msgspec.msgpack.decode(data, type=list[tuple[str, str, list[Any]]])
    except (msgspec.DecodeError, UnicodeDecodeError):
        return
    robot = Robot(STANDING, home=Path(tempfile.gettempdir()) / "nao-hil-fuzz-home")
    for seq, (service, method, arguments) in enumerate(calls):
        _only(NaoHilError, robot.services.call, service, method, arguments)
        robot.services.cycle(standing_frame(seq + 1))
        sent = robot.services.joints.answer()
        assert all(map(math.isfinite, (*sent.position, *sent.stiffness)))


def page(data: bytes) -> None:
    """A request to the page's server, and what a browser sends once it is connected."""
    for access in (Access(), Access("k3y", tls=True)):
        protocol = ServerProtocol()
        protocol.receive_data(data)
        for event in protocol.events_received():
            if isinstance(event, Request):
                answer = door(access, lambda _: Answer(HTTPStatus.OK, b"<html>"))(None, event)
                # Raised by websockets itself for such a request; its server ends that connection alone.
                with contextlib.suppress(AssertionError, UnicodeEncodeError):
                    protocol.send_response(answer or protocol.accept(event))
        protocol.data_to_send()


def qi(data: bytes) -> None:
    """A value of the qi protocol; one that is read is written again."""
    try:
        value = qi_values.decode("m", data)
    except qi_values.QiError:
        return
    qi_values.encode("m", value)


def ros(data: bytes) -> None:
    """A `JointTrajectory` in CDR, and the way that it makes."""
    try:
        message = ROS_TYPES.deserialize_cdr(data, "trajectory_msgs/msg/JointTrajectory")
    except Exception:
        return  # rosbags raises what its generated code raises; `RosNode.subscribe` leaves such messages out
    try:
        order, _ = JointPath(message).now(0.0)
    except ValueError as error:
        assert str(error)
        return
    assert all(map(math.isfinite, order.position))


def gamecontroller(data: bytes) -> None:
    """A packet of a GameController, or of a robot to it; what is read is written and read again."""
    with contextlib.suppress(FrameError):
        report = packets.decode_game(data)
        assert packets.decode_game(packets.encode_game(report, 0)) == report
        assert decode(encode(ReportGame(game=report)), ReportGame).game == report
        first = report.teams[0].number
        assert report.for_player(first, 1) is not None
    with contextlib.suppress(FrameError):
        status = packets.decode_status(data)
        assert packets.decode_status(packets.encode_status(status))[:3] == status[:3]


TARGETS: Final[dict[str, Callable[[bytes], None]]] = {
    target.__name__: target
    for target in (
        *(frames, queries, lola, tables, endpoints, certificates, recordings, naoqi, page, qi, ros),
        gamecontroller,
    )
}


def _only(allowed: type[NaoHilError], call: Callable[..., object], *args: Any, **kwargs: Any) -> None:
    """Call, and let nothing pass but errors of one kind with one sentence for a person."""
    try:
        call(*args, **kwargs)
    except allowed as error:
        assert str(error).strip()
