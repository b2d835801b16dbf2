"""Damage done on purpose: `python -m tests.faults` at full size, a seeded sample of it among the
tests.
"""
