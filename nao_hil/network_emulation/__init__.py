"""Network emulation: delay, jitter, loss, reordering, limited rate, outages between two network namespaces."""

from nao_hil.network_emulation.channel import Channel, NetworkConditions
from nao_hil.network_emulation.site import EmulatedLink, Site

__all__ = ["Channel", "EmulatedLink", "NetworkConditions", "Site"]
"""What a run on a bad network needs."""
