"""The experiments: what the robot is and does, measured on the emulated one, each with figures."""
