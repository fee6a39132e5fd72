"""Joint recordings: forward kinematics from a robot's description to the path of one link."""
