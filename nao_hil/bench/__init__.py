"""Benchmarks: each figure beside its floor, measured in the same run. Medians and ratios; no verdicts."""
