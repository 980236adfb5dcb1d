"""Bad networks: delay, jitter, loss, reordering, narrow lines and cuts between two network namespaces."""

from lab.weather.channel import Channel, Weather
from lab.weather.line import Line
from lab.weather.site import Site

__all__ = ["Channel", "Line", "Site", "Weather"]
"""What a run on a bad network needs."""
