"""ALWorldRepresentation: named places relative to each other, and what programs note about them.

Source: vendor's page. The root `World` is FRAME_WORLD; the robot's own frames, `Robot`, `Robot_Torso` and the
joints', are there as well (names: assumed from programs). Attributes are rows of SQLite tables in memory.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from bridge.adapters.naoqi.arguments import number, pairs, text
from bridge.adapters.naoqi.frames import RobotFrames, from_position6, inverse, position6
from bridge.adapters.naoqi.methods import Table
from bridge.body import TORSO
from bridge.errors import NaoqiRefused
from bridge.types import Array
from bridge.validation import unknown_name

_SERVICE: Final = "ALWorldRepresentation"
ROOT: Final = "World"
MAX_OBJECTS: Final = 500
MAX_ROWS: Final = 10_000
MAX_STEPS: Final = 100_000
"""Of SQLite's machine in one call."""
_OBJECT: Final = "nao_hil_object"
"""Column of the object's name."""
_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_ ]{0,59}")


class _Placed(NamedTuple):
    parent: str
    place: Array
    """In the parent, (4, 4)."""
    category: str


class WorldRepresentation:
    """Methods of the service; not thread-safe, the caller locks.

    Args:
        frames: of the robot.
    """

    def __init__(self, frames: RobotFrames) -> None:
        self._frames = frames
        self._objects: dict[str, _Placed] = {}
        self._categories: dict[str, dict[str, list[str]]] = {}
        """Category -> attribute -> its fields."""
        self._robot = {"Robot": "", "Robot_Torso": TORSO, **{joint: joint for joint in frames.body.joints}}
        self._data = sqlite3.connect(":memory:", check_same_thread=False, isolation_level=None)
        self._steps = 0
        self._data.set_progress_handler(self._too_long, 1000)

    def _too_long(self) -> bool:
        self._steps += 1000
        return self._steps > MAX_STEPS

    def _run(self, command: str, values: Sequence[Any] = ()) -> list[list[Any]]:
        self._steps = 0
        try:
            return [list(row) for row in self._data.execute(command, values).fetchall()]
        except (sqlite3.Error, sqlite3.Warning, OverflowError) as error:
            raise NaoqiRefused(f"{_SERVICE}: SQLite refuses it: {str(error).rstrip('.')}.") from None

    def _known(self, name: Any) -> str:
        one = text(name, f"{_SERVICE}: object")
        if one not in self._objects and one not in self._robot and one != ROOT:
            raise NaoqiRefused(f"{_SERVICE}: {unknown_name('object', one, [ROOT, *self._objects])}.")
        return one

    def _own(self, name: Any) -> str:
        one = self._known(name)
        if one not in self._objects:
            raise NaoqiRefused(f"{_SERVICE}: {one} is the robot's own; only stored objects can be changed.")
        return one

    def _category(self, name: Any) -> str:
        category = text(name, f"{_SERVICE}: category")
        if category not in self._categories:
            raise NaoqiRefused(f"{_SERVICE}: {unknown_name('category', category, self._categories)}.")
        return category

    def _table(self, category: str, attribute: Any) -> tuple[str, list[str]]:
        """Name of the table of an attribute, quoted, and its fields."""
        name, known = text(attribute, f"{_SERVICE}: attribute"), self._categories[category]
        if name not in known:
            raise NaoqiRefused(f"{_SERVICE}: {unknown_name('attribute', name, known)}.")
        return f'"{category}/{name}"', known[name]

    def _place(self, name: str) -> Array:
        """In the world, (4, 4)."""
        if name in self._objects:
            placed = self._objects[name]
            H: Array = self._place(placed.parent) @ placed.place
            return H
        if name == ROOT:
            return np.eye(4)
        if self._robot[name]:
            return self._frames.transform(self._robot[name], 1, True)
        return inverse(self._frames.transform(TORSO, 2, True) @ inverse(self._frames.transform(TORSO, 1, True)))

    def _relative(self, reference: Any, name: Any) -> Array:
        H: Array = inverse(self._place(self._known(reference))) @ self._place(self._known(name))
        return H

    def _create_category(self, name: Any, reset: Any) -> int:
        category = _named(name, "category")
        if reset and category in self._categories:
            self._remove_category(category)
        self._categories.setdefault(category, {})
        return 0

    def _remove_category(self, name: Any) -> int:
        category = self._category(name)
        for one in self._in_category(category):
            self._clear(one)
        for attribute in self._categories.pop(category):
            self._run(f'DROP TABLE "{category}/{attribute}"')
        return 0

    def _add_attribute(self, category: Any, attribute: Any, fields: Any) -> int:
        known, name = self._categories[self._category(category)], _named(attribute, "attribute")
        columns = [(_named(field, "field"), _named(kind, "type")) for field, kind in pairs(fields, _SERVICE)]
        if name in known or not columns:
            raise NaoqiRefused(f"{_SERVICE}.addAttributeToCategory: {name} is there already, or has no fields.")
        shown = ", ".join(f'"{field}" {kind}' for field, kind in columns)
        self._run(f'CREATE TABLE "{category}/{name}" ({shown}, {_OBJECT} TEXT)')
        known[name] = [f"{field} {kind}" for field, kind in columns]
        return 0

    def _store(self, name: Any, parent: Any, position: Any, category: Any, attributes: Any) -> int:
        return self._store_seen(name, parent, parent, position, category, attributes)

    def _store_seen(
        self, name: Any, reference: Any, parent: Any, position: Any, category: Any, attributes: Any
    ) -> int:
        one, above, kind = text(name, f"{_SERVICE}: object"), self._known(parent), self._category(category)
        if one in self._objects or one in self._robot or one == ROOT or len(self._objects) >= MAX_OBJECTS:
            raise NaoqiRefused(f"{_SERVICE}: {one!r:.60} is there already, or there are {MAX_OBJECTS} objects.")
        values = pairs(attributes, _SERVICE)
        for attribute, _ in values:
            self._table(kind, attribute)
        place = self._relative(above, reference) @ _transform(position)
        self._objects[one] = _Placed(above, place, kind)
        for attribute, fields in values:
            self._note(one, attribute, fields)
        return 0

    def _note(self, name: Any, attribute: Any, fields: Any) -> int:
        one = self._own(name)
        table, _ = self._table(self._objects[one].category, attribute)
        if self._run(f"SELECT COUNT(*) FROM {table}")[0][0] >= MAX_ROWS:
            raise NaoqiRefused(f"{_SERVICE}: {attribute} has {MAX_ROWS} values; delete some.")
        given = {_named(field, "field"): value for field, value in pairs(fields, _SERVICE)} | {_OBJECT: one}
        columns = ", ".join(f'"{field}"' for field in given)
        self._run(f"INSERT INTO {table} ({columns}) VALUES ({', '.join('?' * len(given))})", [*given.values()])
        return 0

    def _update(self, name: Any, attribute: Any, criterion: Any, fields: Any) -> int:
        one = self._own(name)
        table, _ = self._table(self._objects[one].category, attribute)
        given = {_named(field, "field"): value for field, value in pairs(fields, _SERVICE)}
        changes = ", ".join(f'"{field}" = ?' for field in given)
        where = f"({_criterion(criterion)}) AND {_OBJECT} = ?"
        self._run(f"UPDATE {table} SET {changes} WHERE {where}", [*given.values(), one])
        return 0

    def _delete(self, name: Any, attribute: Any, criterion: Any) -> int:
        one = self._own(name)
        table, _ = self._table(self._objects[one].category, attribute)
        self._run(f"DELETE FROM {table} WHERE ({_criterion(criterion)}) AND {_OBJECT} = ?", [one])
        return 0

    def _clear(self, name: Any) -> int:
        one = self._own(name)
        for child in self._children(one):
            self._clear(child)
        category = self._objects.pop(one).category
        for attribute in self._categories[category]:
            self._run(f"DELETE FROM {self._table(category, attribute)[0]} WHERE {_OBJECT} = ?", [one])
        return 0

    def _children(self, name: Any) -> list[str]:
        above = self._known(name)
        return [one for one, placed in self._objects.items() if placed.parent == above]

    def _in_category(self, name: Any) -> list[str]:
        category = self._category(name)
        return [one for one, placed in self._objects.items() if placed.category == category]

    def _attributes(self, name: Any) -> list[list[str]]:
        fields = self._categories[self._objects[self._own(name)].category]
        return [[attribute, f"({', '.join(of)})"] for attribute, of in fields.items()]

    def _latest(self, name: Any, attribute: str, count: Any) -> list[list[Any]]:
        """Newest values first."""
        table, fields = self._table(self._objects[name].category, attribute)
        limit = round(number(count, f"{_SERVICE}: latestCount", 0, MAX_ROWS))
        rows = self._run(
            f"SELECT * FROM {table} WHERE {_OBJECT} = ? ORDER BY rowid DESC LIMIT ?", [name, limit]
        )
        return [row[: len(fields)] for row in rows]

    def _latest_of(self, name: Any, attribute: Any, count: Any) -> list[list[Any]]:
        one, of = text(name, f"{_SERVICE}: object"), text(attribute, f"{_SERVICE}: attribute")
        if one not in self._objects or of not in self._categories[self._objects[one].category]:
            return []
        return self._latest(one, of, count)

    def _latest_of_all(self, name: Any, count: Any) -> list[list[Any]]:
        one = self._own(name)
        return [[a, self._latest(one, a, count)] for a in self._categories[self._objects[one].category]]

    def _select(self, criterion: Any, category: Any, attribute: Any, fields: Any, order: str = "") -> Any:
        table, known = self._table(self._category(category), attribute)
        names = [field.partition(" ")[0] for field in known]
        wanted = names if fields == "*" else [part.strip() for part in _criterion(fields).split(",")]
        columns = ", ".join(f'"{_named(field, "field")}"' for field in wanted)
        return self._run(f"SELECT {columns} FROM {table} WHERE {_criterion(criterion)} {order}")

    def _select_ordered(self, criterion: Any, order: Any, category: Any, attribute: Any, fields: Any) -> Any:
        found = re.fullmatch(r"(\w+) (ASC|DESC)", text(order, f"{_SERVICE}.selectWithOrder: orderBy"))
        if found is None:
            raise NaoqiRefused(f"{_SERVICE}.selectWithOrder: orderBy must be a field's name and ASC or DESC.")
        return self._select(criterion, category, attribute, fields, f'ORDER BY "{found[1]}" {found[2]}')

    def _move(self, name: Any, position: Any, _store: Any) -> int:
        one = self._own(name)
        self._objects[one] = self._objects[one]._replace(place=_transform(position))
        return 0

    def _move_seen(self, name: Any, reference: Any, position: Any, _store: Any) -> int:
        one = self._own(name)
        place = self._relative(self._objects[one].parent, reference) @ _transform(position)
        self._objects[one] = self._objects[one]._replace(place=place)
        return 0

    def _has(self, name: Any) -> bool:
        return text(name, f"{_SERVICE}: object") in (ROOT, *self._robot, *self._objects)

    def _category_of(self, name: Any) -> str:
        placed = self._objects.get(text(name, f"{_SERVICE}: object"))
        return placed.category if placed else ""

    def _parent(self, name: Any) -> str:
        placed = self._objects.get(self._known(name))
        return placed.parent if placed else ROOT

    def _position(self, reference: Any, name: Any) -> list[list[float]]:
        H = self._relative(reference, name)
        x, y, z, w = Rotation.from_matrix(H[:3, :3]).as_quat().tolist()
        return [[w, x, y, z], H[:3, 3].tolist()]

    def _position6(self, reference: Any, name: Any) -> list[float]:
        """Zeros when one of them is not there, as on the robot."""
        there = self._has(reference) and self._has(name)
        return position6(self._relative(reference, name)) if there else [0.0] * 6

    def methods(self) -> Table:
        """Methods of the service."""
        return {
            "createObjectCategory": self._create_category,
            "removeObjectCategory": self._remove_category,
            "addAttributeToCategory": self._add_attribute,
            "storeObject": self._store,
            "storeObjectWithReference": self._store_seen,
            "storeObjectAttribute": self._note,
            "updateAttribute": self._update,
            "deleteObjectAttribute": self._delete,
            "clearObject": self._clear,
            "findObject": self._has,
            "getChildrenNames": self._children,
            "getObjectNames": lambda: [ROOT, *self._robot, *self._objects],
            "getObjectCategory": self._category_of,
            "getObjectParentName": self._parent,
            "getObjectsInCategory": self._in_category,
            "getObjectAttributes": self._attributes,
            "getObjectAttributeValues": self._latest_of,
            "getObjectLatestAttributes": self._latest_of_all,
            "getPosition": self._position,
            "getPosition6D": self._position6,
            "getRootName": lambda: ROOT,
            "select": lambda criterion, category, attribute, fields: self._select(
                criterion, category, attribute, fields
            ),
            "selectWithOrder": self._select_ordered,
            "updatePosition": self._move,
            "updatePositionWithReference": self._move_seen,
            "save": lambda: 0,
        }


def _named(name: Any, what: str) -> str:
    """A name that SQL can have."""
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise NaoqiRefused(f"{_SERVICE}: {name!r:.60} is no {what}; letters, digits and _ are.")
    return name


def _criterion(value: Any) -> str:
    """Of SQL, also the number 1 for all."""
    return text(str(value) if isinstance(value, int) else value, f"{_SERVICE}: criterion")


def _transform(position: Any) -> Array:
    if not isinstance(position, list) or len(position) != 6:
        raise NaoqiRefused(f"{_SERVICE}: {position!r:.60} was given; [x, y, z, wx, wy, wz] is expected.")
    return from_position6([number(value, f"{_SERVICE}: position", -1e6, 1e6) for value in position])
