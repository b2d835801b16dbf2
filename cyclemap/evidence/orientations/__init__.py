"""Measured orientations against a predicted law: distances, tests,
p-values that hold for chains."""
