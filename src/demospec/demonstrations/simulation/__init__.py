"""Simulated demonstrators with known truth."""
