"""The perception room."""
