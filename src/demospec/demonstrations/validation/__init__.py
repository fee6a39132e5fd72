"""Validation of a set on disk: every fault and every oddity."""
