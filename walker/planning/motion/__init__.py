"""Key-frame motions: the file format, the motions that come with the package, and their player."""

from walker.planning.motion.keyframes import Lying, Motion, load_motion, motion_names
from walker.planning.motion.player import MotionPlayer, lying

__all__ = ["Lying", "Motion", "MotionPlayer", "load_motion", "lying", "motion_names"]
