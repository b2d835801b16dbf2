"""Resets that hold for more than one material: over a range, over a posterior, over a list, and as a surface wears."""
