"""Robot data sheets: one TOML per body, typed and checked, the only place for numbers about the robot."""

from bridge.body.joints import TORSO, JointTree, joint_tree
from bridge.body.load import BODIES, body_of, load_body, sheet_of
from bridge.body.model import Body

__all__ = ["BODIES", "TORSO", "Body", "JointTree", "body_of", "joint_tree", "load_body", "sheet_of"]
