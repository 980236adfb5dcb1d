"""Physics engines behind one interface: `base.Engine` with its `robot` and its `scene`."""
