"""Finding, reading and checking the data sheets.

The check covers conditions beyond the fields' types: a robot with these numbers can exist.
"""

from __future__ import annotations

import functools
import itertools
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from bridge.body.joints import TORSO, joint_tree
from bridge.body.model import Body, CouplingRow, Link
from bridge.config import from_dict, load_toml
from bridge.errors import ConfigurationError
from bridge.polygon import turn
from bridge.validation import unknown_name

_ENCODER_STEPS: Final = 4096
_GYROSCOPE_AXES: Final = (2, 3)
_SOURCE_TAGS: Final = ("confirmed: ", "assumed: ")
_TRIANGLE_SLACK: Final = 1e-9
"""Relative: rounding of published digits must not make a flat plate impossible."""


def check_body(body: Body) -> None:
    """Check a data sheet.

    Raises:
        ConfigurationError: names the body, the link or joint, the fault and the expected value.
    """
    tree = joint_tree(body)
    _check_same(body, "joints", body.joints, tree)
    _check_same(body, "links", body.links, (TORSO, *tree))
    for name, joint in body.joints.items():
        if not joint.lower < joint.upper:
            _refuse(body, f"joint {name}", f"lower {joint.lower} must be below upper {joint.upper}")
        if joint.motor not in body.motors:
            motors = ", ".join(sorted(body.motors))
            _refuse(body, f"joint {name}", f"motor {joint.motor!r} is not in the table of motors ({motors})")
    for name in ("UpperArmLength", "LowerArmLength", "ThighLength", "TibiaLength", "FootHeight"):
        if not (length := getattr(body.lengths, name)) > 0.0:
            _refuse(body, f"lengths.{name}", f"{length} m must be above 0")
    shapes = body.shapes
    if not (bottom := shapes.torso_bottom) < (top := shapes.torso_top):
        _refuse(body, "shapes", f"torso_bottom {bottom} must be below torso_top {top}")
    for name, link in body.links.items():
        _check_inertia(body, name, link)
    coupling = body.coupling
    _check_rows(body, "coupling LAnkleRoll", coupling.LAnkleRoll)
    _check_rows(body, "coupling RAnkleRoll", coupling.RAnkleRoll)
    _check_rows(body, "coupling HeadPitch", coupling.HeadPitch)
    _check_sole(body)
    if body.encoder_steps != _ENCODER_STEPS:
        _refuse(body, "encoder_steps", f"{body.encoder_steps} must be {_ENCODER_STEPS} (12 bits)")
    if body.inertial_unit.gyroscope_axes not in _GYROSCOPE_AXES:
        _refuse(body, "inertial_unit", f"gyroscope_axes {body.inertial_unit.gyroscope_axes} must be 2 or 3")
    for group, source in body.sources.items():
        if not source.startswith(_SOURCE_TAGS):
            _refuse(body, f"sources.{group}", "must begin with 'confirmed: ' or 'assumed: '")


def is_possible_inertia(inertia: Sequence[float]) -> bool:
    """Whether a tensor (ixx, iyy, izz, ixy, ixz, iyz) belongs to a body of positive mass density.

    Positive definite, and no principal moment larger than the sum of the other two.
    """
    small, middle, large = principal_moments(inertia)
    return bool(small > 0.0 and large <= (small + middle) * (1.0 + _TRIANGLE_SLACK))


def principal_moments(inertia: Sequence[float]) -> tuple[float, float, float]:
    """Principal moments in ascending order of a tensor (ixx, iyy, izz, ixy, ixz, iyz), kg m^2."""
    ixx, iyy, izz, ixy, ixz, iyz = inertia
    small, middle, large = np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return float(small), float(middle), float(large)


def _check_same(body: Body, where: str, given: Iterable[str], wanted: Iterable[str]) -> None:
    missing, surplus = set(wanted) - set(given), set(given) - set(wanted)
    if missing:
        _refuse(body, where, f"{', '.join(sorted(missing))} missing; every {body.model} has them")
    if surplus:
        _refuse(body, where, f"{', '.join(sorted(surplus))} must go; an {body.model} has none")


