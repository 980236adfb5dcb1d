"""LoLA, the low-level interface of the NAO V6: its messages, and both ends of its socket."""
