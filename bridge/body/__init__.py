"""Robot data sheets: one TOML per body, typed and checked, the only place for numbers about the robot."""

from bridge.body.joints import TORSO, JointTree, joint_tree
from bridge.body.load import BODIES, load_body
from bridge.body.model import Body

__all__ = ["BODIES", "TORSO", "Body", "JointTree", "joint_tree", "load_body"]
