"""The cameras of an emulated robot: pictures of the world, drawn in a process of their own."""
