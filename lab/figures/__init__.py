"""Figures: pictures of runs, for the documentation and the reports."""
