"""Families of maps: long orbits over parameters, orbits followed, bifurcations, tongue boundaries."""
