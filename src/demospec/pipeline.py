"""The flow, top to bottom."""
