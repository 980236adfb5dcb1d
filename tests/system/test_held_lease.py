"""A held robot stays with its holder: on an open link and among certificates of one role."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import msgspec
import pytest
import zenoh

from bridge.errors import LeaseRefused, LinkError
from bridge.link import ControllerLink, RobotLink, keys
from bridge.link.certificates import with_keys
from bridge.link.seal import KeyPair
from bridge.link.session import open_client
from bridge.messages import ActuatorFrame, LeaseReply, LeaseRequest, decode, encode
from nao_hil.certificates import Keys
from tests.frames import info_of_robot
from tests.loops import TIMEOUT, until

ZEROS = (0.0,) * 25
LEASE, ACTUATORS = "nao/nao/lease", "nao/nao/actuators"


class Heard(NamedTuple):
    """A message of the holder as it crossed the link."""

    key: str
    payload: bytes
    attachment: bytes


class OpenBook(RobotLink):
    """A robot that keeps all that its node sees: more than any other party of the link."""

    heard: list[Heard]

    def _declare(self) -> None:
        self.heard = []
        super()._declare()

    def _on_lease(self, payload: bytes, attachment: bytes) -> bytes:
        self.heard.append(Heard(LEASE, payload, attachment))
        return super()._on_lease(payload, attachment)

    def _on_actuators(self, sample: zenoh.Sample) -> None:
        attachment = sample.attachment.to_bytes() if sample.attachment else b""
        self.heard.append(Heard(ACTUATORS, sample.payload.to_bytes(), attachment))
        super()._on_actuators(sample)


class Scene(NamedTuple):
    """A held robot, its holder, and a stranger with rights of its own."""

    robot: OpenBook
    holder: ControllerLink
    stranger: zenoh.Session
    place: str

    def ask(self, key: str, payload: bytes, attachment: bytes | None = None) -> bytes | None:
        """Reply to the stranger; None: refused."""
        replies = self.stranger.get(key, payload=payload, attachment=attachment, timeout=TIMEOUT)
        return next((bytes(reply.ok.payload.to_bytes()) for reply in replies if reply.ok is not None), None)

    def request(self, op: str, key: str) -> bytes:
        """Of the lease, in the holder's name."""
        return encode(msgspec.convert({"op": op, "controller": "walker", "key": key}, LeaseRequest))

    @property
    def key(self) -> str:
        """Public key of the holder, as its token shows it."""
        found = self.stranger.liveliness().get("nao/nao/alive/controller/*", timeout=TIMEOUT)
        tokens = [str(reply.ok.key_expr) for reply in found if reply.ok is not None]
        return next(token for token in tokens if "/walker." in token).rpartition(".")[2]

    def put(self, payload: bytes, attachment: bytes | None = None) -> None:
        """Publish an actuator frame as the stranger, and wait until the robot has judged it."""
        judged = len(self.robot.heard)
        self.stranger.put(ACTUATORS, payload, attachment=attachment)
        until(lambda: len(self.robot.heard) > judged, "the stranger's frame")

    def check(self) -> None:
        """The holder commands on, and the robot obeyed nobody else."""
        assert self.robot.holder is not None and self.robot.holder.lease == self.holder.lease != 0
        assert self.robot.commands() == []
        self.holder.send(command(99))
        frame = until(lambda: self.robot.wait_command(0.2), "the holder's command")
        assert frame.reply_to == 99


def command(reply_to: int, lease: int = 0) -> ActuatorFrame:
    return ActuatorFrame(reply_to=reply_to, position=ZEROS, stiffness=ZEROS, lease=lease)


