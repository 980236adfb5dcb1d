"""Access to the page: each request is checked before it is answered.

A browser lets any web page of any site open a WebSocket to this machine, and lets a site point its own name at
127.0.0.1 (DNS rebinding). So the `Origin` of the handshake must be the page's own address, and on
loopback the address must be a loopback name. Beyond loopback a token, once given in the
address, is kept in a cookie that scripts cannot read and other sites do not send.
"""

from __future__ import annotations

import secrets
import socket
import ssl
from dataclasses import dataclass
from hmac import compare_digest
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from typing import Final
from urllib.parse import parse_qs, urlsplit

from bridge.link.session import is_loopback

COOKIE: Final = "nao-hil-page"


@dataclass(frozen=True)
class Door:
    """The access rule and its TLS."""

    access: Access
    tls: ssl.SSLContext | None = None
    fingerprint: str = ""
    """SHA-256 of the certificate; empty without TLS."""

    def address(self, host: str, port: int) -> str:
        """The address to open in a browser: with the token, where there is one."""
        name = socket.gethostname() if _is_any(host) else host
        name = f"[{name}]" if ":" in name else name
        if self.access.token is None:
            return f"http://{name}:{port}/"
        return f"https://{name}:{port}/?token={self.access.token}"


def open_door(host: str) -> Door:
    """The access checks of a page that listens at `host`.

    Raises:
        ConfigurationError: it is neither a name nor an address.
    """
    if is_loopback(host):
        return Door(Access())
    from nao_hil.certificates import server_of_today

    own = socket.gethostname()
    tls, fingerprint = server_of_today([own] if _is_any(host) else [own, host])
    return Door(Access(secrets.token_urlsafe(24), tls=True), tls, fingerprint)


def _is_any(host: str) -> bool:
    """Whether this means all addresses of the machine."""
    try:
        return ip_address(host).is_unspecified
    except ValueError:
        return False


@dataclass(frozen=True)
class Asked:
    """A request: its target and the headers that count; each is empty where it is missing or given twice."""

    target: str
    host: str
    origin: str = ""
    cookie: str = ""
    upgrade: str = ""


@dataclass(frozen=True)
class Answer:
    """The response to a request that is not a WebSocket's handshake, or to a refused one."""

    status: HTTPStatus
    body: bytes = b""
    headers: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Access:
    """The rule.

    Args:
        token: Secret of the page; None: no secret, but only loopback names are answered.
        tls: The page is served over TLS.
    """

    token: str | None = None
    tls: bool = False

    def check(self, asked: Asked) -> Answer | None:
        """The refusal of a request, or the cookie for its token; None: the request is allowed."""
        name = _name(asked.host)
        if self.token is None and not is_loopback(name):
            return Answer(HTTPStatus.FORBIDDEN, b"This page answers at localhost and 127.0.0.1 only.\n")
        address = urlsplit(asked.target)
        if self.token is not None:
            given = parse_qs(address.query).get("token", [""])[0]
            if self._knows(given):
                cookie = f"{COOKIE}={given}; Path=/; HttpOnly; SameSite=Strict" + "; Secure" * self.tls
                return Answer(HTTPStatus.SEE_OTHER, b"", (("Set-Cookie", cookie), ("Location", ".")))
            if not self._knows(_cookie(asked.cookie)):
                return Answer(
                    HTTPStatus.UNAUTHORIZED, b"Open the address with the token that `nao-hil view` printed.\n"
                )
        if asked.upgrade:
            own = f"{'https' if self.tls else 'http'}://{asked.host}"
            if asked.origin != own:
                return Answer(HTTPStatus.FORBIDDEN, b"Only the page itself may connect.\n")
        return None

    def _knows(self, given: str) -> bool:
        # a header may hold surrogates, which are no UTF-8
        return self.token is not None and compare_digest(given.encode(errors="replace"), self.token.encode())


def _name(host: str) -> str:
    """The name in a `Host` header."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _cookie(header: str) -> str:
    try:
        kept = SimpleCookie(header).get(COOKIE)
    except CookieError:
        return ""
    return kept.value if kept is not None else ""
