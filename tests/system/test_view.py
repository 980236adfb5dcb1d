"""`nao-hil view` as a process, without a browser: what it serves, what it refuses, how it ends."""

from __future__ import annotations

import contextlib
import hashlib
import http.client
import re
import socket
import ssl
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from bridge.body import load_body
from bridge.errors import LinkError, WalkRefused
from bridge.link.client import WalkClient
from bridge.recording.recorder import Recorder
from emulator.robot import EmulatedRobot
from nao_hil.runs.config import RunConfig
from tests.loops import TIMEOUT, until

Start = Callable[..., Any]

WITHOUT_WEBSOCKETS = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "websockets":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
from nao_hil.cli.main import main
main()
"""


@pytest.fixture
def taken() -> Iterator[int]:
    """A port that somebody has."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server.getsockname()[1]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fifth of a second of a robot that stands."""
    file = tmp_path_factory.mktemp("recording") / "frames.mcap"
    with (
        EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco") as robot,
        Recorder(file, RunConfig()) as recorder,
    ):
        for _ in range(20):
            recorder.sensors(robot.frame, robot.truth())
            robot.advance(None)
    return file


def get(port: int, path: str) -> tuple[int, bytes]:
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", port, timeout=TIMEOUT)) as connection:
        connection.request("GET", path)
        response = connection.getresponse()
        return response.status, response.read()


def handshake(port: int, origin: str, host: str) -> int:
    """Status of the response to a WebSocket's handshake; 101: it is open."""
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", port, timeout=TIMEOUT)) as connection:
        fields = {"Host": host, "Origin": origin, "Upgrade": "websocket", "Connection": "Upgrade"}
        fields |= {"Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}
        connection.request("GET", "/", headers=fields)
        return connection.getresponse().status


def test_only_the_page_itself_connects_and_it_asks_nobody_and_gives_nothing_else_away(
    start: Start, port: int, recording: Path, tmp_path: Path
) -> None:
    """And a probe of the port leaves no trace."""
    view = start("view", "--replay", str(recording), "--port", str(port))
    until(lambda: f"the page is at http://127.0.0.1:{port}/" in view.stderr, "the page")
    status, page = get(port, "/")
    assert status == 200 and f"<title>{recording.parent.name}</title>".encode() in page
    assert not re.search(rb"(src|href)=[\"']?(https?:)?//", page)
    secret = tmp_path / "secret"
    secret.write_text("secret")
    for path in (f"/{'../' * 30}{str(secret)[1:]}", "/../__init__.py"):
        assert get(port, path)[0] == 404, path
    own = f"127.0.0.1:{port}"
    socket.create_connection(("127.0.0.1", port)).close()
    with socket.create_connection(("127.0.0.1", port)) as probe:
        probe.sendall(b"\x16\x03\x01 this is no HTTP\r\n\r\n")
    assert handshake(port, f"http://{own}", own) == 101
    assert handshake(port, "http://evil.example", own) == 403
    assert handshake(port, "http://evil.example", "evil.example") == 403
    view.interrupt()
    assert view.process.returncode == 0
    assert [line for line in view.stderr.splitlines() if "the page is at" not in line and line.strip()] == []


def test_beyond_loopback_the_page_takes_tls_and_the_token_that_is_printed(
    start: Start, port: int, recording: Path
) -> None:
    view = start("view", "--replay", str(recording), "--port", str(port), "--host", "0.0.0.0")
    told = re.compile(
        rf"https://[^/]+:{port}/\?token=([\w-]+)\s.*?((?:[0-9A-F]{{2}}:){{31}}[0-9A-F]{{2}})\s", re.DOTALL
    )
    token, fingerprint = until(lambda: told.search(view.stderr), "the page's token and fingerprint").groups()
    served = ssl.get_server_certificate(("127.0.0.1", port))
    assert hashlib.sha256(ssl.PEM_cert_to_DER_cert(served)).hexdigest().upper() == fingerprint.replace(":", "")
    trust = ssl.create_default_context(cadata=served)

    def ask(path: str, cookie: str = "") -> http.client.HTTPResponse:
        connection = http.client.HTTPSConnection("127.0.0.1", port, timeout=TIMEOUT, context=trust)
        with contextlib.closing(connection):
            connection.request("GET", path, headers={"Cookie": cookie})
            response = connection.getresponse()
            response.read()
            return response

    assert ask("/").status == 401
    opened = ask(f"/?token={token}")
    assert opened.status == 303
    assert ask("/", (opened.getheader("Set-Cookie") or "").partition(";")[0]).status == 200
    with pytest.raises((http.client.HTTPException, OSError)):
        get(port, "/")  # plain HTTP
    view.interrupt()
    assert view.process.returncode == 0


def one_sentence(said: str) -> str:
    assert "Traceback" not in said, said
    (error,) = [line for line in said.splitlines() if line.startswith("error: ")]
    return error


def test_without_its_package_it_says_so(start: Start) -> None:
    view = start("view", script=WITHOUT_WEBSOCKETS)
    assert view.wait() == 2
    assert "pip install 'nao-hil[view]'" in one_sentence(view.stderr)


def test_a_run_goes_on_without_its_page(start: Start, endpoint: str, taken: int, tmp_path: Path) -> None:
    up = ["up", "--engine", "mujoco", "--mode", "lockstep", "--serve", "--view", "--port", str(taken), "--json"]
    command = start(*up, "--listen", endpoint, "--out", str(tmp_path / "run"))
    until(lambda: "no page: The page cannot be served" in command.stderr, "the word that there is no page")
    with WalkClient("nao", endpoint, connect_timeout=TIMEOUT) as client:

        def walked() -> bool:
            try:
                status = client.status()
                if status.steps == 0 and status.state == "stand":
                    client.walk(steps=2)
            except (LinkError, WalkRefused):  # it is still starting
                return False
            return status.steps == 2 and status.state == "stand"

        until(walked, "a walk of two steps")
    command.interrupt()
    assert command.process.returncode == 0
    assert command.result["steps"] == 2
    assert command.stderr.count("no page: ") == 1
    assert "Traceback" not in command.stderr
