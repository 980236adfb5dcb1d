"""The live page: the robot in 3-D, its loads and balance, charts, and orders to it."""
