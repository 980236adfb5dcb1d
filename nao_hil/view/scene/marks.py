"""The balance in the picture: points, loads on the feet, support polygon, footprints."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from bridge.body import Body
from bridge.types import SIDES, Array
from nao_hil.analysis.diagnosis import Balance
from nao_hil.view.footprints import Footprints
from nao_hil.view.looks import Colour
from nao_hil.view.scene.ground import GroundScene
from nao_hil.view.scene.lines import add_lines, closed, line_colour, show
from nao_hil.view.scene.palette import BARS_OVER, COM, LOST, NEWTON, POINTS, PRINTS, ROOT, SAFE
from nao_hil.view.support import soles_that_touch, tips
from walker.model.floating_base import FloatingBase

FOOTPRINTS: Final = 40
"""Last ones that are kept."""


class BalanceMarks:
    """Draws them, moment by moment.

    Args:
        scene: `viser.ViserServer.scene`.
        body: Data sheet of the robot.
        kinematics: Of the body.
        ground: What the marks lie on.
    """

    def __init__(self, scene: Any, body: Body, kinematics: FloatingBase, ground: GroundScene) -> None:
        self._body, self._kinematics, self._ground = body, kinematics, ground
        self._points = {
            p.name: scene.add_icosphere(f"{ROOT}/points/{p.name}", p.radius, p.colour, subdivisions=2)
            for p in POINTS
        }
        # Parts of what they stand on: a browser moves frames at once, but takes its time for points of lines.
        self._bars = {
            side: add_lines(scene, f"{ROOT}/robot/{side}AnkleRoll/loads", 4, SAFE, 10.0, each=True)
            for side in SIDES
        }
        self._plumb = add_lines(scene, f"{ROOT}/points/com/plumb", 1, COM, 2.0)
        self._edge = add_lines(scene, f"{ROOT}/support/edge", 1, SAFE, 4.0)
        self._area = scene.add_mesh_simple(
            f"{ROOT}/support/area",
            np.zeros((3, 3)),
            np.array([[0, 1, 2]]),
            color=SAFE,
            opacity=0.25,
            side="double",
        )
        self._print_lines = {
            kind: add_lines(scene, f"{ROOT}/footprints/{kind}", 1, colour, 2.0)
            for kind, colour in PRINTS.items()
        }
        self._begin_footprints()

    def forget(self) -> None:
        """The robot began anew: footprints go."""
        self._begin_footprints()
        for lines in self._print_lines.values():
            lines.points = np.zeros((1, 2, 3), dtype=np.float32)

    def _begin_footprints(self) -> None:
        self._footprints = Footprints(self._kinematics)
        self._prints: dict[str, list[Array]] = {kind: [] for kind in PRINTS}

    def draw(self, balance: Balance) -> None:
        """Show one moment."""
        self._draw_points(balance)
        self._draw_loads(balance)
        self._draw_support(balance)
        self._draw_footprints(balance)

    def _draw_points(self, balance: Balance) -> None:
        best, plan, com = balance.best, balance.plan, balance.best.robot.com
        below = (float(com[0]), float(com[1]))
        flat = {
            "zmp_plan": plan.zmp if plan else None,
            "zmp_fsr": balance.felt,
            "zmp_true": balance.true.zmp if balance.true else None,
            "com_ground": below,
            "capture": best.capture,
        }
        self._points["com"].position = com
        for name, place in flat.items():
            show(self._points[name], place is not None)
            if place is not None:
                self._points[name].position = np.array(self._ground.point(*place))
        self._plumb.points = np.array([[np.zeros(3), self._ground.point(*below) - com]], dtype=np.float32)

    def _draw_loads(self, balance: Balance) -> None:
        """A bar over each force cell, from green to red at its end of range."""
        fsr, sheet = balance.moment.sensors.fsr, self._body.fsr
        for side, places, forces in zip(SIDES, (sheet.L, sheet.R), (fsr[:4], fsr[4:]), strict=True):
            starts = np.array(places) + np.array([0.0, 0.0, BARS_OVER])
            ends = starts + np.outer(NEWTON * np.maximum(forces, 0.0), (0.0, 0.0, 1.0))
            shares = np.clip(np.array(forces) / sheet.range, 0.0, 1.0)
            colours = [[line_colour(_between(SAFE, LOST, share))] * 2 for share in shares]
            self._bars[side].points = np.stack([starts, ends], axis=1).astype(np.float32)
            self._bars[side].colors = np.array(colours, dtype=np.uint8)

    def _draw_support(self, balance: Balance) -> None:
        polygon = soles_that_touch(self._kinematics, balance.best)
        for handle in (self._edge, self._area):
            show(handle, polygon is not None)
        if polygon is None or len(polygon.corners) < 3:
            return
        corners = np.array([self._ground.point(*corner) for corner in polygon.corners])
        colour = LOST if tips(balance.best, polygon) else SAFE
        self._edge.points = closed(corners)
        self._edge.colors = line_colour(colour)  # one for all, however many they are
        self._area.vertices = corners.astype(np.float32)
        self._area.faces = np.array([(0, i, i + 1) for i in range(1, len(corners) - 1)], dtype=np.uint32)
        self._area.color = colour

    def _draw_footprints(self, balance: Balance) -> None:
        """A new outline where a foot was meant to come down, and where it did."""
        for kind, flat in self._footprints.update(balance):
            prints = self._prints[kind]
            prints.append(closed(np.array([self._ground.point(float(x), float(y)) for x, y in flat])))
            del prints[:-FOOTPRINTS]
            self._print_lines[kind].points = np.concatenate(prints)


def _between(a: Colour, b: Colour, share: float) -> Colour:
    r, g, blue = (round(p + share * (q - p)) for p, q in zip(a, b, strict=True))
    return r, g, blue
