"""Orbits: periodic ones to a stated resolution, their basins, slow passages, and how fast orbits rotate."""
