"""Families of maps: following orbits, locating bifurcations, tongue boundaries."""
