"""Relays LoLA's unix socket over TCP. Runs on the robot: one file, no package, Python 2.7 or 3.

    python relay.py --listen 0.0.0.0:10000 --socket /tmp/robocup

One client at a time, as on the socket itself. There is no password: any client of the port moves the robot, so
listen on an address that only your machine reaches.

LoLA keeps the last command for ever. When a client that has commanded the robot ends, or sends nothing for one
second (its process hangs, the cable is out), the relay disconnects it and lowers the stiffness of all joints to
0 in two seconds; so it does when it ends itself, by Ctrl-C, SIGTERM or SIGHUP. LoLA's packets are the clock,
because the robot's wall clock may jump.
"""
# ruff: noqa: UP004, UP024, UP031, UP041  (Python 2 reads it too)

import argparse
import select
import signal
import socket
import struct
import sys

READ = 65536
WAITING = 262144  # bytes kept for a side that does not read, some 3 s of packets; then the connection ends
LONGEST = 4096  # bytes of a client's map; LoLA's own have up to 786
PACKET = 896  # bytes of each packet of LoLA's; one comes every 12 ms
SILENCE = 83 * PACKET  # bytes from LoLA without any from the client
RELEASE = 167  # packets that the ramp of the stiffness takes
WAIT = 0.1  # s for each of these packets
JOINTS = 25
STIFFNESS = b"\xa9Stiffness\xdc\x00\x19"  # key, and head of an array of 25: 0xca and a float 32 each
SIZES = {0xC0: 0, 0xC2: 0, 0xC3: 0, 0xCA: 4, 0xCB: 8, 0xCC: 1, 0xCD: 2, 0xCE: 4, 0xCF: 8}
SIZES.update({0xD0: 1, 0xD1: 2, 0xD2: 4, 0xD3: 8})  # bytes behind the first one of msgpack's scalars


def log(text):
    # type: (str) -> None
    """One line on stderr, if it is still open."""
    try:
        sys.stderr.write(text + "\n")
        sys.stderr.flush()
    except (IOError, OSError):
        pass


def end_of(data, at, depth=0):
    # type: (bytearray, int, int) -> int
    """Index behind a value of msgpack.

    Args:
        data: received bytes.
        at: index of the value's first byte.
        depth: 0 a map, 1 its keys and values, 2 the elements of an array.

    Raises:
        IndexError: the value is not complete.
        ValueError: LoLA takes no such value there.
    """
    code = data[at]
    count = code & 0x0F
    at += 1
    if code in (0xDC, 0xDE):
        count = data[at] << 8 | data[at + 1]
        at += 2
    if depth == 0 and (0x80 <= code < 0x90 or code == 0xDE):
        count *= 2
    elif depth == 1 and (0x90 <= code < 0xA0 or code == 0xDC):
        pass
    elif depth > 0 and (code < 0x80 or code >= 0xE0 or code in SIZES or 0xA0 <= code < 0xC0):
        at += code & 0x1F if 0xA0 <= code < 0xC0 else SIZES.get(code, 0)
        if at > len(data):
            raise IndexError
        return at
    else:
        raise ValueError
    for _ in range(count):
        at = end_of(data, at, depth + 1)
    return at


def whole_maps(data):
    # type: (bytearray) -> int
    """Length of the whole maps that some bytes begin with.

    Raises:
        ValueError: the bytes behind them begin no map of LoLA's, or one that is too long.
    """
    end = 0
    try:
        while end < len(data):
            end = end_of(data, end)
    except IndexError:
        pass
    if len(data) - end > LONGEST:
        raise ValueError
    return end


