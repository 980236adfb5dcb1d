"""Relays LoLA's unix socket over TCP. Runs on the robot: one file, no package, Python 2.7 or 3.

    python relay.py --listen 0.0.0.0:10000 --socket /tmp/robocup

One client at a time, as on the socket itself. There is no password: any client of the port moves the robot, so
listen on an address that only your machine reaches.
"""
# ruff: noqa: UP024, UP031  (Python 2 reads it too)

import argparse
import select
import socket
import sys

READ = 65536
WAITING = 262144  # bytes kept for a side that does not read, some 3 s of packets; then the connection ends


def log(text):
    # type: (str) -> None
    """One line on stderr."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def relay(client, robot):
    # type: (socket.socket, socket.socket) -> str
    """Pass bytes both ways until one side ends; the reason of the end."""
    names = {client: "the client", robot: "LoLA"}
    other = {client: robot, robot: client}
    waiting = {client: bytearray(), robot: bytearray()}
    client.setblocking(False)
    robot.setblocking(False)
    proven = False  # a web browser reaches this port too; it begins with an HTTP method, LoLA with a map
    while True:
        readable, writable, _ = select.select(list(other), [s for s in waiting if waiting[s]], [])
        try:
            for side in readable:
                data = side.recv(READ)
                if not data:
                    return names[side] + " closed"
                if side is client and not proven:
                    first = bytearray(data)[0]
                    proven = first & 0xF0 == 0x80 or first in (0xDE, 0xDF)
                    if not proven:
                        return names[side] + " does not begin with a map"
                waiting[other[side]] += data
            for side in set(writable) | set(other[side] for side in readable):
                if waiting[side]:
                    del waiting[side][: side.send(bytes(waiting[side]))]
        except socket.error as error:
            if error.errno not in (11, 35):  # EAGAIN: later
                return str(error)
        for side in other:
            if len(waiting[side]) > WAITING:
                return names[side] + " does not read"


def serve(host, port, path):
    # type: (str, int, str) -> None
    """Serve one client after the other."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.bind((host, port))
    listener.listen(1)
    log("relaying %s to %s:%d" % (path, host, listener.getsockname()[1]))
    while True:
        client, address = listener.accept()
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        robot = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            robot.connect(path)
            log("client %s connected" % address[0])
            log("client %s disconnected: %s" % (address[0], relay(client, robot)))
        except socket.error as error:
            log("no LoLA at %s: %s" % (path, error))
        client.close()
        robot.close()


def main():
    # type: () -> None
    """The command line."""
    parser = argparse.ArgumentParser(description="Relay LoLA's unix socket over TCP, for one client at a time.")
    parser.add_argument("--listen", default="127.0.0.1:10000", metavar="HOST:PORT", help="default: %(default)s")
    parser.add_argument("--socket", default="/tmp/robocup", metavar="PATH", help="default: %(default)s")
    arguments = parser.parse_args()
    host, _, port = arguments.listen.rpartition(":")
    if not host or not port.isdigit():
        parser.error("--listen %s must be HOST:PORT" % arguments.listen)
    try:
        serve(host, int(port), arguments.socket)
    except KeyboardInterrupt:
        pass
    except socket.error as error:
        sys.exit("error: cannot listen on %s: %s" % (arguments.listen, error))


if __name__ == "__main__":
    main()
