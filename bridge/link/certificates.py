"""Certificates of the link: a folder of three PEM files, checked for role and validity before a connection.

An endpoint names the folder behind `#keys=`, as in `tls/robot.local:7447#keys=keys/controller`: wherever an
endpoint is passed (an option, a child process, a client), its certificates are too. A folder that holds one
per role (as `nao-hil keys` makes it) serves all roles; each takes its own.
"""

from __future__ import annotations

import socket
import ssl
from pathlib import Path
from typing import Any, Final, NamedTuple

from bridge.errors import ConfigurationError, LinkError

ROLES: Final = ("robot", "controller", "listener", "world")
"""Roles of the link's parties; the common name of the certificate."""
CA: Final = "ca.pem"
CERTIFICATE: Final = "certificate.pem"
PRIVATE_KEY: Final = "key.pem"
KEYS_MARK: Final = "#keys="
OPEN_MARK: Final = "#open"
"""Ends a robot's endpoint beyond loopback that anyone may use."""

_FOREIGN_AUTHORITY: Final = "it is of another authority; take all folders from one `nao-hil keys DIR`"
_CAUSES: Final = {
    "unable to get local issuer certificate": _FOREIGN_AUTHORITY,
    "self-signed certificate in certificate chain": _FOREIGN_AUTHORITY,
    "certificate has expired": "it has expired; `nao-hil keys DIR --renew` makes a new one",
    "unsuitable certificate purpose": "it is made for another role",
}
"""OpenSSL's messages, with their causes."""
_HINT: Final = "`nao-hil keys DIR` makes them"
_CONNECT_TIMEOUT: Final = 1.0
"""s for the system to connect to a place where somebody listens."""
_HANDSHAKE_TIMEOUT: Final = 5.0
"""s for a handshake that finds the reason of a failed one."""


class Certificates(NamedTuple):
    """Files of one party."""

    role: str
    ca: Path
    certificate: Path
    private_key: Path


def split_endpoint(endpoint: str) -> tuple[str, Path | None]:
    """Locator and folder of certificates of an endpoint."""
    locator, mark, folder = endpoint.removesuffix(OPEN_MARK).partition(KEYS_MARK)
    return locator, Path(folder) if mark else None


def with_keys(endpoint: str, folder: Path | None) -> str:
    """The endpoint with its folder of certificates; unchanged for None.

    Raises:
        ConfigurationError: the endpoint names other ones already.
    """
    if folder is None:
        return endpoint
    if KEYS_MARK in endpoint:
        raise ConfigurationError(f"Endpoint {endpoint!r} names its keys already; leave --keys out.")
    return f"{endpoint}{KEYS_MARK}{folder}"


def load_certificates(folder: Path, role: str) -> Certificates:
    """The files of one party, checked: complete, matching, signed by the authority, of the role, not expired.

    Args:
        folder: of the role itself, or with a folder of that name.
        role: of `ROLES`; a `listener` may be anyone who is not a robot, for all may listen.

    Raises:
        ConfigurationError: names the file and its fault.
    """
    own = folder / role if (folder / role).is_dir() else folder
    paths = [own / name for name in (CA, CERTIFICATE, PRIVATE_KEY)]
    if not folder.is_dir():
        raise ConfigurationError(f"There is no folder {folder} of certificates; {_HINT}.")
    for path in paths:
        if not path.is_file():
            raise ConfigurationError(f"No {path.name} in {own} for the role {role}; {_HINT}.")
    certificates = Certificates(role, *paths)
    certified = _verified_role(certificates)
    if certified != role and not (role == "listener" and certified in ROLES and certified != "robot"):
        raise ConfigurationError(f"{paths[1]} is for the role {certified or 'of none'}; {role} is needed here.")
    return certificates


def check_certificates(endpoint: str, role: str) -> None:
    """Check the certificates that an endpoint names, if it names any.

    Raises:
        ConfigurationError: as `load_certificates`.
    """
    _, folder = split_endpoint(endpoint)
    if folder is not None:
        load_certificates(folder, role)


