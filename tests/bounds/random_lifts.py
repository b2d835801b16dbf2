"""Random lifts with detail, jumps and kinks, and the same numbers by dense sums that know where the
breaks are.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import ive

from cyclemap.maps import CircleMap, Noise, UniformNoise, VonMises, WrappedCauchy, WrappedNormal

TWO_PI = 2 * np.pi
MOST_WAVES = 5_000
_NODES = 20
# Of ln|F'|, whose singularities lie beside the circle where F' is small: F' > .01 leaves 1e-14.
_LOGARITHM_PANELS, _LOGARITHM_NODES = 8, 48
_UNIFORM_MODES = 700


@dataclass(frozen=True, eq=False)
class RandomLift:
    """A map, its noise, how many waves a turn its detail has, and what kinds of break."""

    map: CircleMap
    noise: Noise
    waves: int
    kind: str


def random_lift(rng: np.random.Generator) -> RandomLift:
    """One to five thousand waves a turn on a sine map; one in two with a jump, a kink or both; one
    in five folds.
    """
    kind = str(rng.choice(["smooth", "jump", "kink", "jump and kink"], p=[0.5, 0.2, 0.2, 0.1]))
    uniform = rng.uniform() < 0.02
    waves = round(np.exp(rng.uniform(0.0, np.log(30 if uniform else MOST_WAVES))))
    steepness = rng.uniform(0.05, 0.65) if rng.uniform() < 0.8 else rng.uniform(1.0, 2.5)
    shift, slow, phase, other = (
        rng.uniform(0.0, TWO_PI),
        rng.uniform(0.0, 0.3),
        *rng.uniform(0.0, TWO_PI, 2),
    )
    ends = np.sort(rng.uniform(0.2, 6.1, 2))
    jump = rng.uniform(-1.0, 1.0) if "jump" in kind else 0.0
    bend = rng.uniform(-0.2, 0.2) if "kink" in kind else 0.0

    def lift(theta: np.ndarray) -> np.ndarray:
        turns = np.floor(theta / TWO_PI)
        base = theta - TWO_PI * turns
        detail = steepness / waves * np.sin(waves * base + phase) + slow * np.sin(base + other)
        inside = (base >= ends[0]) & (base < ends[1])
        middle = np.maximum(0.5 * (ends[1] - ends[0]) - np.abs(base - ends.mean()), 0.0)
        return theta + shift + detail + jump * inside + bend * middle

    def slope(theta: np.ndarray) -> np.ndarray:
        base = theta - TWO_PI * np.floor(theta / TWO_PI)
        detail = steepness * np.cos(waves * base + phase) + slow * np.cos(base + other)
        inside = (base >= ends[0]) & (base < ends[1])
        return 1.0 + detail + bend * inside * np.where(base < ends.mean(), 1.0, -1.0)

    breaks = ([*ends] if jump or bend else []) + ([ends.mean()] if bend else [])
    given = slope if rng.uniform() < 0.9 else None
    return RandomLift(CircleMap(lift, given, breaks), _noise(rng, uniform), waves, kind)


def _noise(rng: np.random.Generator, uniform: bool) -> Noise:
    if uniform:
        return UniformNoise(rng.uniform(0.5, 3.0))
    name, narrow = rng.choice(["normal", "von Mises", "Cauchy"]), rng.uniform() < 0.03
    if name == "normal":
        return WrappedNormal(
            rng.uniform(0.1, 0.35) if narrow else np.exp(rng.uniform(np.log(0.35), np.log(4.0)))
        )
    if name == "von Mises":
        return VonMises(
            rng.uniform(6.0, 60.0) if narrow else np.exp(rng.uniform(np.log(0.1), np.log(6.0)))
        )
    return WrappedCauchy(rng.uniform(0.3, 0.7) if narrow else rng.uniform(0.01, 0.3))


def noise_coefficients(noise: Noise, orders: np.ndarray) -> np.ndarray:
    """E cos mξ by its closed form, written here once more."""
    if isinstance(noise, WrappedNormal):
        return np.exp(-0.5 * (orders * noise.sigma) ** 2)
    if isinstance(noise, VonMises):
        return ive(orders, noise.kappa) / ive(0, noise.kappa)
    if isinstance(noise, WrappedCauchy):
        return noise.r**orders
    return np.sinc(orders * noise.halfwidth / np.pi)


@dataclass(frozen=True, eq=False)
class DenseNumbers:
    """Moments E e^{imθ}, m = 0, 1, ...; mean turns a cycle; what they may be off."""

    moments: np.ndarray
    rotation: float
    off: float

    def density(self, theta: np.ndarray) -> np.ndarray:
        """Per radian."""
        orders = np.arange(1, self.moments.size)
        waves = np.exp(-1j * np.multiply.outer(theta, orders)) @ self.moments[1:]
        return (1.0 + 2.0 * waves.real) / TWO_PI

    def mean(self, theta: np.ndarray, weight: np.ndarray, values: np.ndarray) -> float:
        """Of values at the nodes of a rule, under the stationary distribution."""
        density = [self.density(some) for some in np.array_split(theta, 1 + theta.size // 4_000)]
        return float(np.dot(np.concatenate(density) * weight, values)) * TWO_PI


def dense_numbers(case: RandomLift) -> DenseNumbers:
    """A Galerkin method in complex waves on Gauss nodes, twenty on every wave of the detail, cut at
    the breaks.

    Under uniform noise waves fall slowly: there all is off by what half as many modes change.
    """
    kappa = noise_coefficients(case.noise, np.arange(0.0, 3_000.0))
    uniform = isinstance(case.noise, UniformNoise)
    modes = _UNIFORM_MODES if uniform else int(np.argmax(np.abs(kappa) < 1e-18))
    theta, weight = _gauss_rule(case, max(case.waves, modes, 96), _NODES)
    turn = case.map(theta) - theta
    matrix = _galerkin(theta, turn, weight, modes)
    moments = _stationary(matrix, kappa[: modes + 1])
    fine = DenseNumbers(moments, np.nan, 0.0)
    rotation = fine.mean(theta, weight, turn) / TWO_PI
    if not uniform:
        return DenseNumbers(moments, rotation, 0.0)
    half = modes // 2
    inner = matrix[: half + 1, modes - half : modes + half + 1]
    rough = DenseNumbers(_stationary(inner, kappa[: half + 1]), np.nan, 0.0)
    by_rotation = abs(rotation - rough.mean(theta, weight, turn) / TWO_PI)
    off = max(by_rotation, *np.abs(moments - np.pad(rough.moments, (0, modes - half)))[:3])
    return DenseNumbers(moments, rotation, 2.0 * float(off))


def dense_exponent(case: RandomLift, dense: DenseNumbers) -> float:
    """E ln|F'|."""
    panels = _LOGARITHM_PANELS * max(case.waves, dense.moments.size - 1, 48)
    theta, weight = _gauss_rule(case, panels, _LOGARITHM_NODES)
    slope: Callable[[np.ndarray], np.ndarray] = case.map.derivative
    return dense.mean(theta, weight, np.log(np.abs(slope(theta))))