@pytest.fixture(params=["tcp", "tls"])
def scene(request: pytest.FixtureRequest, endpoint: str, tmp_path: Path) -> Iterator[Scene]:
    at = mine = other = endpoint
    if request.param == "tls":
        authority = Keys(tmp_path / "keys")
        for role in ("robot", "controller"):
            authority.issue(role, days=1.0)
        at = mine = with_keys(endpoint.replace("tcp/", "tls/"), tmp_path / "keys")
        (tmp_path / "keys" / "controller").rename(tmp_path / "first")
        authority.issue("controller", days=1.0)  # the stranger's certificate is another one of the role
        mine, other = with_keys(mine.partition("#")[0], tmp_path / "first"), at
    with OpenBook(info_of_robot(), at) as robot, ControllerLink(connect=mine) as holder:
        robot.serve("dcm/set", lambda _: b"done", sealed=True)
        holder.wait_robot(timeout=TIMEOUT)
        holder.acquire()
        with contextlib.closing(open_client(other, role="controller")) as stranger:
            yield Scene(robot, holder, stranger, other)


def test_the_holders_key_takes_nothing(scene: Scene) -> None:
    """The token shows it to all; each request wants a seal."""
    for op in ("acquire", "release"):
        for attachment in (None, b"", bytes(40), bytes(7) + b"\xff" + bytes(32)):
            assert scene.ask(LEASE, scene.request(op, scene.key), attachment) is None
    scene.check()


def test_a_seal_of_another_key_is_none_of_the_holder(scene: Scene) -> None:
    reply = scene.ask(LEASE, scene.request("status", ""))
    assert reply is not None
    own = KeyPair().seal(decode(reply, LeaseReply).key)
    for op in ("acquire", "release"):
        request = scene.request(op, scene.key)
        assert own.send(LEASE, request, lambda mark, sent=request: scene.ask(LEASE, sent, mark)) is None
    frame = encode(command(50, scene.holder.lease))
    own.send(ACTUATORS, frame, lambda mark: scene.put(frame, mark))
    scene.check()


def test_the_notice_of_a_wrong_seal_names_the_seal(scene: Scene) -> None:
    """Who has the lease and seals wrongly would ask for it in vain."""
    scene.put(encode(command(50, scene.holder.lease)), bytes(40))
    assert scene.robot.commands() == []
    notices = until(lambda: [n.text for n in scene.holder.notices() if n.code == "no-lease"], "the notice")
    assert "the seal is not of its key" in notices[0]


def test_a_message_of_the_holder_counts_once(scene: Scene) -> None:
    scene.holder.send(command(1))
    assert until(lambda: scene.robot.wait_command(0.2), "a command").reply_to == 1
    assert scene.holder.query("dcm/set", b"") == b"done"
    for key, payload, attachment in list(scene.robot.heard):
        if key == ACTUATORS:
            scene.put(payload, attachment)
        elif attachment:
            assert scene.ask(LEASE, payload, attachment) is None
    scene.check()


def test_a_seal_holds_for_its_message_and_key_only(scene: Scene) -> None:
    """Cut off the link: what the robot has not seen yet, and could be changed on the way."""
    lost = list[Heard]()
    seal = scene.holder._seal
    assert seal is not None
    for key, payload in ((ACTUATORS, encode(command(2, scene.holder.lease))), (LEASE, b"any")):
        seal.send(key, payload, lambda mark, key=key, sent=payload: lost.append(Heard(key, sent, mark)))
    for _, payload, attachment in lost:
        assert scene.ask(LEASE, scene.request("release", scene.key), attachment) is None
        assert scene.ask("nao/nao/dcm/set", payload, attachment) is None
        scene.put(encode(command(60, scene.holder.lease)), attachment)
        later = (int.from_bytes(attachment[:8], "big") + 5).to_bytes(8, "big") + attachment[8:]
        scene.put(payload if payload != b"any" else encode(command(61)), later)
    scene.check()


def test_a_command_in_the_holders_number_is_refused(scene: Scene) -> None:
    scene.put(encode(command(70, scene.holder.lease)))
    assert scene.ask("nao/nao/dcm/set", b"") is None
    scene.check()


