"""What the robot does otherwise, what that leaves of the orientations, and the search for the best
of it.
"""
