"""Centre of mass of the whole robot (Prenner 2011, 2.4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bridge.body import Body
from bridge.body.quantities import total_mass
from bridge.types import Array
from walker.model.tree import BodyTree


class CentreOfMass:
    """Centre of mass in the Torso frame, from the mass table through the forward kinematics.

    Args:
        body: The data sheet.
    """

    tree: BodyTree
    """The forward kinematics it goes through."""
    mass: float
    """Of the whole robot, kg."""

    def __init__(self, body: Body) -> None:
        self.tree = BodyTree(body)
        links = [body.links[name] for name in self.tree.links]
        self.mass = total_mass(body)
        # Sum of m (R c + p) / M is the frames applied to (m c / M, m / M).
        self._weights = np.array([(*link.com, 1.0) for link in links])
        self._weights *= np.array([[link.mass] for link in links]) / self.mass

    def __call__(self, position: Sequence[float] | Array) -> Array:
        """The centre of mass in the Torso frame, shape (3,), m.

        Args:
            position: The 25 joint positions of a frame, rad.
        """
        return self.of_frames(self.tree.frames(position))

    def of_frames(self, frames: Array) -> Array:
        """The same for link frames that are known already.

        Args:
            frames: `tree.frames(...)`; in another frame than the Torso's the result is in that frame too.
        """
        com: Array = np.einsum("nij,nj->i", frames[:, :3], self._weights)
        return com
