"""Lifts: the CircleMap value, what it may be made of, its monotone branches, and maps made of maps."""
