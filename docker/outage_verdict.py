"""Whether a robot did what its guard promises when something happened to its walk: one line, exit code 0 or 1.

Usage: outage_verdict.py EVENT WALKER < RECORDINGS; WALKER is the walker's summary, RECORDINGS one line of
`nao-hil info --json` per start of the robot.
"""

import json
import sys

BRIDGED = 0.25
"""s of silence below which nothing happens, and twice that after which the robot crouches (docs/guard.md)."""


def complaints(event: str, walker: dict[str, object], recordings: list[dict[str, object]]) -> list[str]:
    """What is not as promised."""
    notices = {code for recording in recordings for code in dict(recording["notices"])}  # type: ignore[call-overload]
    outage = float(event.removeprefix("outage-")) if event.startswith("outage-") else None
    silent = (outage is not None and outage >= 4 * BRIDGED) or event == "walker-killed"
    wrong = {
        "a recording cannot be read": len(recordings) < (2 if event == "robot-killed" else 1),
        "the robot fell": any(recording["fell"] for recording in recordings),
        "the walker did not end": not walker,
        "the walk neither went on nor ended in a stand": not (walker.get("done") or walker.get("late")),
        "a short outage made it crouch": outage is not None and outage < BRIDGED and "guard-crouch" in notices,
        "it did not crouch": silent and "guard-crouch" not in notices,
    }
    return [words for words, is_so in wrong.items() if is_so]


def main() -> None:
    """Say it."""
    event, said = sys.argv[1:]
    recordings = [json.loads(line) for line in sys.stdin]
    walker = json.loads(said or "{}")
    wrong = complaints(event, walker, recordings)
    told = ", ".join(f"{code} {n}x" for recording in recordings for code, n in recording["notices"].items())
    end = (
        "walked to the end" if walker.get("done") else "stopped and stands" if walker.get("late") else "gave up"
    )
    print(f"outage-test: {event}: {end}; {told}; {', '.join(wrong) or 'as promised'}", flush=True)
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
