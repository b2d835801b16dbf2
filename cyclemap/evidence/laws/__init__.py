"""Periodic laws and cycle maps fitted to measured values, with their order, scatter, wear and
bands.
"""
