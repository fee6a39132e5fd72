"""Pictures as PNG, drawn by matplotlib."""
