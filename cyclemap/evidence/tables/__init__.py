"""Tables and comparisons of one set of repeated pushes: its statistics, its laws, its histogram,
its cycle map.
"""
