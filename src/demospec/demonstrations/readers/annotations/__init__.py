"""Annotated pictures: objects from detection formats, paths and objects that people drew."""
