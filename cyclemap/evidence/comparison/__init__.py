"""A prediction set beside a collection: pushes, cycle map, orientations, stable directions,
staircase; and recorded pushes run again.
"""
