"""What every room counts with: arrays of doubles, and a whole turn."""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TWO_PI = 2.0 * math.pi
