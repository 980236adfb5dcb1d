"""Relays LoLA's unix socket over TCP. Runs on the robot: one file, no package, Python 2.7 or 3.

    python relay.py --listen 0.0.0.0:10000 --socket /tmp/robocup

One client at a time, as on the socket itself. There is no password: any client of the port moves the robot, so
listen on an address that only your machine reaches.

LoLA keeps the last command for ever. When a client that has commanded the robot ends, or sends nothing for one
second (its process hangs, the cable is out), the relay disconnects it, crouches in three seconds if the robot
stands, and lowers the stiffness of all joints in two seconds: to 0, of the legs of a crouched robot to 0.1,
without which it may tip over. It does so too when it ends itself, by Ctrl-C, SIGTERM or SIGHUP. LoLA's packets
are the clock, because the robot's wall clock may jump.
"""
# ruff: noqa: UP004, UP024, UP031, UP041, SIM105, B905  (Python 2 reads it too)

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
RELEASE = 167.0  # packets that the ramp of the stiffness takes
WAIT = 0.1  # s for each of these packets
JOINTS = 25
DESCENT = 250  # packets that the way to the crouch takes: 3 s
FIRST_LEG_JOINT = 7  # slot of LHipYawPitch
# rad, the published posture Crouch, slots 7 to 17
CROUCH = [
    -0.25,
    -0.08,
    -0.7,
    2.11,
    -1.18,
    0.077,
    0.08,
    -0.7,
    2.11,
    -1.18,
    -0.077,
]  # rad, the vendor's posture, slots 7 to 17
REST = 0.1  # stiffness of the legs in the crouch
UPRIGHT = 0.35  # rad of roll and pitch, below which the robot stands
CARRIED = 3.0  # kg on the soles, above which it stands; it weighs 5.5
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
        """Crouch if the robot stands, then lower the stiffness of all joints; free joints stay free.

        It becomes 0, after a crouch that of the legs REST, as the guard's does. Nothing is sent if the client
        has not commanded the robot.
        """
        if not self.commanded:
            return
        self.robot.settimeout(WAIT)
        self.robot.sendall(bytes(self.waiting[self.robot]))
        packets = bytes(self.newest)
        stiffness = array_in(packets, b"Stiffness", JOINTS) or [0.0] * JOINTS
        rest = [0.0] * JOINTS
        if stands(packets):
            log("crouching")
            start = array_in(packets, b"Position", JOINTS)
            for count in range(1, DESCENT + 1):
                part = float(count) / DESCENT
                part = part * part * (3.0 - 2.0 * part)
                position = list(start)
                for slot, goal in enumerate(CROUCH, FIRST_LEG_JOINT):
                    position[slot] += part * (goal - start[slot])
                self.cycle(map_of(b"Position", position))
            rest[FIRST_LEG_JOINT : FIRST_LEG_JOINT + len(CROUCH)] = [REST] * len(CROUCH)
        log("lowering the stiffness of all joints")
        for count in range(int(RELEASE), -1, -1):
            left = [min(v, r + (v - r) * count / RELEASE) for v, r in zip(stiffness, rest)]
            self.cycle(map_of(b"Stiffness", left))

    def cycle(self, command):
        # type: (bytes) -> None
        """Send a command and wait for LoLA's next packet."""
        self.robot.sendall(command)
        try:
            self.robot.recv(READ)
        except socket.timeout:
            pass


def head_of(key, count):
    # type: (bytes, int) -> bytes
    """Key and head of an array, before its elements: 0xca and a float 32 each."""
    head = struct.pack("B", 0x90 | count) if count < 16 else struct.pack(">BH", 0xDC, count)
    return struct.pack("B", 0xA0 | len(key)) + key + head


def map_of(key, values):
    # type: (bytes, list[float]) -> bytes
    """A map of LoLA's with one array."""
    return b"\x81" + head_of(key, len(values)) + b"".join(b"\xca" + struct.pack(">f", v) for v in values)


def array_in(packets, key, count):
    # type: (bytes, bytes, int) -> list[float]
    """The newest whole array of a key in LoLA's bytes; empty: none, or it holds something that cannot be."""
    head = head_of(key, count)
    at = packets.rfind(head, 0, len(packets) - 5 * count)
    if at < 0:
        return []
    at += len(head)
    values = [struct.unpack_from(">f", packets, at + 5 * slot + 1)[0] for slot in range(count)]
    return values if all(-100.0 < value < 100.0 for value in values) else []  # not with NaN


def stands(packets):
    # type: (bytes) -> bool
    """Whether the robot is upright and its stiff legs carry it."""
    angles, forces = array_in(packets, b"Angles", 2), array_in(packets, b"FSR", 8)
    legs = array_in(packets, b"Stiffness", JOINTS)[FIRST_LEG_JOINT : FIRST_LEG_JOINT + len(CROUCH)]
    if not (angles and forces and legs and array_in(packets, b"Position", JOINTS)):
        return False
    return max(map(abs, angles)) < UPRIGHT and sum(forces) > CARRIED and min(legs) >= 0.2


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
