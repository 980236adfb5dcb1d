"""Who may open the page, request by request, and who may not."""

from __future__ import annotations

import ssl

import pytest

from bridge.errors import ConfigurationError
from nao_hil.view.access import COOKIE, Access, Asked, open_door

LOCAL = Access()
TOKEN = "k3y"
GUARDED = Access(TOKEN, tls=True)


def status(access: Access, asked: Asked) -> int | None:
    """Status of a refusal or of the answer to a token; None: the request goes on."""
    answer = access.check(asked)
    return None if answer is None else answer.status.value


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "localhost:8080", "[::1]:8080", "localhost:9000"])
def test_on_loopback_the_page_opens_and_connects_from_its_own_address(host: str) -> None:
    assert status(LOCAL, Asked("/", host)) is None
    assert status(LOCAL, Asked("/", host, origin=f"http://{host}", upgrade="websocket")) is None


@pytest.mark.parametrize(
    "origin",
    [
        "",  # no browser leaves it out
        "null",  # a sandboxed frame, a file
        "http://evil.example",
        "https://127.0.0.1:8080",  # another scheme
        "http://127.0.0.1:3000",  # another server of this machine
        "http://localhost:8080",  # another name is another origin
        "http://127.0.0.1:8080.evil.example",
    ],
)
def test_a_handshake_from_elsewhere_is_refused(origin: str) -> None:
    for upgrade in ("websocket", "WebSocket", "h2c, websocket"):
        assert status(LOCAL, Asked("/", "127.0.0.1:8080", origin=origin, upgrade=upgrade)) == 403


@pytest.mark.parametrize(
    "host", ["", "evil.example:8080", "127.0.0.1.evil.example", "192.168.1.7:8080", "[::1"]
)
def test_on_loopback_another_name_is_refused_also_with_an_origin_that_fits(host: str) -> None:
    assert status(LOCAL, Asked("/", host)) == 403
    assert status(LOCAL, Asked("/", host, origin=f"http://{host}", upgrade="websocket")) == 403


def test_beyond_loopback_nothing_is_answered_without_the_token() -> None:
    host = "robot.example:8080"
    for cookie in ("", f"{COOKIE}=other", f"{COOKIE}=", "other=k3y", f"{COOKIE}={TOKEN}x"):
        assert status(GUARDED, Asked("/", host, cookie=cookie)) == 401
        handshake = Asked("/", host, origin=f"https://{host}", cookie=cookie, upgrade="websocket")
        assert status(GUARDED, handshake) == 401
    assert status(GUARDED, Asked("/?token=other", host)) == 401


def test_the_token_becomes_a_cookie_that_opens_the_page() -> None:
    host = "robot.example:8080"
    answer = GUARDED.check(Asked(f"/?token={TOKEN}", host))
    assert answer is not None and answer.status.value == 303 and not answer.body
    headers = dict(answer.headers)
    assert headers["Location"] == "."  # the token does not stay in the address
    kept, *flags = headers["Set-Cookie"].split("; ")
    assert {"HttpOnly", "SameSite=Strict", "Secure"} <= set(flags)
    assert status(GUARDED, Asked("/", host, cookie=kept)) is None
    own = Asked("/", host, origin=f"https://{host}", cookie=kept, upgrade="websocket")
    assert status(GUARDED, own) is None
    foreign = Asked("/", host, origin="https://evil.example", cookie=kept, upgrade="websocket")
    assert status(GUARDED, foreign) == 403


def test_beyond_loopback_there_is_tls_and_a_token_of_its_own() -> None:
    first, second = open_door("0.0.0.0"), open_door("0.0.0.0")
    assert isinstance(first.tls, ssl.SSLContext) and first.access.tls
    assert first.access.token and first.access.token != second.access.token
    assert f"?token={first.access.token}" in first.address("0.0.0.0", 8080)
    assert first.address("192.168.1.7", 8080).startswith("https://192.168.1.7:8080/")
    assert open_door("127.0.0.1").address("127.0.0.1", 8080) == "http://127.0.0.1:8080/"
    with pytest.raises(ConfigurationError, match="must be a name"):
        open_door("not a host")
