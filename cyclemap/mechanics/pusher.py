"""The rod that pushes."""

from dataclasses import dataclass

from cyclemap.checks import non_negative_number


@dataclass(frozen=True)
class Pusher:
    """A vertical rod: radius in m (zero: a point) and its Coulomb friction coefficient with the slider.

    >>> Pusher().radius
    0.00475
    """

    radius: float = 0.00475
    friction: float = 0.15

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", non_negative_number("pusher radius", self.radius))
        object.__setattr__(self, "friction", non_negative_number("pusher friction", self.friction))
