"""Large sets: batches, parts, samples."""
