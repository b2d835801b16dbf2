"""Published statistics of surfaces whose pushes are not at hand, and what they tell of the friction."""
