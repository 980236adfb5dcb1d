"""What the robot measures, each from the true mechanics: encoders, force sensors, inertial unit."""
