"""What the measured state changes in a plan: swing foot, admittances, torso control, joint compliance."""
