"""Recorded pushes: files in the MIT layout and CSV tables, checked and gathered into one table."""
