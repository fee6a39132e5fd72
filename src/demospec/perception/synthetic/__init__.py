"""Synthetic training pictures with exact answers: objects, tables, cameras, light."""
