"""cyclemap: the push-then-drag-back data-collection loop of a robot as a map of the circle."""
