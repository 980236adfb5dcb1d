"""The authority's certificates, judged by OpenSSL's rules, and the sentences for bad ones."""

from __future__ import annotations

import shutil
import stat
from pathlib import Path

import pytest

from bridge.errors import ConfigurationError
from bridge.link.certificates import ROLES, load_certificates
from nao_hil.certificates import Keys


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    keys = Keys(tmp_path / "keys")
    for role in ROLES:
        keys.issue(role, days=1.0, hosts=["robot.local", "10.0.0.7"])
    return tmp_path / "keys"


@pytest.mark.parametrize("role", ROLES)
def test_each_role_has_what_it_needs_and_no_more(folder: Path, role: str) -> None:
    files = load_certificates(folder, role)
    assert files == load_certificates(folder / role, role)
    assert sorted(path.name for path in (folder / role).iterdir()) == ["ca.pem", "certificate.pem", "key.pem"]
    assert stat.S_IMODE(files.private_key.stat().st_mode) == 0o600


def test_a_role_is_not_taken_for_another(folder: Path) -> None:
    with pytest.raises(ConfigurationError, match="for the role listener; controller is needed"):
        load_certificates(folder / "listener", "controller")
    # A client's certificate does not make a robot: it must not serve.
    with pytest.raises(ConfigurationError, match="refused for the role robot: it is made for another role"):
        load_certificates(folder / "controller", "robot")


def test_an_expired_certificate_is_named_with_the_way_out(folder: Path) -> None:
    Keys(folder).issue("controller", days=-1.0)
    with pytest.raises(ConfigurationError, match=r"it has expired.*--renew"):
        load_certificates(folder, "controller")


def test_a_stranger_to_the_authority_is_refused(folder: Path, tmp_path: Path) -> None:
    other = Keys(tmp_path / "other")
    other.issue("controller", days=1.0)
    shutil.copy(folder / "controller" / "ca.pem", tmp_path / "other" / "controller" / "ca.pem")
    with pytest.raises(ConfigurationError, match=r"controller/certificate\.pem is refused"):
        load_certificates(tmp_path / "other", "controller")


@pytest.mark.parametrize("name", ["ca.pem", "certificate.pem", "key.pem"])
def test_a_missing_or_broken_file_is_named(folder: Path, name: str) -> None:
    path = folder / "controller" / name
    path.write_bytes(b"\x00\xffnot a certificate")
    with pytest.raises(ConfigurationError, match=name):
        load_certificates(folder, "controller")
    path.unlink()
    with pytest.raises(ConfigurationError, match=f"No {name} in"):
        load_certificates(folder, "controller")


def test_a_foreign_private_key_is_named(folder: Path) -> None:
    shutil.copy(folder / "listener" / "key.pem", folder / "controller" / "key.pem")
    with pytest.raises(ConfigurationError, match=r"key.pem is not the key of"):
        load_certificates(folder, "controller")


def test_an_authority_is_kept_and_a_broken_one_told(folder: Path) -> None:
    before = (folder / "ca" / "certificate.pem").read_bytes()
    assert not Keys(folder).made
    assert (folder / "ca" / "certificate.pem").read_bytes() == before
    (folder / "ca" / "key.pem").write_text("gone")
    with pytest.raises(ConfigurationError, match="cannot be read"):
        Keys(folder)
