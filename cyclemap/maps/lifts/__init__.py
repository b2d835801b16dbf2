"""Lifts: the CircleMap value, what it may be made of, its branches and crossings of a level, maps
made of maps.
"""
