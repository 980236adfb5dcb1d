"""Robot data sheets: one TOML per body, typed and checked, the only place for numbers about the robot."""

from bridge.datasheet.load import BODIES, load_body
from bridge.datasheet.model import Body
from bridge.datasheet.topology import TORSO, JointTree, joint_tree

__all__ = ["BODIES", "TORSO", "Body", "JointTree", "joint_tree", "load_body"]
