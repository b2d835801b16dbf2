"""Maps that several tests of the least correction share, each with its name."""

import numpy as np

from cyclemap.maps.lifts.circle_map import CircleMap

SINE = CircleMap.arnold(0.1, 0.9)


def random_map(seed: int) -> CircleMap:
    """A lift of degree 1 with four random harmonics, invertible or folded."""
    rng = np.random.default_rng(seed)
    orders = np.arange(1, 5)
    sines, cosines = rng.normal(0.0, 0.5, (2, 4)) / orders
    shift = rng.uniform(0.0, 2 * np.pi)

    def lift(theta):
        waves = np.multiply.outer(theta, orders)
        return theta + shift + np.sin(waves) @ sines + np.cos(waves) @ cosines

    def derivative(theta):
        waves = np.multiply.outer(theta, orders)
        return 1.0 + np.cos(waves) @ (orders * sines) - np.sin(waves) @ (orders * cosines)

    return CircleMap(lift, derivative)
