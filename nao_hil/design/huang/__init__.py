"""Search for the hip motion of the gait huang with the largest stability margin."""
