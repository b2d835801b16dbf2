"""Random families of two parameters, some with kinks or jumps that move, and the equations of their
bifurcations written out once more, solved in longer floats.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cyclemap.maps import CircleMap

LONG = np.longdouble
TWO_PI = 8 * np.arctan(LONG(1))
_HARMONICS = np.arange(1, 3)
_SAMPLES = 240
_NEWTON_STEPS = 12
Unknowns = np.ndarray  # long floats: the angle of the orbit's first point, and both parameters


@dataclass(frozen=True, eq=False)
class RandomFamily:
    """F(θ; p, q) = θ + p + waves + q times other waves + bend |d| + jump sign(d)/2, d the angle
    from a break at ``place`` + ``drift``·p; where d = π lies a second break.

    slopes : whether F' is given.
    sampled : whether the members are piecewise cubics through samples with ``max_error``.
    period, winding : of the orbits asked for.
    """

    sizes: np.ndarray
    phases: np.ndarray
    bend: float
    jump: float
    place: float
    drift: float
    slopes: bool
    sampled: bool
    period: int
    winding: int
    first: tuple[float, float]
    second: tuple[float, float] = (-1.0, 1.0)

    @property
    def max_error(self) -> float:
        """Of cubics through values and slopes: h⁴/384 times the fourth derivative's size."""
        steepest = float(np.sum(np.abs(self.sizes) * _HARMONICS**4))
        return (2 * np.pi / _SAMPLES) ** 4 / 384 * steepest if self.sampled else 0.0

    def breaks(self, p: np.ndarray | float) -> np.ndarray:
        """Both breaks, radians; none of a smooth family."""
        if not self.bend and not self.jump:
            return np.zeros(0)
        return self.place + self.drift * p + np.array([0, TWO_PI / 2])

    def __call__(self, p: float, q: float) -> CircleMap:
        # The waves once more, by half as many calls: the map is asked thousands of times.
        sizes, phases = self.sizes * np.array([[1.0], [q]]), self.phases
        first, second = np.sum(sizes * np.exp(1j * phases), axis=0).tolist()
        place = self.place + self.drift * p

        def lift(theta: np.ndarray) -> np.ndarray:
            s, c = np.sin(theta), np.cos(theta)
            wave = (first.real + 2.0 * second.real * c) * s + first.imag * c
            image = theta + p + wave + second.imag * (1.0 - 2.0 * s * s)
            if not self.bend and not self.jump:
                return image
            away = np.mod(theta - place + np.pi, 2 * np.pi) - np.pi
            return image + self.bend * np.abs(away) + np.where(away < 0.0, -0.5, 0.5) * self.jump

        def slope(theta: np.ndarray) -> np.ndarray:
            s, c = np.sin(theta), np.cos(theta)
            wave = (first.real - 4.0 * second.imag * s) * c - first.imag * s
            steep = 1.0 + wave + 2.0 * second.real * (1.0 - 2.0 * s * s)
            if not self.bend:
                return steep
            away = np.mod(theta - place + np.pi, 2 * np.pi) - np.pi
            return steep + np.where(away < 0.0, -self.bend, self.bend)

        if self.sampled:
            nodes = np.linspace(0.0, 2 * np.pi, _SAMPLES, endpoint=False)
            return CircleMap.from_samples(
                nodes, lift(nodes), slope(nodes), max_error=self.max_error
            )
        return CircleMap(lift, slope if self.slopes else None, self.breaks(p).astype(float))

    def derivative(
        self, order: int, theta: np.ndarray, p: float, q: float, side: int = 0
    ) -> np.ndarray:
        """F (order 0) or one of its first three derivatives, in floats as long as ``theta``'s.

        side : next to a break the piece below (-1) or above it (1), which then goes on beyond it.
        """
        turn = theta.dtype.type(TWO_PI)
        weights = self.sizes * np.array([[1.0], [q]]) * _HARMONICS**order
        value = 0.0 * theta
        for weight, phase, harmonic in zip(weights.T, self.phases.T, _HARMONICS, strict=True):
            angle = harmonic * theta + order * turn / 4
            value = value + weight[0] * np.sin(angle + phase[0])
            value = value + weight[1] * np.sin(angle + phase[1])
        if order < 2:
            value = value + (1 if order else theta + p)
        if order > 1 or not (self.bend or self.jump):
            return value
        away = theta - self.place - self.drift * p
        away = away - turn * np.floor(away / turn + 0.5)
        sign = np.where(away < 0, -1, 1)
        if side:
            opposite = abs(away) > 1.0
            sign = -side if opposite else side
            away = away + turn * sign * (opposite and sign * away < 0)
        return value + sign * (self.bend if order else self.bend * away + 0.5 * self.jump)

    def iterated(self, unknowns: Unknowns, side: int) -> list[np.ndarray]:
        """F^n - id - 2πw, and the first three derivatives of F^n."""
        theta, p, q = unknowns
        value, one, two, three = (self.derivative(order, theta, p, q, side) for order in range(4))
        for _ in range(self.period - 1):
            value, slope, bend, twist = (self.derivative(order, value, p, q) for order in range(4))
            three = twist * one**3 + 3 * bend * one * two + slope * three
            two = bend * one**2 + slope * two
            one = slope * one
        return [value - theta - TWO_PI * self.winding, one, two, three]

    def equations(
        self, kind: str, near: Unknowns, side: int = 0
    ) -> Callable[[Unknowns], np.ndarray]:
        """What is 0 at a bifurcation of this kind, with a ``side`` on the break near ``near``."""
        which = np.argmin(np.abs(_shorter(near[0] - self.breaks(near[1])))) if side else 0

        def residual(unknowns: Unknowns) -> np.ndarray:
            orbit, one, two, three = self.iterated(unknowns, side)
            conditions = {
                "saddle-node": [one - 1],
                "period-doubling": [one + 1],
                "border-collision": [],
                "cusp": [one - 1, two],
                "generalised flip": [one + 1, two**2 / 4 + three / 6],
                "border saddle-node": [one - 1],
                "border flip": [one + 1],
            }[kind]
            if side:
                gap = unknowns[0] - self.breaks(unknowns[1])[which]
                conditions = [*conditions, _shorter(gap)]
            return np.array([orbit, *conditions])

        return residual


