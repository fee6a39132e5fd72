"""Heads on the distance network's features: symbols, objectness, uncertainty."""
