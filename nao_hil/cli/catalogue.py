"""`nao-hil robots`, `nao-hil gaits`, `nao-hil scenarios`: what there is."""

from __future__ import annotations

import msgspec
from rich.table import Table

from bridge.body import BODIES, load_body
from bridge.body.quantities import total_mass
from emulator.scenarios import SCENARIOS, load_scenario
from nao_hil.cli import options
from nao_hil.cli.console import open_console, print_json


def robots(as_json: options.Json = False) -> int:
    """List the robot bodies there are data sheets for."""
    bodies = [load_body(name) for name in BODIES]
    if as_json:
        rows = {
            b.name: {"title": b.title, "model": b.model, "mass": total_mass(b), "cycle": b.cycle}
            for b in bodies
        }
        print_json(rows)
        return 0
    table = Table("name", "what it is", "mass, kg", "cycle, ms", title="Robot bodies")
    for b in bodies:
        table.add_row(b.name, b.title, f"{total_mass(b):.3f}", f"{1e3 * b.cycle:.0f}")
    open_console(stderr=False).print(table)
    return 0


def gaits(as_json: options.Json = False) -> int:
    """List the gaits and their shipped parameters."""
    # imported late: the walk stands on SciPy, which help and completion need not wait for
    from walker.gaits import GAITS, gait_parameters

    rows = {name: msgspec.to_builtins(gait_parameters(name)) for name in GAITS}
    if as_json:
        print_json(rows)
        return 0
    table = Table("name", "parameter", "value (SI units)", title="Gaits")
    for name, parameters in rows.items():
        for i, (key, value) in enumerate(parameters.items()):
            table.add_row(name if i == 0 else "", key, str(value))
    open_console(stderr=False).print(table)
    return 0


def scenarios(as_json: options.Json = False) -> int:
    """List the worlds that come with the program."""
    rows = {name: load_scenario(name).title for name in SCENARIOS}
    if as_json:
        print_json(rows)
        return 0
    table = Table("name", "what happens", title="Scenarios")
    for name, title in rows.items():
        table.add_row(name, title)
    open_console(stderr=False).print(table)
    return 0
