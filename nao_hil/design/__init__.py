"""Design of the numbers that the walker loads: torso controllers and the hip motion of the gait huang."""
