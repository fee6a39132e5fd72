"""The paper's β-VAE specification model, single and stacked."""
