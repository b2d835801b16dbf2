"""Periodic orbits: all of them to a stated resolution, their basins, and the slow passages they leave behind."""
