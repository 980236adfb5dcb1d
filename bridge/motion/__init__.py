"""Key-frame motions: the file format, the package's motions, their player, and getting up."""

from bridge.motion.get_up import GET_UP, GetUp, get_up_motions
from bridge.motion.keyframes import Lying, Motion, load_motion, motion_for, motion_names, named_motion
from bridge.motion.player import MotionPlayer, lying

__all__ = [
    "GET_UP",
    "GetUp",
    "Lying",
    "Motion",
    "MotionPlayer",
    "get_up_motions",
    "load_motion",
    "lying",
    "motion_for",
    "motion_names",
    "named_motion",
]
