"""Reset strategies: what the robot does otherwise, as small values that act on the loop."""
