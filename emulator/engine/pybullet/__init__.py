"""PyBullet as an engine; nothing outside this package imports PyBullet or knows its numbers."""
