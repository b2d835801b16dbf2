"""Families of maps: rotation numbers and long orbits, orbits followed, bifurcations, tongue
boundaries.
"""
