"""Simulated collections: the files that a robot with the given friction, wear and noise would leave behind."""
