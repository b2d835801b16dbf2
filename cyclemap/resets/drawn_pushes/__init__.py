"""Which pushes to draw and how often: their library, the best weights, and a convex bound."""
