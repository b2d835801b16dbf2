"""Laws of measured values: fitted over θ0 with order, scatter, wear and bands, set by set, and how
far samples lie from a law on the circle.
"""
