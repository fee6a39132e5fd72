"""LeRobot datasets of the layouts v2 and v3."""
