"""Orbits: periodic ones to a stated resolution, their basins, slow passages, and how fast those of
one map rotate.
"""
