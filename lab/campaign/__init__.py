"""Many walks: run over the cores, kept by what they were, and counted honestly."""
