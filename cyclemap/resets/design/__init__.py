"""A reset for given demands: candidates, their survey and ranking, and the answer where none meets them."""
