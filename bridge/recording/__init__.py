"""Recordings of runs in MCAP: written, read back, and the observers that are told of a run."""
