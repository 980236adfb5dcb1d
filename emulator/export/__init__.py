"""The calibrated robot for others: as a MuJoCo model (MJCF), or as URDF, which contains less."""
