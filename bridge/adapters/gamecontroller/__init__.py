"""The GameController of the RoboCup Standard Platform League: its packets, a referee, a listener."""
