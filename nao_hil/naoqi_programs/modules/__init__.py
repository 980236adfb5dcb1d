"""Modules that programs for NAOqi import; this folder is on their path."""
