"""Watching a collection as it grows: is it locking in, towards which direction, and what would
help.
"""
