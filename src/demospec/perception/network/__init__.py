"""The distance network (a small U-Net) and its weights."""
