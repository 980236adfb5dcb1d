"""Fuzzes one target after the other, each for some CPU time; what is found goes to a folder.

Usage from the root, with atheris installed: python -m tests.fuzz.campaign SECONDS FOLDER [TARGET ...];
without targets all. A finding is FOLDER/TARGET-crash-...; in tests/fuzz/corpus/TARGET/ it becomes a test.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Final

from tests.fuzz.targets import TARGETS

FINDINGS: Final = 5
"""After so many a target is left until they are mended."""
HANGS: Final = 300
"""s of the clock that one input may take; generous, for busy machines."""


def used(pid: int) -> float:
    """CPU time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def fuzz(target: str, seconds: float, folder: Path) -> str:
    """One target; says how it went."""
    corpus, spent = folder / target, 0.0
    corpus.mkdir(parents=True, exist_ok=True)
    options = [
        f"-artifact_prefix={folder / target}-",
        f"-timeout={HANGS}",
        "-rss_limit_mb=3000",
        "-max_len=4096",
    ]
    folders = [str(corpus), f"tests/fuzz/corpus/{target}"]
    with (folder / f"{target}.log").open("a") as log:
        for findings in range(FINDINGS):
            command = [sys.executable, "-m", "tests.fuzz.fuzz", target, *options, *folders]
            process = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL)
            before = spent
            while process.poll() is None:
                spent = before + used(process.pid)
                if spent >= seconds:
                    process.send_signal(signal.SIGUSR1)  # libFuzzer ends in order
                time.sleep(1.0)
            if spent >= seconds:
                return f"{target}: {spent:.0f} s of CPU, {findings} findings"
    return f"{target}: {spent:.0f} s of CPU, ended after {FINDINGS} findings"


def main() -> None:
    """Do them all."""
    if len(sys.argv) < 3 or set(sys.argv[3:]) - set(TARGETS):
        sys.exit(f"error: give seconds, a folder, and targets among {', '.join(TARGETS)}.")
    for target in sys.argv[3:] or TARGETS:
        print(fuzz(target, float(sys.argv[1]), Path(sys.argv[2]).absolute()), flush=True)


if __name__ == "__main__":
    main()
