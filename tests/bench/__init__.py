"""Benchmarks: each figure with its floor, measured in the same run. Medians and ratios; no verdicts."""
