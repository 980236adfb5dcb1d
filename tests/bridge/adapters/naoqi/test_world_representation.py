"""ALWorldRepresentation by the vendor's page: returns, positions that move with their parents, SQL criteria."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from bridge.errors import NaoqiRefused
from bridge.messages import SensorFrame
from tests.bridge.adapters.naoqi.served import Robot

ROBERT = [["Facts", [["Name", "Robert"], ["Age", 42]]]]


@pytest.fixture
def world(standing: Callable[..., SensorFrame]) -> Callable[..., Any]:
    robot = Robot(standing())

    def call(method: str, *arguments: Any) -> Any:
        return robot.call("ALWorldRepresentation", method, *arguments)

    assert call("createObjectCategory", "People", True) == 0
    assert call("addAttributeToCategory", "People", "Facts", [["Name", "TEXT"], ["Age", "INTEGER"]]) == 0
    return call


def test_children_move_with_their_parent(world: Callable[..., Any]) -> None:
    quarter = math.pi / 2
    assert world("storeObject", "table", "World", [1.0, 0.0, 0.0, 0.0, 0.0, quarter], "People", []) == 0
    assert world("storeObject", "cup", "table", [0.5, 0.0, 0.1, 0.0, 0.0, 0.0], "People", []) == 0
    assert world("getPosition6D", "World", "cup") == pytest.approx([1.0, 0.5, 0.1, 0, 0, quarter])
    world("updatePosition", "table", [2.0, 0.0, 0.0, 0.0, 0.0, 0.0], False)
    assert world("getPosition6D", "World", "cup") == pytest.approx([2.5, 0.0, 0.1, 0, 0, 0])
    quaternion, place = world("getPosition", "cup", "table")
    assert quaternion == pytest.approx([1, 0, 0, 0])
    assert place == pytest.approx([-0.5, 0.0, -0.1])
    seen = ["World", "table", [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]]  # reference, parent, place in the reference
    assert world("storeObjectWithReference", "spoon", *seen, "People", []) == 0
    assert world("getPosition6D", "table", "spoon") == pytest.approx([1.0, 0, 0, 0, 0, 0])
    assert sorted(world("getChildrenNames", "table")) == ["cup", "spoon"]
    assert world("getObjectParentName", "cup") == "table"
    assert world("getObjectParentName", "World") == "World" == world("getRootName")
    assert world("clearObject", "table") == 0
    assert [world("findObject", name) for name in ("table", "cup", "World")] == [False, False, True]
    assert world("getPosition6D", "World", "cup") == [0.0] * 6


def test_the_robots_torso_is_where_almotion_says(world: Callable[..., Any], standing: Any) -> None:
    robot = Robot(standing())
    there = robot.call("ALWorldRepresentation", "getPosition6D", "World", "Robot_Torso")
    assert there == pytest.approx(robot.motion("getPosition", "Torso", 1, True), abs=1e-6)
    head = robot.call("ALWorldRepresentation", "getPosition6D", "Robot_Torso", "HeadPitch")
    assert head[2] == pytest.approx(0.1265, abs=1e-4)  # the vendor's neck offset


def test_attributes_are_selected_by_sql_criteria(world: Callable[..., Any]) -> None:
    world("storeObject", "p1", "World", [0.0] * 6, "People", ROBERT)
    world("storeObject", "p2", "World", [0.0] * 6, "People", [["Facts", [["Name", "Anna"], ["Age", 30]]]])
    assert world("select", "Name='Robert' AND Age=42", "People", "Facts", "*") == [["Robert", 42]]
    assert world("selectWithOrder", "Age > 1", "Age ASC", "People", "Facts", "Age, Name") == [
        [30, "Anna"],
        [42, "Robert"],
    ]
    assert world("storeObjectAttribute", "p1", "Facts", [["Name", "Bob"], ["Age", 43]]) == 0
    assert world("getObjectAttributeValues", "p1", "Facts", 1) == [["Bob", 43]]
    assert world("getObjectLatestAttributes", "p1", 5) == [["Facts", [["Bob", 43], ["Robert", 42]]]]
    assert world("getObjectAttributes", "p1") == [["Facts", "(Name TEXT, Age INTEGER)"]]
    assert world("updateAttribute", "p1", "Facts", "Age=42", [["Age", 44]]) == 0
    assert world("deleteObjectAttribute", "p1", "Facts", "Age=43 OR Age < 1") == 0
    assert world("getObjectAttributeValues", "p1", "Facts", 9) == [["Robert", 44]]
    assert world("getObjectAttributeValues", "nobody", "Facts", 9) == []
    assert sorted(world("getObjectsInCategory", "People")) == ["p1", "p2"]
    assert world("getObjectCategory", "p1") == "People"
    assert world("getObjectCategory", "nobody") == ""
    assert world("removeObjectCategory", "People") == 0
    assert not world("findObject", "p1")


@pytest.mark.parametrize(
    ("method", "arguments", "sentence"),
    [
        ("storeObject", ["a", "nobody", [0.0] * 6, "People", []], "unknown object 'nobody'"),
        ("storeObject", ["a", "World", [0.0] * 6, "Things", []], "unknown category 'Things'"),
        ("storeObject", ["a", "World", [0.0] * 3, "People", []], "is expected"),
        ("storeObject", ["a", "World", [0.0] * 6, "People", [["Size", []]]], "unknown attribute 'Size'"),
        ("clearObject", ["Robot_Torso"], "the robot's own"),
        ("select", ["Nobody=1", "People", "Facts", "*"], "SQLite refuses it: no such column"),
        ("select", ["1; DROP TABLE x", "People", "Facts", "*"], "SQLite refuses it"),
        ("select", ["1", "People", "Facts", 'Name" FROM x --'], "is no field"),
        (
            "select",
            [
                "(WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i FROM n) SELECT COUNT(*) FROM n)",
                "People",
                "Facts",
                "*",
            ],
            "SQLite refuses it: interrupted",
        ),
    ],
)
def test_what_does_not_fit_is_refused_in_a_sentence(
    world: Callable[..., Any], method: str, arguments: list[Any], sentence: str
) -> None:
    world("storeObject", "p1", "World", [0.0] * 6, "People", ROBERT)
    with pytest.raises(NaoqiRefused, match=sentence):
        world(method, *arguments)
