"""Lifts: the CircleMap value, what it may be made of, and the textbook maps."""
