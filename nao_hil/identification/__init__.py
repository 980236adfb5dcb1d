"""Emulated against recorded robot: replay of commands, comparison, identification of the drives."""
