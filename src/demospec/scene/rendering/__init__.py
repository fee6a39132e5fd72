"""Rendering of simulated scenes: meshes, light, sprites, tables, and composition."""