def test_a_second_token_of_the_holders_key_ends_nothing(scene: Scene) -> None:
    for leave in (zenoh.LivelinessToken.undeclare, lambda _: scene.stranger.close()):
        token = scene.stranger.liveliness().declare_token(f"nao/nao/alive/controller/walker.{scene.key}")
        assert scene.ask(LEASE, scene.request("status", "")) is not None  # on the same link, behind the token
        leave(token)
    with contextlib.closing(open_client(scene.place, role="controller")) as witness:
        assert list(witness.get(LEASE, payload=scene.request("status", ""), timeout=TIMEOUT))
    scene.check()


def test_a_false_key_of_the_robot_keeps_the_holder_away_no_longer_than_it_is_shown(scene: Scene) -> None:
    true, lease = scene.holder._seal, scene.holder.lease
    scene.holder._seal = scene.holder._keys.seal(
        KeyPair().public
    )  # as from a stranger that answers for the robot
    with pytest.raises(LinkError, match="`dcm/set`"):
        scene.holder.query("dcm/set", b"")
    scene.holder.acquire()
    assert scene.holder.lease == lease and scene.holder._seal is not true
    scene.check()


def test_who_answers_in_the_robots_name_learns_no_way_to_take_it(scene: Scene) -> None:
    """On an open link a stranger hears the requests, and may answer them; certificates forbid both."""
    heard = list[Heard]()

    def listen(query: zenoh.Query) -> None:
        mark = query.attachment.to_bytes() if query.attachment else b""
        heard.append(Heard(LEASE, query.payload.to_bytes() if query.payload else b"", mark))
        query.drop()

    thief = scene.stranger.declare_queryable(LEASE, listen)
    assert scene.ask(LEASE, scene.request("status", "")) is not None
    scene.holder.acquire()
    scene.holder.acquire()
    thief.undeclare()
    for _, payload, attachment in heard:
        if b"acquire" in payload:
            assert scene.ask(LEASE, payload, attachment) is None
    scene.check()


@pytest.mark.parametrize("leave", ["broken session", "release"])
def test_the_holder_alone_gets_its_lease_back(scene: Scene, leave: str) -> None:
    """Its session broke off, as with a cable pulled; only its own key brings its number back."""
    lease, key = scene.holder.lease, scene.key
    if leave == "release":
        scene.holder.release()
    else:
        scene.holder._token.undeclare()
    until(lambda: scene.robot.holder is None, "the end of the lease")
    acquire = next(h for h in scene.robot.heard if b"acquire" in h.payload)
    assert scene.ask(LEASE, scene.request("acquire", key)) is None
    if leave == "broken session":
        assert scene.ask(LEASE, acquire.payload, acquire.attachment) is None
    scene.holder.acquire()
    assert (scene.holder.lease == lease) == (leave == "broken session")
    for _, payload, attachment in [h for h in scene.robot.heard if h.key == LEASE and h.attachment]:
        scene.ask(LEASE, payload, attachment)  # its release of before among them
    scene.check()


def test_another_controller_still_gets_a_robot_that_was_given_back(scene: Scene) -> None:
    with ControllerLink(connect=scene.place, name="next") as following:
        following.wait_robot(timeout=TIMEOUT)
        with pytest.raises(LeaseRefused, match="`walker`"):
            following.acquire()
        scene.holder.release()
        following.acquire()
        following.send(command(5))
        assert until(lambda: scene.robot.wait_command(0.2), "a command").reply_to == 5
        with pytest.raises(LinkError, match="`next` holds the robot"):
            scene.holder.query("dcm/set", b"")
        assert following.query("dcm/set", b"") == b"done"


def test_a_key_that_is_none_is_refused(scene: Scene) -> None:
    for key in ("", "00" * 32):  # none, and a point of small order, with which any secret is zero
        assert scene.ask(LEASE, scene.request("acquire", key), bytes(40)) is None
    scene.check()
    assert scene.robot.info.robot == keys.DEFAULT_ROBOT
