"""`nao-hil config`: a run's configuration, shown or checked; `robots`, `gaits`, `scenarios`: its names."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from difflib import get_close_matches
from itertools import islice
from pathlib import Path
from typing import Annotated, Any, Final

import msgspec
import typer
from rich.table import Table

from bridge.body import BODIES, Body, load_body
from bridge.body.quantities import total_mass
from bridge.config import read_toml
from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from emulator.scenarios import SCENARIOS, load_scenario
from emulator.scenarios.model import Scenario
from emulator.wear import WearProfile, load_wear
from nao_hil.cli.added_options import takes_run
from nao_hil.cli.console import Answer
from nao_hil.runs.config import RunConfig, run_config


@takes_run()
def show(settings: RunConfig) -> Answer:
    """Print every number that a run with these options would have, as TOML that --config takes back.

    Example: nao-hil config show --gait dynamic --torso thesis > my.toml

    Example: nao-hil config show --config my.toml --json
    """
    whole = _whole(settings)
    text: str = msgspec.toml.encode(_without_none(whole)).decode()
    return Answer(whole, text.rstrip("\n"))


def _without_none(table: dict[str, Any]) -> dict[str, Any]:
    """A table without entries that are None, which TOML cannot express."""
    return {
        key: _without_none(value) if isinstance(value, dict) else value
        for key, value in table.items()
        if value is not None
    }


def _check_run(file: Path) -> None:
    from nao_hil.runs.build import check_run  # imported late: the walk needs SciPy

    check_run(run_config(file))


def _check_robot(settings: RunConfig) -> None:
    from nao_hil.runs.build import check_robot  # imported late: as above

    check_robot(settings)


KINDS: Final[dict[str, tuple[type[msgspec.Struct], Callable[[Path], Any]]]] = {
    "run": (RunConfig, _check_run),
    "scenario": (Scenario, lambda file: _check_robot(RunConfig(scenario=str(file)))),
    "wear": (WearProfile, lambda file: load_wear(str(file))),
    "body": (Body, lambda file: _check_robot(RunConfig(robot=str(file)))),
}
"""Kind of a file -> its structure, and its check."""
_HINTED_KEYS: Final = 100
"""Most keys of a file without a known key, so many are compared with the known ones."""


def _whole(settings: RunConfig) -> dict[str, Any]:
    """The configuration with the shipped parameters of gait and controllers filled in; checked."""
    # imported late: the walk needs SciPy, which help and completion need not wait for
    from nao_hil.runs.build import check_run
    from walker.gaits import gait_parameters
    from walker.parameters import controller_parameters

    check_run(settings)
    whole: dict[str, Any] = msgspec.to_builtins(settings) | {
        "parameters": msgspec.to_builtins(gait_parameters(settings.gait, settings.parameters)),
        "controller": msgspec.to_builtins(controller_parameters(settings.gait, settings.controller)),
    }
    return whole


def check(
    file: Annotated[Path, typer.Argument(help="TOML file.", metavar="FILE", show_default=False)],
    kind: Annotated[
        str | None,
        typer.Option(
            "--kind",
            help="What the file is: run, scenario, wear or body; default: what its keys tell.",
            metavar="KIND",
            autocompletion=lambda incomplete: [k for k in KINDS if k.startswith(incomplete)],
        ),
    ] = None,
) -> Answer:
    """Check a file that a command will be given: of a run (--config), a scenario, a wear profile or a body.

    Whether a run's gait can be walked by its body is checked as well. Exit code 2, and one sentence, if not.

    Example: nao-hil config check my.toml

    Example: nao-hil config check ice.toml --kind scenario
    """
    if kind is not None and kind not in KINDS:
        raise ConfigurationError(unknown_name("kind", kind, KINDS))
    known_kind = kind or kind_of(file)
    KINDS[known_kind][1](file)
    return Answer({"file": str(file), "kind": known_kind, "ok": True}, f"{file}: a good {known_kind} file")


def kind_of(file: Path) -> str:
    """Kind of a file by its top-level keys: the kind with most of them, of several the first valid one.

    Raises:
        ConfigurationError: unreadable, not TOML, or no key that any kind has.
    """
    data = read_toml(file)
    tables = {kind: _tables(struct) for kind, (struct, _) in KINDS.items()}
    known = {
        kind: sum(fields.get(key) is isinstance(value, dict) for key, value in data.items())
        for kind, fields in tables.items()
    }
    most = max(known.values())
    if not most:
        for kind, (struct, _) in KINDS.items():  # a misspelt one: its own check reports it
            if any(get_close_matches(key, struct.__struct_fields__) for key in islice(data, _HINTED_KEYS)):
                return kind
        raise ConfigurationError(
            f"{file}: has no key of any file that nao-hil reads; say what it is with --kind."
        )
    best = [kind for kind, count in known.items() if count == most]
    for kind in best[1:] and best:
        with suppress(ConfigurationError):
            KINDS[kind][1](file)
            return kind
    return best[0]


def _tables(struct: type[msgspec.Struct]) -> dict[str, bool]:
    """Keys of a struct, and whether each is a table in the file."""
    info = msgspec.inspect.type_info(struct)
    assert isinstance(info, msgspec.inspect.StructType)
    return {field.name: _table(field.type) for field in info.fields}


def _table(kind: msgspec.inspect.Type) -> bool:
    if isinstance(kind, msgspec.inspect.UnionType):
        return any(map(_table, kind.types))
    return isinstance(kind, (msgspec.inspect.StructType, msgspec.inspect.DictType))


def robots() -> Answer:
    """List the robot bodies there are data sheets for."""
    bodies = [load_body(name) for name in BODIES]
    rows = {
        b.name: {"title": b.title, "model": b.model, "mass": total_mass(b), "cycle": b.cycle} for b in bodies
    }
    table = Table("name", "what it is", "mass, kg", "cycle, ms", title="Robot bodies")
    for b in bodies:
        table.add_row(b.name, b.title, f"{total_mass(b):.3f}", f"{1e3 * b.cycle:.0f}")
    return Answer(rows, table)


def gaits() -> Answer:
    """List the gaits and their shipped parameters."""
    # imported late: the walk needs SciPy, which help and completion need not wait for
    from walker.gaits import GAITS, gait_parameters
    from walker.gaits.learned import POLICIES, PREFIX

    rows = {name: msgspec.to_builtins(gait_parameters(name)) for name in GAITS}
    for sheet in sorted(POLICIES.glob("*.toml")):
        learned = msgspec.to_builtins(gait_parameters(PREFIX + sheet.stem))
        rows[PREFIX + sheet.stem] = {key: learned[key] for key in ("title", "cycle")}
    table = Table("name", "parameter", "value (SI units)", title="Gaits")
    for name, parameters in rows.items():
        for i, (key, value) in enumerate(parameters.items()):
            table.add_row(name if i == 0 else "", key, str(value))
    return Answer(rows, table)


def scenarios() -> Answer:
    """List the worlds that come with the program."""
    rows = {name: load_scenario(name).title for name in SCENARIOS}
    table = Table("name", "what happens", title="Scenarios")
    for name, title in rows.items():
        table.add_row(name, title)
    return Answer(rows, table)