def _galerkin(theta: np.ndarray, turn: np.ndarray, weight: np.ndarray, modes: int) -> np.ndarray:
    """What the map makes of waves, before noise: rows m = 0..modes of E e^{imθ} after it, columns
    k = -modes..modes of the wave e^{-ikθ} with coefficient E e^{ikθ} before.
    """
    matrix = np.zeros((modes + 1, 2 * modes + 1), dtype=complex)
    for some in np.array_split(np.arange(theta.size), 1 + theta.size // 4_000):
        before = _powers(theta[some], modes)
        after = _powers(theta[some] + turn[some], modes)
        both = np.concatenate([before[:0:-1].conj(), before])
        matrix += after @ (both * weight[some]).conj().T
    return matrix


def _stationary(matrix: np.ndarray, kappa: np.ndarray) -> np.ndarray:
    """The moments that map and noise leave as they are; rows below 0 follow by symmetry."""
    modes = kappa.size - 1
    whole = np.concatenate([matrix[:0:-1, ::-1].conj(), matrix])
    both = np.concatenate([kappa[:0:-1], kappa])
    system = np.eye(2 * modes + 1) - both[:, None] * whole
    system[modes] = 0.0
    system[modes, modes] = 1.0
    return np.linalg.solve(system, np.eye(2 * modes + 1)[modes])[modes:]


def _gauss_rule(case: RandomLift, panels: int, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes on a turn, so many on every panel between breaks, and their weights in turns."""
    edges = np.union1d(np.linspace(0.0, TWO_PI, panels + 1), case.map.breaks)
    x, w = np.polynomial.legendre.leggauss(nodes)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (1.0 + x)).ravel(), (half * w).ravel() / TWO_PI


def _powers(theta: np.ndarray, most: int) -> np.ndarray:
    """e^{imθ}, m = 0..most, as rows."""
    return np.exp(1j * np.multiply.outer(np.arange(most + 1.0), theta))
