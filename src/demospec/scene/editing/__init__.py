"""Scene editing: add, move, remove and swap objects, inpainting, free places, placebos."""
