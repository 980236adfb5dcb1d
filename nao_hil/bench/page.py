"""What the live page costs the robot's real-time cycle: a walk without it, and with it and a looker-on."""

from __future__ import annotations

import socket
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import msgspec

from bridge.errors import LinkError
from nao_hil.runs.supervisor import Child, free_endpoint
from nao_hil.view.child import READY, LivePage

TIMEOUT: float = 60.0
"""s for a page to be served."""
LOADING: float = 3.0
"""s until a robot walks, and a page has met it."""
LOOK = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (1.0, 0.0, 0.5),
    "fov": 1.0,
    "near": 0.01,
    "far": 100.0,
    "image_height": 800,
    "image_width": 1280,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""What a browser says first; from then on it is sent pictures."""


def measure(seconds: float = 15.0, rounds: int = 2) -> dict[str, Any]:
    """A walking robot's process without and with a page, in turn.

    A browser would draw on the graphics card; here, where there may be none, somebody only takes what the page
    sends, so that what is measured is the page.

    Returns:
        For both: p50, p99 and max of the lateness, s, and cycles missed, the worst of the rounds each; and what
        the page sent, messages per second.

    Raises:
        LinkError: one of the processes failed.
    """
    without, beside, sent = [], [], 0.0
    for _ in range(rounds):
        without.append(_walk(seconds, None))
        eye = _Eye()
        beside.append(_walk(seconds, eye))
        sent = eye.messages / seconds
    return {
        "seconds": seconds,
        "rounds": rounds,
        "without": _worst(without),
        "with_page": _worst(beside),
        "page_messages_per_second": sent,
    }


class _Eye:
    """Somebody who looks at a page: takes everything, draws nothing."""

    def __init__(self) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = int(probe.getsockname()[1])
        self.messages = 0
        self._stop = threading.Event()

    def look(self) -> None:
        """Until `close`."""
        import viser
        from websockets.exceptions import ConnectionClosed
        from websockets.sync.client import connect
        from websockets.typing import Origin, Subprotocol

        own = f"127.0.0.1:{self.port}"
        protocol = Subprotocol(f"viser-v{viser.__version__}")
        with connect(
            f"ws://{own}",
            origin=Origin(f"http://{own}"),
            subprotocols=[protocol],
            max_size=None,
            compression=None,
        ) as page:
            page.send(msgspec.msgpack.encode(LOOK))
            while not self._stop.is_set():
                try:
                    page.recv(timeout=0.1)
                    self.messages += 1
                except TimeoutError:
                    continue
                except ConnectionClosed:
                    return

    def close(self) -> None:
        """Look away."""
        self._stop.set()


def _walk(seconds: float, eye: _Eye | None) -> dict[str, float]:
    endpoint = free_endpoint()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        robot = Child("robot", ["emulate", "--listen", endpoint, "--out", name, "--json"], folder)
        walker = Child("walker", ["walk", "--connect", endpoint, "--steps", "0"], folder)
        page = LivePage("nao", endpoint, eye.port, folder) if eye is not None else None
        if page is not None:
            _wait(page)
        time.sleep(LOADING)
        if eye is not None:
            threading.Thread(target=eye.look, daemon=True).start()
        time.sleep(seconds)
        walker.end(5.0)
        outcome = robot.end(5.0)
        if eye is not None and page is not None:
            eye.close()
            page.end(5.0)
            if eye.messages == 0:
                raise LinkError("the page sent nothing to somebody who looks at it.")
    if outcome.result is None:
        raise LinkError(f"the robot's process failed: {outcome.error}")
    lateness: dict[str, float] = outcome.result["timing"]["lateness"]
    return lateness | {"missed": outcome.result["cycles_missed"]}


def _wait(page: LivePage) -> None:
    deadline = time.monotonic() + TIMEOUT
    while READY not in page.stderr:
        if not page.running or time.monotonic() > deadline:
            raise LinkError(f"the page was not served: {page.end(1.0).error}")
        time.sleep(0.1)


def _worst(rounds: list[dict[str, float]]) -> dict[str, float]:
    return {name: max(r[name] for r in rounds) for name in ("p50", "p99", "max", "missed")}
