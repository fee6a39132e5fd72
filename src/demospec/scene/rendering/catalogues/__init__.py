"""Catalogues of items: builtin parametric meshes, OBJ files, the Debian furniture library."""
