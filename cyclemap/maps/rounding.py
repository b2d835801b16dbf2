"""What double precision leaves: each allowance of this room once, with its unit and its reason.

An allowance goes into an error bound beside what was measured; none of them decides where an algorithm stops.
"""

from __future__ import annotations

import numpy as np

EPS = float(np.finfo(float).eps)
"""2⁻⁵², the spacing of floats at 1: twice the relative error of one operation."""

LIFT = 4.0 * EPS
"""Of 2π + |F|: one value of a lift, or of 1 + |F'| one of its derivative; a sine, two products and two sums."""

STENCIL = 12.0 * EPS
"""Of the values that a five-point difference adds up: three ``LIFT``, the sum of its weights' sizes being 1.5 to 10."""

MEAN = 2.0 * EPS
"""Of the largest value: a mean by numpy's pairwise sum, and the rounding of its weights."""

INTEGRAL = 16.0 * EPS
"""Of Σ |weight·value|: an integral by a rule of some thousand nodes, each value rounded a few times."""

MATRIX = 4.0 * EPS
"""Of a matrix's norm: what an eigenvalue solver or a product of matrices adds to it (backward error)."""

SOLUTION = 16.0 * EPS
"""Of a value interpolated from a solved system: its sum, and the last digit of the float that it is given as."""

ELIMINATION = 1e-13
"""Relative: elimination without subtraction of some thousand states (O'Cinneide 1993 proves n³ EPS; seen: 1e-14)."""

QUASI_STATIONARY = 1e-12
"""Relative: a leaving chance from an iteration that ends at changes of 1e-13."""

LOG_PASSAGE = 2e-14
"""Of ln T, relative: a hundred ``EPS``, for logarithms added up along the ways out."""

ANGLE = 1e-13
"""Radians: an angle after whole turns are taken off and a root is solved, a hundred spacings of floats at 2π."""

SAME_ANGLE = 1e-14
"""Radians: angles nearer than this, some ten spacings of floats at 2π, are one that was reached in two ways."""

STAIRCASE = 1e-9
"""Of a window of angles from a file: ten printed digits."""
