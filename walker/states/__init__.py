"""The states of the controller, one per file: approach, walk, stand, fallen, motion, rest."""

from walker.states.approach import Approaching
from walker.states.fallen import Fallen
from walker.states.motion import Moving
from walker.states.rest import Resting
from walker.states.stand import Standing
from walker.states.state import State, StateName, legs_hold
from walker.states.walk import Walking

__all__ = [
    "Approaching",
    "Fallen",
    "Moving",
    "Resting",
    "Standing",
    "State",
    "StateName",
    "Walking",
    "legs_hold",
]
