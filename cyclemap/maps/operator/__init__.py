"""The transfer operator of a noisy map: law, spectrum, responses, diffusion, Lyapunov exponent, metastable sets."""
