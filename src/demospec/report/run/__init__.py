"""A run folder as typed documents."""