class Relay(object):
    """Packets to a client and whole maps to LoLA, until one side ends.

    Half a map of a client that has ended would spoil the relay's own.

    Args:
        client: connected socket.
        robot: connection to LoLA.
    """

    def __init__(self, client, robot):
        # type: (socket.socket, socket.socket) -> None
        self.client, self.robot = client, robot
        self.names = {client: "the client", robot: "LoLA"}
        self.waiting = {client: bytearray(), robot: bytearray()}  # bytes to each side
        self.partial = bytearray()  # of the client's next map
        self.newest = bytearray()  # from LoLA, with at least one whole packet
        self.commanded = False  # a map went to LoLA
        self.silence = 0  # bytes from LoLA since the client's last ones

    def run(self):
        # type: () -> str
        """Pass bytes both ways; the reason of the end."""
        self.client.setblocking(False)
        self.robot.setblocking(False)
        while True:
            readable = select.select(list(self.names), [s for s in self.waiting if self.waiting[s]], [])[0]
            for side in readable:
                data = side.recv(READ)
                if not data:
                    return self.names[side] + " closed"
                try:
                    self.take(side, data)
                except ValueError:
                    return "the client sent bytes that are no map"
            for side in self.waiting:
                self.send(side)
                if len(self.waiting[side]) > WAITING:
                    return self.names[side] + " does not read"
            if self.commanded and self.silence > SILENCE:
                return "the client is silent"

    def take(self, side, data):
        # type: (socket.socket, bytes) -> None
        """Sort in what one side sent."""
        if side is self.robot:
            self.waiting[self.client] += data
            self.newest = (self.newest + data)[-2 * PACKET :]
            self.silence += len(data)
            return
        self.silence = 0
        self.partial += data
        end = whole_maps(self.partial)
        self.waiting[self.robot] += self.partial[:end]
        self.commanded = self.commanded or end > 0
        del self.partial[:end]

    def send(self, side):
        # type: (socket.socket) -> None
        """Send as much of what waits for a side as it takes."""
        try:
            if self.waiting[side]:
                del self.waiting[side][: side.send(bytes(self.waiting[side]))]
        except socket.error as error:
            if error.errno not in (11, 35):  # EAGAIN: later
                raise

    def release(self):
        # type: () -> None
        """Lower the stiffness of all joints to 0 if the client has commanded them; free joints stay free."""
        if not self.commanded:
            return
        log("lowering the stiffness of all joints to 0")
        self.robot.settimeout(WAIT)
        self.robot.sendall(bytes(self.waiting[self.robot]))
        start = stiffness_in(bytes(self.newest))
        for count in range(RELEASE, -1, -1):
            left = [min(value, value * count / float(RELEASE)) for value in start]
            self.robot.sendall(stiffness_map(left))
            try:
                if not self.robot.recv(READ):
                    return
            except socket.timeout:
                pass


def stiffness_in(packets):
    # type: (bytes) -> list[float]
    """The 25 stiffnesses in the newest whole array of some bytes of LoLA's; zeros if there is none."""
    at = packets.rfind(STIFFNESS, 0, len(packets) - 5 * JOINTS)
    if at < 0:
        return [0.0] * JOINTS
    at += len(STIFFNESS)
    values = [struct.unpack_from(">f", packets, at + 5 * slot + 1)[0] for slot in range(JOINTS)]
    return [value if -1.0 <= value <= 1.0 else 0.0 for value in values]  # 0 for NaN too


def stiffness_map(values):
    # type: (list[float]) -> bytes
    """A map of LoLA's with the stiffness of each joint."""
    return b"\x81" + STIFFNESS + b"".join(b"\xca" + struct.pack(">f", value) for value in values)


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
        except socket.error as error:
            log("no LoLA at %s: %s" % (path, error))
        else:
            log("client %s connected" % address[0])
            log("client %s disconnected: %s" % (address[0], relayed(client, robot)))
        client.close()
        robot.close()


def relayed(client, robot):
    # type: (socket.socket, socket.socket) -> str
    """Serve a client to its end, and leave the robot without stiffness; the reason of the end."""
    relay = Relay(client, robot)
    try:
        return relay.run()
    except socket.error as error:
        return str(error)
    finally:
        client.close()
        try:
            relay.release()
        except socket.error as error:
            log("the joints keep their stiffness: %s" % error)


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
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.default_int_handler)
    try:
        serve(host, int(port), arguments.socket)
    except KeyboardInterrupt:
        pass
    except socket.error as error:
        sys.exit("error: cannot listen on %s: %s" % (arguments.listen, error))


if __name__ == "__main__":
    main()
