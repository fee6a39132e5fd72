"""Specification models: β-VAE, maximum-entropy IRL, perceived rule, ensembles, folders."""
