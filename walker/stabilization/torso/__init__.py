"""Torso control: keep the torso upright with the AnklePitch of the stance leg (thesis 4.2)."""
