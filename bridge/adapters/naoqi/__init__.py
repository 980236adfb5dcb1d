"""NAOqi on both ends: a robot of the contract as a NAOqi robot, and a NAOqi robot on the contract.

`server` (controller side) runs the cycle of the served robot with a DCM of its own; `calls` answers calls;
`qi_server`, without logic of the robot's, receives them. `real_robot` (robot side) is for a real V3 to V5.
"""
