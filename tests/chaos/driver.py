"""A test of the whole that is allowed to be rough: three robots, their clients, and events from one seed.

After each event the invariants are checked; what breaks one is a violation, with the event before it. The
figures of a walk are no invariants: a machine that is starved on purpose keeps no cycle.
"""

from __future__ import annotations

import contextlib
import os
import random
import signal
import socket
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Final

import msgspec
from scipy.stats import theilslopes

from bridge.body.joints import INDEX
from bridge.errors import NaoHilError
from bridge.link.client import GuardClient, WalkClient, WorldClient
from bridge.messages.walk import WalkCommand
from bridge.messages.world import Reset
from bridge.recording.playback import read_recording
from nao_hil.runs.monitor import Monitor
from tests.chaos.processes import TAG, LolaProgram, Member
from tests.chaos.relay import Relay
from tests.one_link import one_link
from tests.ports import free_port

BODIES: Final = ("nao-v3", "nao-v6", "nao-v5")
HOLDERS: Final = (("walker-0",), ("lola",), ("naoqi", "walker"))
"""Controllers that may hold each robot."""
PAUSE: Final = (1.0, 6.0)
"""s between events, at most."""
READY: Final = 120.0
"""s that a process may take to start on a busy machine."""
EXCUSE: Final = 150.0
"""s after an event in which its victims may end with a sentence."""
LIMP: Final = 0.15
"""Stiffness of a robot that rests."""
GROWTH: Final = 5.0
"""MB that a process may grow after its first `SETTLED` s or reset, by the line through its looks."""
HISTORY: Final = 20.0
"""MB of moments that a page keeps at most (`nao_hil/view/follow.py`), which fill in its first minutes."""
SETTLED: Final = 20.0
FEWEST_LOOKS: Final = 20
MOST_LOOKS: Final = 500
"""Through which the line is drawn, of all equally spread ones."""
LOOK: Final = 0.5
"""s between two looks at robots and processes."""
UNHEARD: Final = 10.0
"""s after a full disk in which a process may end without room for its sentence."""
LOST: Final = 3.0
"""s of robot time that a killed robot's recording may lack: a chunk, and what came since the last look."""


class Report(msgspec.Struct, kw_only=True):
    """Result of a rough test."""

    seed: int
    engine: str
    seconds: float
    events: dict[str, int]
    violations: list[str]
    starts: int
    """Processes started, the first ones included."""
    recordings: int
    """Read to their last cycle."""
    packets: int
    """Of LoLA that its client got."""
    growth: dict[str, float]
    """MB after the first `SETTLED` s, by the line through all looks, the most of any start, by process."""


