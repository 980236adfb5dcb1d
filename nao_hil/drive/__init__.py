"""Driving a robot by hand: keys and a stick become walk commands."""
