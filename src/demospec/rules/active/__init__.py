"""Active learning: the demonstration to ask for next."""
