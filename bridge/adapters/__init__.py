"""Adapters between the link and other robots' protocols: LoLA and NAOqi."""
