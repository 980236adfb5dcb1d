"""The ground of the picture: floor, tiles, heights, boxes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bridge.messages.world_state import Terrain, WorldObject
from bridge.rotations import rotation
from nao_hil.view.looks import terrain_meshes
from nao_hil.view.scene.lines import quaternions, wxyz
from nao_hil.view.scene.palette import CELLS, GROUND, OBSTACLE, OVER, ROOT, SECTIONS
from walker.estimation.odometry import GroundPlane


class GroundScene:
    """Draws the world without its robot.

    Args:
        scene: `viser.ViserServer.scene`.
        dark: The page is dark.
    """

    def __init__(self, scene: Any, dark: bool) -> None:
        self._scene, self._dark = scene, dark
        self._plane = GroundPlane()
        self._terrain = Terrain()
        self._terrain_meshes: list[Any] = []
        self._objects: dict[str, tuple[WorldObject, Any]] = {}
        self._draw_floor()

    def point(self, x: float, y: float) -> tuple[float, float, float]:
        """A point that is drawn on the floor, m."""
        return x, y, self._plane.at(x, y) + OVER

    def dress(self, dark: bool) -> None:
        """Draw the floor for a dark or a light page."""
        self._dark = dark
        self._draw_floor()

    def set_floor(self, plane: GroundPlane) -> None:
        """Draw the floor as it lies."""
        if plane != self._plane:
            self._plane = plane
            self._draw_floor()

    def _draw_floor(self) -> None:
        self._scene.add_grid(
            f"{ROOT}/floor",
            width=100.0,
            height=100.0,
            cell_size=0.1,
            section_size=0.5,
            cell_color=CELLS[self._dark],
            section_color=SECTIONS[self._dark],
            wxyz=quaternions(rotation(self._plane.roll, self._plane.pitch, 0.0)[None])[0],
            position=(0.0, 0.0, self._plane.height - 0.001),
        )

    def set_terrain(self, terrain: Terrain) -> None:
        """Draw tiles and heights; they turn with the floor."""
        if terrain == self._terrain:
            return
        self._terrain = terrain
        for handle in self._terrain_meshes:
            handle.remove()
        self._terrain_meshes = [
            self._scene.add_mesh_simple(
                f"{ROOT}/floor/terrain/{i}",
                vertices,
                faces,
                color=GROUND,
                opacity=0.6,
                flat_shading=True,
                side="double",
            )
            for i, (vertices, faces) in enumerate(terrain_meshes(terrain))
        ]

    def set_objects(self, objects: Sequence[WorldObject]) -> None:
        """Draw the world's boxes as they are."""
        for name in set(self._objects) - {o.name for o in objects}:
            self._objects.pop(name)[1].remove()
        for thing in objects:
            known = self._objects.get(thing.name)
            if known is not None and known[0] == thing:
                continue
            if known is not None and known[0].size == thing.size:
                handle = known[1]
                handle.position, handle.wxyz = thing.position, wxyz(thing.orientation)
            else:
                handle = self._scene.add_box(
                    f"{ROOT}/objects/{thing.name}",
                    OBSTACLE,
                    dimensions=thing.size,
                    position=thing.position,
                    wxyz=wxyz(thing.orientation),
                )
            self._objects[thing.name] = (thing, handle)
