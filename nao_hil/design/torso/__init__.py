"""Design of the torso controllers (thesis 4.2) whose numbers the walker loads."""
