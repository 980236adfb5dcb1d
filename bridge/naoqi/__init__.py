"""NAOqi on both ends: a robot of the contract posing as a NAOqi robot, and a NAOqi robot put on the contract.

`serve` (controller side): `server` runs the robot's cycle with a DCM of its own and answers calls; `front` is
a process of its own with the qi services, which hold no logic. `robot` (robot side): a real NAO V3 to V5.
"""
