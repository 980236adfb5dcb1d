"""Sensors, each measured from the true mechanics: encoders, force sensors, inertial unit, and more."""
