"""The named plots of a recording."""
