"""Network emulation: delay, jitter, loss, reordering, limited rate, outages between two network namespaces."""

from nao_hil.network_emulation.site import Channel, EmulatedLink, NetworkConditions, Site

__all__ = ["Channel", "EmulatedLink", "NetworkConditions", "Site"]
"""For a run on a bad network."""
