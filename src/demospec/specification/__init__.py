"""The specification room."""
