"""Response: how the law, the winding, the directions and the passages of a noisy family move with
its parameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, Mask, shorter_way
from cyclemap.checks import finite_array
from cyclemap.errors import InvalidInput
from cyclemap.maps.estimate import ANGLE, EPS, SAME_ANGLE, Estimate
from cyclemap.maps.families.family import (
    Family,
    ParameterTangent,
    Range,
    parameter_inside,
    parameter_range,
    parameter_tangent,
)
from cyclemap.maps.noise import Noise
from cyclemap.maps.operator.fourier_basis import FourierDiscretisation
from cyclemap.maps.operator.poisson_equation import FourierLaw, Function, checked_values
from cyclemap.maps.operator.transfer_operator import TransferOperator, transfer_operator
from cyclemap.maps.orbits.periodic_points import fixed_points
from cyclemap.maps.passages.killed_chain import Arc, Passage, killed_chain
from cyclemap.one_thread import one_thread

Rate = TypeVar("Rate", float, Array)
_STEP = 1e-3  # of the range: spacing of the differences by which ∂F/∂p is told
_STRETCH = 1.4  # factor on the nodes' bandwidth of the second route to a passage time's derivative


def response(family: Family, parameter: float, noise: Noise, parameters: Range) -> Response:
    """How what noise makes of a family's map answers its parameter: derivatives by the operator's
    adjoint.

    Parameters
    ----------
    family : callable
        p → CircleMap.
    parameter : float
        Where the derivatives are taken.
    noise : Noise
        With a smooth density.
    parameters : tuple[float, float]
        (low, high), with ``parameter`` inside: the family is called only there.

    Returns
    -------
    Response
        The derivatives, each computed when it is asked for.

    Raises
    ------
    InvalidInput
        For ``UniformNoise``, whose law has steps, and as ``transfer_operator`` does.
    ConvergenceError
        As ``transfer_operator`` does.

    Notes
    -----
    With z - Pz = h - E h (Poisson's equation) d/dp E h = E ∂F/∂p·(Pz)' + E ∂h/∂p, and where a jump
    b moves at the rate b', b' p(b) times what Pz and h change across it (linear response: Hairer &
    Majda 2010; with noise all is smooth). ∂F/∂p comes from centred differences over 1/1000 and
    1/500 of the range, extrapolated; the bounds add what that changes, what a finer basis or more
    nodes change, and rounding: measured. The maps' ``max_error`` counts through ∂F/∂p, to first
    order: over so short a step it is much, so that sampled maps should be good ones.

    References
    ----------
    Hairer, M. & Majda, A. J. (2010), A simple framework to justify linear response theory,
    Nonlinearity 23.

    Examples
    --------
    >>> from cyclemap.maps import CircleMap, WrappedNormal, response
    >>> found = response(CircleMap.rigid, 0.3, WrappedNormal(0.5), (0.0, 1.0))
    >>> found.rotation_number.holds(1.0), bool(abs(found.density(1.0)) < 1e-12)
    (True, True)
    """
    within = parameter_range("parameters", parameters)
    p = parameter_inside("parameter", parameter, within)
    near, far = (parameter_tangent(family, p, share, within) for share in (_STEP, 2.0 * _STEP))
    operator = transfer_operator(near.member, noise)
    return Response(operator, operator.law.smooth_basis, near, far)


@dataclass(frozen=True, eq=False)
class Response:
    """Derivatives by the parameter, made by ``response``; each is computed when it is asked for.

    Attributes
    ----------
    operator : TransferOperator
        At the parameter.
    basis : FourierDiscretisation
        Its basis.
    near, far : ParameterTangent
        ∂F/∂p by differences over a step and over two.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap.maps import CircleMap, WrappedNormal, response
    >>> turning = response(CircleMap.rigid, 0.3, WrappedNormal(0.5), (0.0, 1.0))
    >>> round(turning.rotation_number, 9), turning.expectation(np.cos).holds(0.0)
    (1.0, True)
    """

    operator: TransferOperator
    basis: FourierDiscretisation
    near: ParameterTangent
    far: ParameterTangent

    @one_thread
    def density(self, theta: ArrayLike) -> Array:
        """d/dp of the stationary density at ``theta``, any shape, per radian and unit of p."""
        angles = finite_array("theta", theta)
        moved, _ = self._moved(FourierLaw(self.basis), self.basis.evaluate(angles.ravel()))
        return moved.reshape(angles.shape)

    @one_thread
    def expectation(self, function: Function) -> Estimate:
        """d/dp of E h(θ) under the stationary law; h as of ``TransferOperator.expectation``."""
        return self._estimated(function, 0.0)

    @cached_property
    @one_thread
    def rotation_number(self) -> Estimate:
        """d/dp of the mean winding, turns a cycle."""
        return self._estimated(lambda at: self.operator.map.turn(at) / TWO_PI, 1.0 / TWO_PI)

    @cached_property
    def stable_points(self) -> tuple[tuple[float, Estimate], ...]:
        """(θ, dθ/dp) of the stable fixed points of the map without noise: ∂F/∂p over 1 - F'."""
        moving = []
        for orbit in fixed_points(self.operator.map):
            if orbit.stable:
                still = 1.0 - orbit.multiplier
                near, far = (float(push(orbit.points)[0]) / still for push in (self.near, self.far))
                rate, bound = _extrapolated(near, far)
                bound += (64.0 * EPS / self.near.step + self._unknown) / still
                moving.append((float(orbit.points[0]), Estimate(rate, bound)))
        return tuple(moving)

    @one_thread
    def mean_passage_time(self, start: float, arc: Arc, *, lifted: bool = False) -> Estimate:
        """d/dp of the mean cycles from ``start`` until the path is first outside ``arc``, both held
        fixed.

        Ṫ(x) = ∂F/∂p·∂/∂F ∫ g(y - F) T(y) dy + ∫ g(y - F(x)) Ṫ(y) dy, on the nodes of
        ``mean_passage_time``; and where a jump b inside the arc moves at the rate b', g(b - F(x))
        times b' and what T falls by across it. Raises InvalidInput where a jump that moves is at
        an end of the arc or at ``start``, since there is no derivative.
        """
        noise = self.basis.noise
        passage = Passage.out_of(self.operator.map, noise, arc, lifted)
        inside = passage.begun(start)
        places, moving = self._moving_jumps(passage, inside)
        rates = []
        for push, stretch in ((self.near, 1.0), (self.far, 1.0), (self.near, _STRETCH)):
            chain = killed_chain(passage, stretch=stretch)
            time = chain.expected(1.0, np.zeros(len(passage.exits)))
            theta = np.append(chain.theta, inside)
            images = self.operator.map(theta)
            growth = time.growth(images, chain)
            before, after = (
                time.values_at(limits(places))[1]
                for limits in (passage.map.left, passage.map.right)
            )
            crossing = noise.density(places - images[:, None], passage.lifted)
            source = push(theta) * growth + crossing @ (push.break_rates[moving] * (before - after))
            # Elimination keeps all digits of what is not negative.
            positive = np.maximum(np.stack([source, -source, np.abs(growth)], axis=1), 0.0)
            later, _, _ = chain.elimination.expected(positive[:-1])
            up, down, most = (positive[-1] + chain.transitions(images[-1:])[0] @ later).tolist()
            rates.append(up - down)
        near, far, again = rates
        rate, bound = _extrapolated(near, far)
        bound += 4.0 * abs(near - again) + most * self._unknown
        bound += 1e3 * EPS * (1.0 / self.near.step + abs(near))
        return Estimate(rate, bound)

    def _moving_jumps(self, passage: Passage, start: float) -> tuple[Array, Mask]:
        """Jumps inside the arc that move with the parameter, and which of the breaks they are."""
        breaks = passage.map.breaks
        jumps, _, _ = passage.map.jumps()
        ((low, high),) = passage.arcs
        places = low + np.mod(breaks - low, TWO_PI)
        speeds = np.abs(self.near.break_rates) + np.abs(self.far.break_rates)
        moving = np.isin(breaks, jumps) & (speeds > 0.0)
        # Slower ones are rounding.
        swift = moving & (speeds * self.near.step > ANGLE)
        for special in (low, high, start):
            beside = swift & (np.abs(shorter_way(breaks - special)) <= SAME_ANGLE)
            if np.any(beside):
                raise InvalidInput(
                    f"a jump that moves with the parameter is at {special:g}, an end of the arc or "
                    "the start, so that there is no derivative: take others"
                )
        moving &= places < high
        return places[moving], moving

    @property
    def _unknown(self) -> float:
        """What ∂F/∂p, extrapolated, may be off by the maps' ``max_error``."""
        return (4.0 * self.near.error + self.far.error) / 3.0

    def _estimated(self, function: Function, direct: float) -> Estimate:
        moved = []
        for basis in (self.basis, self.basis.refined()):
            theta, weight = basis.rule
            moments = basis.integrals(theta, weight * checked_values(function, theta))
            moved.append([float(each) for each in self._moved(FourierLaw(basis), moments, direct)])
        (value, changed), (again, _) = moved
        rounding = 64.0 * EPS * (1.0 + abs(value)) / self.near.step
        return Estimate(value, changed + 4.0 * abs(value - again) + rounding)

    def _moved(self, law: FourierLaw, moments: Array, direct: float = 0.0) -> tuple[Array, Array]:
        """d/dp E h for h of integrals ``moments`` (columns of several), and what the larger step
        and the maps' errors change.

        direct : ∂h/∂F where h depends on F.
        """
        basis = law.basis
        dual = law.dual(moments)
        slopes = (basis.expected_slope(dual).T + direct) * law.masses
        near, far = (slopes @ push(basis.rule[0]) for push in (self.near, self.far))
        jumps, left, right = basis.map.jumps()
        if jumps.size:
            later = (basis.kappa * dual.T).T
            sides = [basis.dual(image, later) for image in (left, right)]
            across = (sides[0] - sides[1]).T + direct * (left - right)
            fallen = across * law.density(jumps)
            which = np.isin(basis.map.breaks, jumps)
            near = near + fallen @ self.near.break_rates[which]
            far = far + fallen @ self.far.break_rates[which]
        rate, bound = _extrapolated(near, far)
        return rate, bound + self._unknown * np.sum(np.abs(slopes), axis=-1)


def _extrapolated(near: Rate, far: Rate) -> tuple[Rate, Rate]:
    """From centred differences over a step and over two: to no step, and what the larger one
    changes.
    """
    return (4.0 * near - far) / 3.0, abs(near - far)