def _verified_role(files: Certificates) -> str:
    """Common name of the certificate, by a handshake in memory with its files."""
    client, server = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT), ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    client.check_hostname = False
    client.verify_mode = ssl.CERT_NONE
    checks = client if files.role == "robot" else server
    try:
        checks.load_verify_locations(files.ca)
    except (ssl.SSLError, OSError, UnicodeError):
        raise ConfigurationError(f"{files.ca} cannot be read as a certificate in PEM form; {_HINT}.") from None
    checks.verify_mode = ssl.CERT_REQUIRED
    for context in (client, server):
        _load_chain(context, files)
    try:
        return _common_name(_handshake(client, server, by_server=checks is server))
    except ssl.SSLCertVerificationError as error:
        raise ConfigurationError(
            f"{files.certificate} is refused for the role {files.role}: {_cause(error)}."
        ) from None
    except ssl.SSLError as error:
        raise ConfigurationError(
            f"{files.certificate} cannot be used: {error.reason or error}; {_HINT}."
        ) from None


def _load_chain(context: ssl.SSLContext, files: Certificates) -> None:
    try:
        context.load_cert_chain(files.certificate, files.private_key, password=lambda: b"")
    except ssl.SSLError as error:
        if error.reason == "KEY_VALUES_MISMATCH":
            sentence = f"{files.private_key} is not the key of {files.certificate}"
        else:
            sentence = f"{files.certificate} or {files.private_key} cannot be read in PEM form"
        raise ConfigurationError(f"{sentence}; {_HINT}.") from None
    except OSError as error:
        raise ConfigurationError(f"{files.private_key} cannot be read: {error.strerror}.") from None


def _handshake(client: ssl.SSLContext, server: ssl.SSLContext, *, by_server: bool) -> dict[str, Any]:
    """Certificate of the peer, as seen by the side that verifies."""
    up, down = ssl.MemoryBIO(), ssl.MemoryBIO()
    sides = [client.wrap_bio(down, up), server.wrap_bio(up, down, server_side=True)]
    waiting = list(sides)
    while waiting:
        for side in list(waiting):
            try:
                side.do_handshake()
                waiting.remove(side)
            except ssl.SSLWantReadError:
                continue
    return dict(sides[by_server].getpeercert() or {})


def _cause(error: ssl.SSLCertVerificationError) -> str:
    return _CAUSES.get(error.verify_message, error.verify_message.rstrip("."))


def _common_name(certificate: dict[str, Any]) -> str:
    for part in certificate.get("subject", ()):
        for name, value in part:
            if name == "commonName":
                return str(value)
    return ""


def check_peer(locator: str, files: Certificates) -> None:
    """Find the reason of a refused connection by a handshake of its own.

    Raises nothing without a listener or a reason.

    Raises:
        LinkError: one side does not trust the other's certificate.
    """
    host, _, port = locator.partition("/")[2].rpartition(":")
    host = host.strip("[]")
    context = ssl.create_default_context(cafile=str(files.ca))
    context.load_cert_chain(files.certificate, files.private_key)
    try:
        with (
            socket.create_connection((host, int(port)), _CONNECT_TIMEOUT) as plain,
            context.wrap_socket(plain, server_hostname=host, do_handshake_on_connect=False) as link,
        ):
            link.settimeout(_HANDSHAKE_TIMEOUT)
            link.do_handshake()
            link.recv(1)  # in TLS 1.3 the server judges the client after the handshake
    except ssl.SSLCertVerificationError as error:
        why = _cause(error)
        if "mismatch" in why.lower():
            renew = f"`nao-hil keys DIR --role robot --renew --host {host}`"
            why = f"its certificate is not made for {host}; {renew} makes one that is"
        raise LinkError(f"The robot at {locator} is not trusted: {why}.") from None
    except ssl.SSLError as error:
        reason = (error.reason or str(error)).lower().replace("_", " ")
        raise LinkError(f"The robot at {locator} refuses {files.certificate}: {reason}.") from None
    except OSError:
        return
