"""Strategies as files: protocols in TOML, and what the robot does cycle by cycle in CSV."""
