"""A policy that imitates the gait `omni`: data by both at once, a small network, its file."""
