"""`python -m tests.bench [NAME ...] [--json]`: run the benchmarks."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from typing import Any

from bridge.errors import NaoHilError
from tests.bench import (
    batch,
    cycles,
    first_step,
    huang_search,
    identification,
    lola,
    lost_clients,
    naoqi,
    page,
    pictures,
    round_trip,
    servos,
    worlds,
)

BENCHES: dict[str, Callable[[], dict[str, Any]]] = {
    "round-trip": round_trip.measure,
    "cycles": cycles.measure,
    "batch": batch.measure,
    "servos": servos.measure,
    "worlds": worlds.measure,
    "huang-search": huang_search.measure,
    "page": page.measure,
    "pictures": pictures.measure,
    "first-step": first_step.measure,
    "lola": lola.measure,
    "lost-clients": lost_clients.measure,
    "naoqi": naoqi.measure,
}
LONG: dict[str, Callable[[], dict[str, Any]]] = {
    "identification": identification.measure,
    "experiments.calibration": identification.calibrate,
}
"""A quarter of an hour or more each: run only when named."""


def main() -> None:
    """Run the named benchmarks, or all."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__)
    known = BENCHES | LONG
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help=f"of {', '.join(known)}; default: all but {' and '.join(LONG)}, which are long",
    )
    parser.add_argument("--json", action="store_true", help="end with one JSON object")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in known:
            parser.error(f"unknown benchmark {name!r}; known: {', '.join(known)}")
    results: dict[str, dict[str, Any]] = {}
    for name in arguments.names or BENCHES:
        print(f"{name} ...", flush=True)
        try:
            results[name] = known[name]()
        except NaoHilError as error:
            results[name] = {"not run": str(error)}
        for key, value in results[name].items():
            print(f"  {key}: {value}", flush=True)
    if arguments.json:
        print(json.dumps(results))


main()
