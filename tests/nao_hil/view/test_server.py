"""The page's server: browsers, answers and strangers."""

from __future__ import annotations

import json
import socket
import threading
import time
from http.client import HTTPConnection
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from nao_hil.view.access import Access
from nao_hil.view.page import page
from nao_hil.view.server import MAX_BACKLOG, PING_INTERVAL, Browser, Message, PageServer
from tests.loops import TIMEOUT, until
from tests.ports import free_port


def test_a_page_is_absent_once_its_browser_does_not_answer() -> None:
    """Also where its connection stays open: a laptop that sleeps, a cable that is out."""
    pings = list[threading.Event]()
    connection = SimpleNamespace(send=lambda _: None, ping=lambda: pings.append(threading.Event()) or pings[-1])
    browser = Browser(connection, lambda: None)
    browser.start()
    until(lambda: pings, "a ping")
    asked = browser.seen
    until(lambda: time.monotonic() - asked > 3 * PING_INTERVAL, "the time of some pings")
    assert browser.seen == asked
    browser.end(1.0)


def test_a_browser_that_is_behind_gets_the_run_again_and_every_answer() -> None:
    sent, end = list[Any](), threading.Event()

    def send(message: Any) -> None:
        end.wait(TIMEOUT)
        sent.append(message)

    browser = Browser(SimpleNamespace(send=send, ping=threading.Event), lambda: b"the run")
    server: Any = SimpleNamespace(_order=lambda text: (text, True))
    browser.start()
    for i in range(MAX_BACKLOG + 2):
        if i in (0, MAX_BACKLOG):
            PageServer._answer(server, browser, f"answer {i}", urgent=False)
        browser.put(Message(b"a row"))
    PageServer._answer(server, browser, "the last answer", urgent=False)
    end.set()
    browser.end(TIMEOUT)
    words = [json.loads(message)["answer"] for message in sent if isinstance(message, str) and message != "{}"]
    assert words == ["answer 0", f"answer {MAX_BACKLOG}", "the last answer"]
    assert b"the run" in sent and sent.count(b"a row") < 10


def test_an_order_that_fails_by_a_fault_is_answered() -> None:
    said = list[Message]()
    server: Any = SimpleNamespace(_order=lambda text: {}[text])
    PageServer._answer(server, SimpleNamespace(put=said.append), "walk", urgent=True)  # type: ignore[arg-type]
    (answer,) = (json.loads(message.data) for message in said)
    assert "KeyError('walk')" in answer["answer"] and not answer["done"] and answer["urgent"]


def test_every_answer_of_the_page_has_a_content_security_policy_and_its_script_is_named() -> None:
    port = free_port()
    server = PageServer("127.0.0.1", port, Access())
    server.show(*page("policy"))
    try:
        for path, source in (("/", "script-src 'sha256-"), ("/nothing", "default-src 'none'")):
            connection = HTTPConnection("127.0.0.1", port, timeout=TIMEOUT)
            connection.request("GET", path)
            policy = connection.getresponse().headers["Content-Security-Policy"]
            assert source in policy and "frame-ancestors 'none'" in policy and "unsafe-eval" not in policy
            connection.close()
    finally:
        server.close()


@pytest.mark.parametrize("seed", sorted(Path("tests/fuzz/corpus/page").iterdir()), ids=lambda file: file.name)
def test_whatever_a_stranger_sends_the_next_one_gets_the_page(seed: Path) -> None:
    port = free_port()
    server = PageServer("127.0.0.1", port, Access())
    server.show(*page("policy"))
    try:
        with socket.create_connection(("127.0.0.1", port), TIMEOUT) as stranger:
            stranger.sendall(seed.read_bytes())
            connection = HTTPConnection("127.0.0.1", port, timeout=TIMEOUT)
            connection.request("GET", "/")
            assert connection.getresponse().status == 200
            connection.close()
    finally:
        server.close()
