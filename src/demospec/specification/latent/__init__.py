"""The latent plane z_θ: validity maps, sampling and repair of trajectories."""
