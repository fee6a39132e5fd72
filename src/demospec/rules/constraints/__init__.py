"""Features that a rule may speak of."""
