"""Scenes, paths and rings as SVG: the same lines on the report and in the studio."""