class Chaos:
    """The robots, the clients, and the events.

    Args:
        folder: for all files; a disk of its own where one can be mounted.
        seed: of the events.
        engine: of the robots.
    """

    def __init__(self, folder: Path, seed: int, engine: str) -> None:
        self._folder, self._engine, self._seed = folder, engine, seed
        self._random = random.Random(seed)
        self._ports = [free_port() for _ in range(6)]
        self._relays = [Relay(port) for port in self._ports[:3]]
        self._link = one_link([self._endpoint(number) for number in range(3)])
        self._events: Counter[str] = Counter()
        self._violations: list[str] = []
        self._last = "the start"
        self._full_until = -UNHEARD
        self._stopped: dict[int, int] = {}
        """Robots that rest after a stop: the cycle in which they said so."""
        self._recordings = 0
        self._growth: dict[str, float] = {}
        self._seen = [0.0, 0.0, 0.0]
        """Newest robot time of each robot's present start, s."""
        self._members: list[Member] = []
        for number in range(3):
            self._add(f"robot-{number}", number, self._robot(number))
        via = [f"tcp/127.0.0.1:{relay.port}" for relay in self._relays]
        lola = folder / "lola.socket"
        self._add(
            "walker-0",
            0,
            lambda _: ["walk", "--serve", "--name", "r0", "--connect", via[0], "--controller", "walker-0"],
        )
        self._add(
            "view-0", 0, lambda _: ["view", "--name", "r0", "--connect", via[0], "--port", str(self._ports[3])]
        )
        self._add(
            "record-0",
            0,
            lambda at: ["record", "--name", "r0", "--connect", via[0], "--out", str(at / "r.mcap")],
        )
        self._add(
            "lola-1", 1, lambda _: ["serve", "lola", "--name", "r1", "--connect", via[1], "--socket", str(lola)]
        )
        naoqi = f"tcp://127.0.0.1:{self._ports[4]}"
        self._add(
            "naoqi-2", 2, lambda _: ["serve", "naoqi", "--name", "r2", "--connect", via[2], "--listen", naoqi]
        )
        self._program = LolaProgram(lola)
        self._monitors = [Monitor(f"r{number}", self._endpoint(number)) for number in range(3)]

    def _endpoint(self, number: int) -> str:
        return f"tcp/127.0.0.1:{self._ports[number]}"

    def _robot(self, number: int) -> Callable[[Path], list[str]]:
        def command(folder: Path) -> list[str]:
            body = ["emulate", "--robot", BODIES[number], "--engine", self._engine, "--name", f"r{number}"]
            return [*body, "--listen", self._endpoint(number), "--out", str(folder / "run"), "--json"]

        return command

    def _add(self, name: str, robot: int, command: Callable[[Path], list[str]]) -> None:
        self._members.append(Member(name, command, self._folder, robot))

    def _violate(self, text: str) -> None:
        sentence = f"{text} (after {self._last})"
        if sentence not in self._violations:
            self._violations.append(sentence)
            print(f"violation: {sentence}", file=sys.stderr, flush=True)

    # Events: each says what it does, and excuses its victims.

    def _victim(self, *kinds: str) -> Member:
        return self._random.choice([m for m in self._members if not kinds or m.name.startswith(kinds)])

    def _excuse(self, robot: int, *, all_of_it: bool = True) -> None:
        for member in self._members:
            if member.robot == robot and (all_of_it or not member.name.startswith("robot")):
                member.excused = time.monotonic() + EXCUSE

    def kill(self) -> str:
        """A process is killed, as by a power cut."""
        victim = self._victim()
        self._excuse(victim.robot, all_of_it=victim.name.startswith("robot"))
        victim.excused = time.monotonic() + EXCUSE
        victim.child.kill()
        return victim.name

    def suspend(self) -> str:
        """A process stands still for some seconds."""
        victim = self._victim()
        self._excuse(victim.robot)
        victim.signal(signal.SIGSTOP)
        self._watch(self._random.uniform(0.5, 8.0))
        victim.signal(signal.SIGCONT)
        return victim.name

    def suspend_all(self) -> str:
        """All processes of a robot stand still for 12 s."""
        robot = self._random.randrange(3)
        self._excuse(robot)
        victims = [member for member in self._members if member.robot == robot]
        for victim in victims:
            victim.signal(signal.SIGSTOP)
        self._watch(12.0)
        for victim in victims:
            victim.signal(signal.SIGCONT)
        return f"robot {robot}"

    def starve(self) -> str:
        """A process gets 60 ms of each 100 ms, as by a quota."""
        victim = self._victim()
        self._excuse(victim.robot)
        end = time.monotonic() + 5.0
        while time.monotonic() < end:
            victim.signal(signal.SIGSTOP)
            time.sleep(0.04)
            victim.signal(signal.SIGCONT)
            time.sleep(0.06)
        return victim.name

    def cut(self) -> str:
        """The network of a robot's clients is cut."""
        number = self._random.randrange(3)
        self._excuse(number)
        self._relays[number].break_off()
        self._watch(self._random.uniform(0.5, 6.0))
        self._relays[number].cut = False
        return f"robot {number}"

    def delay(self) -> str:
        """The network of a robot's clients is slow."""
        number = self._random.randrange(3)
        self._excuse(number)
        self._relays[number].delay = self._random.uniform(0.01, 0.1)
        self._watch(5.0)
        self._relays[number].delay = 0.0
        return f"robot {number}"

    def reset(self) -> str:
        """The world begins anew under its clients."""
        number = self._random.randrange(3)
        self._excuse(number)
        self._seen[number] = 0.0
        with contextlib.suppress(NaoHilError), WorldClient(f"r{number}", self._endpoint(number)) as world:
            world.send(Reset(), 10.0)
        # the old world, 1.2 MB, stays until a later collection of garbage: its memory is judged between resets
        self._note_growth(self._members[number])
        self._members[number].memory = []
        return f"robot {number}"

    def stop(self) -> str:
        """An emergency stop, which holds until the robot is armed."""
        number = self._random.randrange(3)
        self._excuse(number)
        others = {other for other in range(3) if other != number and self._armed(other)}
        with contextlib.suppress(NaoHilError), GuardClient(f"r{number}", self._endpoint(number)) as guard:
            guard.stop()
            end = time.monotonic() + 30.0
            while time.monotonic() < end and guard.status().state not in ("rest", "idle"):
                self._watch(LOOK)
            status = guard.status()
            if status.state not in ("rest", "idle") or status.armed:
                self._violate(f"robot {number} does not rest 30 s after a stop: {status.text}")
            else:
                self._stopped[number] = status.seq
                self._watch(4.0)
                self._stopped.pop(number)
            for other in others:
                if not self._armed(other):
                    self._violate(f"robot {other} is not armed after a stop of robot {number}")
            guard.arm()
        self._stopped.pop(number, None)
        return f"robot {number}"

    def _armed(self, number: int) -> bool:
        status = self._monitors[number].status
        return status is not None and status.armed

    def walk(self) -> str:
        """A walk is ordered, and ordered to stop."""
        with contextlib.suppress(NaoHilError), WalkClient("r0", self._endpoint(0), 2.0) as walker:
            walker.send(WalkCommand(op="walk", velocity=(0.1, 0.0, 0.0)))
            self._watch(6.0)
            walker.send(WalkCommand(op="stop"))
        return "robot 0"

    def fill_disk(self) -> str:
        """The disk of all recordings is full for some seconds."""
        if not os.path.ismount(self._folder):
            return "no disk of its own"
        for number in range(3):
            self._excuse(number)
        filler = self._folder / "filler"
        with contextlib.suppress(OSError), filler.open("wb", buffering=0) as file:
            while True:
                file.write(bytes(1 << 20))
        self._watch(4.0)
        filler.unlink()
        self._full_until = time.monotonic()
        return "all"

    # Invariants

    def _watch(self, seconds: float) -> None:
        """Look at everything for some time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for number, monitor in enumerate(self._monitors):
                self._look_at_robot(number, monitor)
            for member in self._members:
                member.look()
            time.sleep(min(LOOK, max(end - time.monotonic(), 0.0)))

    def _look_at_robot(self, number: int, monitor: Monitor) -> None:
        with contextlib.suppress(NaoHilError):
            monitor.connect()
        frame, status = monitor.sensors, monitor.status
        if frame is None or status is None:
            return
        self._seen[number] = frame.time  # a reset begins at 0 again, with another file
        if status.holder and status.holder not in HOLDERS[number]:
            self._violate(f"robot {number} is held by `{status.holder}`")
        tagged = abs(frame.position[INDEX["HeadYaw"]] - TAG) < 0.05
        if number != 1 and tagged and status.under_command:
            self._violate(f"robot {number} turns its head as only robot 1 is told to")
        rests = self._stopped.get(number, frame.seq)
        if frame.seq > rests + 100 and max(frame.stiffness) > LIMP:
            self._violate(f"robot {number} has stiffness {max(frame.stiffness):.2f} after a stop")

    def _look_at_processes(self) -> None:
        """Each runs, or was a victim and ended with a sentence; then it is started again."""
        for member in self._members:
            if "Traceback" in member.log:
                self._violate(f"{member.name} shows a traceback: {member.log[-300:]}")
            if member.child.running:
                continue
            outcome = member.child.end(0.0)
            # its output is on the disk that was full: the sentence may have found no room
            silent = "error: " not in outcome.stderr and time.monotonic() > self._full_until + UNHEARD
            if outcome.code not in (0, 130, -signal.SIGKILL) and silent:
                self._violate(f"{member.name} ended with code {outcome.code} and no sentence")
            if time.monotonic() > member.excused:
                self._violate(f"{member.name} ended by itself: {outcome.error}")
            if member.name.startswith("robot"):
                self._read_recording(member, outcome.code == -signal.SIGKILL)
            self._note_growth(member)
            member.start()
            member.excused = time.monotonic() + EXCUSE

    def _read_recording(self, member: Member, killed: bool) -> None:
        """It is whole up to the last cycle that was seen."""
        files = sorted((member.folder / "run").glob("frames*.mcap"), key=lambda file: file.stat().st_mtime)
        seen, self._seen[member.robot] = self._seen[member.robot], 0.0
        last = 0.0
        for file in files:
            try:
                for record in read_recording(file):
                    last = record.time
            except NaoHilError as error:
                self._violate(f"{member.name}: {error}")
            self._recordings += 1
            if file != files[-1] or not member.child.running:
                file.unlink()
        if files and killed and last < seen - LOST:
            self._violate(
                f"the recording of {member.name} ends at {last:.2f} s, the robot was seen at {seen:.2f} s"
            )

    def _note_growth(self, member: Member) -> None:
        looks = [(at, size) for at, size in member.memory if at - member.memory[0][0] > SETTLED]
        if len(looks) >= FEWEST_LOOKS:
            times, sizes = zip(*looks[:: 1 + len(looks) // MOST_LOOKS], strict=True)
            grown = float(theilslopes(sizes, times).slope) * (times[-1] - times[0])
            self._growth[member.name] = max(round(grown, 1), self._growth.get(member.name, -1e9))
            if grown > GROWTH + HISTORY * member.name.startswith("view"):
                self._violate(f"{member.name} has grown by {grown:.1f} MB")

    def run(self, seconds: float) -> Report:
        """Events until the time is over, then the end of all.

        Args:
            seconds: of the clock, from when all robots are there.
        """
        began = time.monotonic()
        for member in self._members:
            member.excused = began + READY
        while time.monotonic() - began < READY and not all(m.sensors for m in self._monitors):
            self._watch(LOOK)
        began = time.monotonic()
        acts = (
            *(self.kill, self.kill, self.suspend, self.suspend_all, self.starve, self.cut, self.delay),
            *(self.reset, self.stop, self.stop, self.walk, self.fill_disk),
        )
        while time.monotonic() - began < seconds:
            act = self._random.choice(acts)
            self._last = act.__name__
            self._last = f"{act.__name__} of {act()}"
            self._events[act.__name__] += 1
            print(f"{time.monotonic() - began:6.0f} s: {self._last}", file=sys.stderr, flush=True)
            self._watch(self._random.uniform(*PAUSE))
            self._look_at_processes()
        self._end()
        return Report(
            seed=self._seed,
            engine=self._engine,
            seconds=round(time.monotonic() - began, 1),
            events=dict(self._events),
            violations=self._violations,
            starts=sum(member._starts for member in self._members),
            recordings=self._recordings,
            packets=self._program.packets,
            growth=self._growth,
        )

    def _end(self) -> None:
        """End everything; ports and sockets are free then."""
        self._last = "the end"
        self._program.end()
        for member in reversed(self._members):
            self._note_growth(member)
            outcome = member.child.end(60.0)
            if "Traceback" in outcome.stderr:
                self._violate(f"{member.name} shows a traceback at its end: {outcome.stderr[-300:]}")
            if outcome.code == -signal.SIGKILL:
                self._violate(f"{member.name} did not end within 60 s of a Ctrl-C")
            if member.name.startswith("robot"):
                self._read_recording(member, killed=False)
        for monitor in self._monitors:
            monitor.close()
        self._link.close()
        for relay in self._relays:
            relay.__exit__(None, None, None)
        for port in self._ports[:5]:
            with socket.socket() as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                try:
                    probe.bind(("127.0.0.1", port))
                except OSError:
                    self._violate(f"port {port} is still in use")
        if (self._folder / "lola.socket").exists():
            self._violate("LoLA's socket is left")
