"""Measured θ0, push after push: pairs, summaries, and the staircase they make."""
