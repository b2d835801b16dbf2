"""Panels that pages and figures are laid out of: each draws a result on axes, and computes
nothing; and their look and layout.
"""
