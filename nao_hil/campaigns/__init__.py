"""Campaigns: files of axes, tuning, maps, and queries of stored walks."""
