"""The plan of pushes: which to make by hand or robot so that they tell most, and what will be known
after them.
"""
