"""The transfer operator of a noisy map: law, spectrum, responses, diffusion, metastable sets."""
