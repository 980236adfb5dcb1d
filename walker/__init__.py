"""The controller: kinematics, planning, stabilising and the walking state machine."""
