"""Editing of sets: every operation writes a new set."""
