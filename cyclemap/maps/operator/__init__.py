"""The transfer operator of a noisy map: stationary distribution, spectrum, diffusion."""
