"""Estimates that many mechanisms read: torso angle, contacts, ground, falls, odometry."""
