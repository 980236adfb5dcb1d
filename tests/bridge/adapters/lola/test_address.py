from __future__ import annotations

import socket
from pathlib import Path

import pytest

from bridge.adapters.lola.address import Address, connect, listen, parse_address, remove
from bridge.errors import ConfigurationError, LinkError
from tests.ports import free_port


def test_a_path_or_a_host_and_a_port() -> None:
    assert parse_address("/tmp/robocup") == Address(path="/tmp/robocup")
    assert parse_address("./robocup") == Address(path="./robocup")
    assert parse_address("192.168.1.7:10000") == Address(host="192.168.1.7", port=10000)
    assert parse_address("[::1]:10000") == Address(host="::1", port=10000)


@pytest.mark.parametrize("text", ["robocup", "10.0.0.1", "10.0.0.1:0", "host:", ":10000", "host:99999"])
def test_anything_else_is_refused_in_one_sentence(text: str) -> None:
    with pytest.raises(ConfigurationError, match=r"must be a path with a `/`.*or HOST:PORT"):
        parse_address(text)


def test_a_socket_that_a_dead_server_left_is_replaced(tmp_path: Path) -> None:
    address = Address(path=str(tmp_path / "robocup"))
    with listen(address):
        pass
    assert (tmp_path / "robocup").exists()
    with listen(address) as listener, connect(address, 1.0) as peer, listener.accept()[0] as other:
        peer.sendall(b"x")
        assert other.recv(1) == b"x"
    remove(address)
    assert not (tmp_path / "robocup").exists()


def test_the_path_is_there_once_a_client_can_connect(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, seen, begin = tmp_path / "robocup", [], socket.socket.listen

    def watched(listener: socket.socket) -> None:
        seen.append(path.exists())
        begin(listener)

    monkeypatch.setattr(socket.socket, "listen", watched)
    address = Address(path=str(path))
    with listen(address), connect(address, 1.0):
        assert seen == [False]
    assert [each.name for each in tmp_path.iterdir()] == ["robocup"]


def test_where_somebody_listens_or_a_file_is_nobody_else_listens(tmp_path: Path) -> None:
    address = Address(path=str(tmp_path / "robocup"))
    with listen(address), pytest.raises(LinkError, match="another server does"):
        listen(address)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(LinkError, match="no socket; name another path"):
        listen(Address(path=str(tmp_path / "file")))
    assert (tmp_path / "file").read_text() == "mine"
    with pytest.raises(LinkError, match="Cannot listen on"):
        listen(Address(path=str(tmp_path / "nowhere" / "robocup")))


def test_over_tcp_small_packets_go_out_at_once() -> None:
    address = Address(host="127.0.0.1", port=free_port())
    with listen(address), connect(address, 1.0) as peer:
        assert peer.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        with pytest.raises(LinkError, match="in use"):
            listen(address)
