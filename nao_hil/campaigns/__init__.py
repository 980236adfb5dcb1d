"""Campaigns that a person describes: files of axes, tuning, maps, and questions to what was walked."""
