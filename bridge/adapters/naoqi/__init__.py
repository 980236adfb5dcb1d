"""NAOqi on both ends: a robot of the contract as a NAOqi robot, and a NAOqi robot on the contract.

`server` (controller side) runs the cycle of the served robot with a DCM of its own; `calls` answers calls;
`qi_process`, a process of its own without logic, receives them. `bridge` (robot side) is for a real V3 to V5.
"""
