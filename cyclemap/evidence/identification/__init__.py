"""Identification: the friction that explains measured motions and forces best, and how well the
data fix it.
"""
