"""Joint drives: position loop, gear, friction, heat and mechanical stops."""
