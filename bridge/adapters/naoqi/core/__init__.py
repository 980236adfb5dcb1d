"""The robot itself: device, joints, motion, walking, memory, sensors, cameras."""
