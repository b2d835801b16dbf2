"""Rotation numbers and intervals with enclosures, of one map, of many, and over a plane."""