def root(
    residual: Callable[[Unknowns], np.ndarray], near: Unknowns, free: int
) -> tuple[Unknowns, float] | None:
    """The nearest root of the first ``free`` unknowns, and how far it moves for a residual of one;
    None without one.
    """
    at = near.astype(LONG)
    step = LONG(1e-9)  # shorter than any walk ends before a break
    columns = [
        (residual(at + step * unit) - residual(at - step * unit)) / (2 * step)
        for unit in np.eye(3, dtype=LONG)[:free]
    ]
    inverse = np.linalg.pinv(np.stack(columns, axis=1).astype(float))
    for _ in range(_NEWTON_STEPS):
        at[:free] -= inverse @ residual(at)
        if not np.all(np.abs(at - near) < 0.1):
            return None
    if not np.max(np.abs(residual(at))) < 2e-17:
        return None
    return at, float(np.linalg.norm(inverse, 2))


def _shorter(angle: np.ndarray) -> np.ndarray:
    return angle - TWO_PI * np.round(angle / TWO_PI)


def random_family(rng: np.random.Generator) -> RandomFamily:
    """Two harmonics in either wave; one in three with kinks, one in six with jumps, half of these
    moving; one in ten sampled; of one in four the orbits of period 2.
    """
    sizes = rng.uniform(-1.0, 1.0, (2, 2)) * [0.8, 0.5] * rng.uniform(0.2, 2.0)
    kind = rng.choice(["smooth", "kink", "jump", "sampled"], p=[0.4, 0.33, 0.17, 0.1])
    bend = rng.uniform(-0.6, 0.6) if kind in ("kink", "jump") else 0.0
    jump = rng.uniform(-1.0, 1.0) if kind == "jump" else 0.0
    twice = bool(rng.uniform() < 0.25)
    reach = float(np.abs(sizes).sum() + abs(bend) * np.pi + 0.5 * abs(jump)) + 0.3
    return RandomFamily(
        sizes,
        rng.uniform(0.0, 2 * np.pi, (2, 2)),
        bend,
        jump,
        place=rng.uniform(0.0, 2 * np.pi),
        drift=rng.uniform(-0.5, 0.5) if rng.uniform() < 0.5 else 0.0,
        slopes=bool(rng.uniform() < 0.9),
        sampled=bool(kind == "sampled"),
        period=1 + twice,
        winding=int(twice),
        first=(np.pi - 1.0, np.pi + 1.0) if twice else (-reach, reach),
    )
