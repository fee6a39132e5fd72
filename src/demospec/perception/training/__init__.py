"""Training of the distance network and its heads on synthetic pictures."""
