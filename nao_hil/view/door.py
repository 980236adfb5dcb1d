"""What guards the page at an address: nothing more than its own origin on loopback, TLS and a token beyond."""

from __future__ import annotations

import secrets
import socket
import ssl
from dataclasses import dataclass
from ipaddress import ip_address

from bridge.errors import ConfigurationError
from bridge.link.session import is_loopback
from nao_hil.view.access import Access


@dataclass(frozen=True)
class Door:
    """The access rule and its TLS."""

    access: Access
    tls: ssl.SSLContext | None = None
    fingerprint: str = ""
    """SHA-256 of the certificate; empty without TLS."""

    def address(self, host: str, port: int) -> str:
        """What to open in a browser: with the token, where there is one."""
        name = socket.gethostname() if _is_any(host) else host
        name = f"[{name}]" if ":" in name else name
        if self.access.token is None:
            return f"http://{name}:{port}/"
        return f"https://{name}:{port}/?token={self.access.token}"


def open_door(host: str) -> Door:
    """What guards a page that listens at `host`.

    Raises:
        ConfigurationError: TLS needs a package that is not installed.
    """
    if is_loopback(host):
        return Door(Access())
    try:
        from nao_hil.certificates import server_of_today
    except ModuleNotFoundError as error:
        raise ConfigurationError(
            f"A page beyond loopback is served over TLS, which needs the package {error.name}; "
            "pip install 'nao-hil[view]' brings it."
        ) from None
    own = socket.gethostname()
    tls, fingerprint = server_of_today([own] if _is_any(host) else [own, host])
    return Door(Access(secrets.token_urlsafe(24), tls=True), tls, fingerprint)


def _is_any(host: str) -> bool:
    """Whether this stands for all addresses of the machine."""
    try:
        return ip_address(host).is_unspecified
    except ValueError:
        return False
