"""Inference on one picture: observation, segments, merging of segments."""
