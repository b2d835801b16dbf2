"""Least noise: how little extra turning makes the orientations even, with proven bounds."""
