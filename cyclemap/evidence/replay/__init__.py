"""Recorded pushes run again by the simulator, and how far off it ends."""
