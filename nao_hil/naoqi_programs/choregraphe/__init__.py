"""Behaviours of Choregraphe: their boxes and timelines, played on a served robot."""
