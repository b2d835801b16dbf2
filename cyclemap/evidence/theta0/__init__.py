"""Measured θ0, push after push: pairs, their summaries, and what a picture lays over a prediction."""
