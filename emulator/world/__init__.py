"""The world around the robot: floor, terrain, boxes, pushes, and the events that change them."""
