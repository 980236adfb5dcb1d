"""One run: its configuration, robot and controller built from it, in process, its folder, and its result."""
