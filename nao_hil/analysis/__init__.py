"""Figures of runs: statistics, diagnosis of falls, plots and reports."""
