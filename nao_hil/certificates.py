"""A small certificate authority for the link: one key that signs, one certificate for each role.

The folder: `ca/` with the authority's key, which stays at home; a folder per role with the three files for
the machine of that role (`bridge/link/certificates.py`). Elliptic keys on P-256, signed with SHA-256. A
robot's certificate serves a server and names its hosts; the others serve clients only, so that only a robot
can answer for one.
"""

from __future__ import annotations

import datetime
import ipaddress
import os
import secrets
import ssl
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import msgspec
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from bridge.errors import ConfigurationError
from bridge.link.certificates import CA, CERTIFICATE, PRIVATE_KEY, ROLES

AUTHORITY: Final = "ca"
LOCAL_HOSTS: Final = ("localhost", "127.0.0.1", "::1")
"""A robot's certificate is always good on its own machine."""
_BACKDATED: Final = datetime.timedelta(minutes=5)
"""Validity before the issue, for a machine whose clock is a little behind."""
_AUTHORITY_YEARS: Final = 10


class KeyState(msgspec.Struct, frozen=True, kw_only=True):
    """One role's certificate."""

    role: str
    expires: str
    """ISO 8601, UTC."""
    days_left: float
    hosts: list[str]


class Keys:
    """The authority in a folder, made when it is not there.

    Raises:
        ConfigurationError: there is half of one, or the files cannot be read or written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        home = folder / AUTHORITY
        self.made = not (home / CERTIFICATE).exists() and not (home / PRIVATE_KEY).exists()
        try:
            if self.made:
                self._key, self._certificate = _new_authority(home)
            else:
                self._key, self._certificate = _load_authority(home)
        except OSError as error:
            raise ConfigurationError(f"{error.filename}: {error.strerror}.") from None

    def issue(self, role: str, days: float, hosts: Sequence[str] = ()) -> None:
        """Write key and certificate of one role; existing ones are replaced.

        Args:
            role: of `bridge.link.certificates.ROLES`.
            days: until it expires.
            hosts: names and addresses of a robot, besides `LOCAL_HOSTS`.

        Raises:
            ConfigurationError: a host that is neither name nor address, or a folder that cannot be written.
        """
        key = ec.generate_private_key(ec.SECP256R1())
        server = role == "robot"
        builder = (
            _certificate(role, self._certificate.subject, key.public_key(), datetime.timedelta(days=days))
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(
                x509.ExtendedKeyUsage(
                    [ExtendedKeyUsageOID.SERVER_AUTH if server else ExtendedKeyUsageOID.CLIENT_AUTH]
                ),
                critical=False,
            )
            .add_extension(
                x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key()), critical=False
            )
        )
        if server:
            names = _host_names(dict.fromkeys([*LOCAL_HOSTS, *hosts]))
            builder = builder.add_extension(x509.SubjectAlternativeName(names), critical=False)
        own = self.folder / role
        try:
            own.mkdir(parents=True, exist_ok=True)
            (own / CA).write_bytes(_pem(self._certificate))
            (own / CERTIFICATE).write_bytes(_pem(builder.sign(self._key, hashes.SHA256())))
            _write_key(own / PRIVATE_KEY, key)
        except OSError as error:
            raise ConfigurationError(f"{error.filename}: {error.strerror}.") from None

    def state(self) -> list[KeyState]:
        """The certificates that are there.

        Raises:
            ConfigurationError: one cannot be read.
        """
        return [_state(role, self.folder / role / CERTIFICATE) for role in self.roles()]

    def roles(self) -> list[str]:
        """The roles that have a certificate."""
        return [role for role in ROLES if (self.folder / role / CERTIFICATE).exists()]


def _state(role: str, path: Path) -> KeyState:
    try:
        certificate = x509.load_pem_x509_certificate(path.read_bytes())
    except (ValueError, OSError):
        raise ConfigurationError(f"{path} cannot be read as a certificate; --renew makes a new one.") from None
    expires = certificate.not_valid_after_utc
    left = expires - datetime.datetime.now(datetime.timezone.utc)
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        names = x509.SubjectAlternativeName([])
    return KeyState(
        role=role,
        expires=expires.isoformat(),
        days_left=round(left.total_seconds() / 86400.0, 2),
        hosts=[str(name.value) for name in names],
    )


def _new_authority(home: Path) -> tuple[ec.EllipticCurvePrivateKey, x509.Certificate]:
    key = ec.generate_private_key(ec.SECP256R1())
    title = f"nao-hil authority {secrets.token_hex(4)}"  # two of one name would be indistinguishable
    name = _name(title)
    usage = x509.KeyUsage(
        digital_signature=False,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=True,
        crl_sign=True,
        encipher_only=False,
        decipher_only=False,
    )
    span = datetime.timedelta(days=365 * _AUTHORITY_YEARS)
    certificate = (
        _certificate(title, name, key.public_key(), span)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(usage, critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .sign(key, hashes.SHA256())
    )
    home.mkdir(parents=True, mode=0o700, exist_ok=True)
    (home / CERTIFICATE).write_bytes(_pem(certificate))
    _write_key(home / PRIVATE_KEY, key)
    return key, certificate


def _load_authority(home: Path) -> tuple[ec.EllipticCurvePrivateKey, x509.Certificate]:
    try:
        key = serialization.load_pem_private_key((home / PRIVATE_KEY).read_bytes(), None)
        certificate = x509.load_pem_x509_certificate((home / CERTIFICATE).read_bytes())
    except (ValueError, TypeError):
        raise ConfigurationError(
            f"The authority in {home} cannot be read; take another folder, or remove it and renew all keys."
        ) from None
    if not isinstance(key, ec.EllipticCurvePrivateKey) or key.public_key() != certificate.public_key():
        raise ConfigurationError(
            f"Key and certificate in {home} are not of one authority; take another folder."
        )
    return key, certificate


def server_of_today(hosts: Sequence[str]) -> tuple[ssl.SSLContext, str]:
    """TLS for a server that ends today, by a certificate that signs itself and whose key is kept nowhere.

    Args:
        hosts: Names and addresses of the robot, besides `LOCAL_HOSTS`.

    Returns:
        The context, and the SHA-256 fingerprint that a browser shows: pairs of hexadecimal digits.

    Raises:
        ConfigurationError: a host that is neither name nor address.
    """
    key = ec.generate_private_key(ec.SECP256R1())
    names = x509.SubjectAlternativeName(_host_names(dict.fromkeys([*LOCAL_HOSTS, *hosts])))
    certificate = (
        _certificate("nao-hil page", _name("nao-hil page"), key.public_key(), datetime.timedelta(days=30))
        .add_extension(names, critical=False)
        .sign(key, hashes.SHA256())
    )
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    with tempfile.TemporaryDirectory() as folder:
        files = Path(folder) / CERTIFICATE, Path(folder) / PRIVATE_KEY
        files[0].write_bytes(_pem(certificate))
        _write_key(files[1], key)
        context.load_cert_chain(*files)
    return context, certificate.fingerprint(hashes.SHA256()).hex(":").upper()


def _certificate(
    name: str, issuer: x509.Name, key: ec.EllipticCurvePublicKey, span: datetime.timedelta
) -> x509.CertificateBuilder:
    now = datetime.datetime.now(datetime.timezone.utc)
    start = min(now - _BACKDATED, now + span - _BACKDATED)
    return (
        x509.CertificateBuilder()
        .subject_name(_name(name))
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(start)
        .not_valid_after(now + span)
    )


def _name(common: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common)])


def _host_names(hosts: Iterable[str]) -> list[x509.GeneralName]:
    names: list[x509.GeneralName] = []
    for host in hosts:
        try:
            names.append(x509.IPAddress(ipaddress.ip_address(host)))
            continue
        except ValueError:
            pass
        if not host or not all(c.isascii() and (c.isalnum() or c in "-._") for c in host):
            raise ConfigurationError(f"Host {host!r} must be a name such as robot.local, or an IP address.")
        names.append(x509.DNSName(host))
    return names


def _pem(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(serialization.Encoding.PEM)


def _write_key(path: Path, key: ec.EllipticCurvePrivateKey) -> None:
    """Readable by its owner only, from the first byte on."""
    pem = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    path.unlink(missing_ok=True)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(pem)
