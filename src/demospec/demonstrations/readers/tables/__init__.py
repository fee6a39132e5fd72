"""Tables of text and NumPy files."""
