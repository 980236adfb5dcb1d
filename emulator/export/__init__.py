"""The calibrated robot for others: as a MuJoCo model (MJCF), or as URDF, which says less."""
