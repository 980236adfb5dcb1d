"""Kinematics of the NAO: legs forward and inverse, the whole tree, the centre of mass."""
