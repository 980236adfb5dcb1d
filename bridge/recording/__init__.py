"""Recordings of runs in MCAP: writing, reading, and the observers of a run."""