def _check_inertia(body: Body, name: str, link: Link) -> None:
    if not is_possible_inertia(link.inertia):
        moments = ", ".join(f"{m:.4g}" for m in principal_moments(link.inertia))
        _refuse(
            body,
            f"link {name}",
            f"no body has the principal moments of inertia {moments} kg m^2: they must be positive, "
            "and none larger than the sum of the other two",
        )


def _check_rows(body: Body, where: str, rows: Sequence[CouplingRow]) -> None:
    if len(rows) < 2:
        _refuse(body, where, f"{len(rows)} rows; at least 2 are needed to interpolate")
    for row in rows:
        if row.lower > row.upper:
            _refuse(body, where, f"at {row.at}: lower {row.lower} must not be above upper {row.upper}")
    for row, later in itertools.pairwise(rows):
        if not row.at < later.at:
            _refuse(body, where, f"rows must be sorted by 'at', but {later.at} follows {row.at}")


def _check_sole(body: Body) -> None:
    sole = body.foot.sole
    if len(sole) < 3:
        _refuse(body, "foot.sole", f"{len(sole)} points; an outline has at least 3")
    edges = [(sole[i - 1], sole[i]) for i in range(len(sole))]
    for (i, first), (j, second) in itertools.combinations(enumerate(edges), 2):
        neighbours = j - i == 1 or (i == 0 and j == len(edges) - 1)
        if not neighbours and _crossing(*first, *second):
            _refuse(body, "foot.sole", f"the outline crosses itself between {first[0]} and {second[1]}")


def _crossing(a: Sequence[float], b: Sequence[float], c: Sequence[float], d: Sequence[float]) -> bool:
    """Whether segments ab and cd share a point."""
    return turn(a, b, c) * turn(a, b, d) <= 0.0 and turn(c, d, a) * turn(c, d, b) <= 0.0


def _refuse(body: Body, where: str, fault: str) -> None:
    raise ConfigurationError(f"robot body {body.name}: {where}: {fault}")


_FOLDER: Final = Path(__file__).parent / "bodies"
BODIES: Final = tuple(sorted(file.stem for file in _FOLDER.glob("*.toml")))
"""The data sheets that come with the package; `nao-v3` is the robot of Prenner's thesis."""


def load_body(name_or_path: str | os.PathLike[str]) -> Body:
    """A robot body, read and checked.

    Args:
        name_or_path: one of `BODIES`, or the path of a TOML file (ends with `.toml` or names a folder).

    Raises:
        ConfigurationError: no such body, or a sheet that is misspelt, incomplete or impossible.
    """
    name = os.fspath(name_or_path)
    if name in BODIES:
        return _shipped(name)
    if not name.endswith(".toml") and Path(name).name == name:
        raise ConfigurationError(f"{unknown_name('robot body', name, BODIES)}, or the path of a .toml file")
    return _read(Path(name))


@functools.cache
def _shipped(name: str) -> Body:
    return _read(_FOLDER / f"{name}.toml")


def sheet_of(body: Body) -> str:
    """The whole data sheet as JSON; empty for a shipped body, whose name says it all."""
    shipped = body.name in BODIES and body == _shipped(body.name)
    return "" if shipped else msgspec.json.encode(body).decode()


def body_of(name: str, sheet: str) -> Body:
    """The body that a robot says it has: `Info.body` and `Info.sheet`.

    Raises:
        ConfigurationError: no such body, or a sheet that is incomplete or impossible.
    """
    if not sheet:
        return load_body(name)
    where = f"data sheet of {name}"
    try:
        data = msgspec.json.decode(sheet)
    except (msgspec.DecodeError, RecursionError) as error:
        raise ConfigurationError(f"{where}: {error}") from None
    return _checked(from_dict(data, where, Body), where)


def _read(path: Path) -> Body:
    return _checked(load_toml(path, Body), str(path))


def _checked(body: Body, where: str) -> Body:
    try:
        check_body(body)
        if body.base not in BODIES:
            raise ConfigurationError(f"base: {unknown_name('shipped body', body.base, BODIES)}")
    except ConfigurationError as error:
        raise ConfigurationError(f"{where}: {error}") from None
    return body
