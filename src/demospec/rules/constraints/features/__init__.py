"""Features of a path that constraints speak of: what they measure, and their registry."""
