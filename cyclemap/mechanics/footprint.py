"""Footprints: how the slider's weight is spread over its underside."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import finite_array, finite_number, point, whole_number
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.mechanics.area_quadrature import FAR_ORDER, WARPED_FAR_ORDER, area_quadrature
from cyclemap.mechanics.outline import Ellipse, Outline, Polygon
from cyclemap.mechanics.warp import Saddle, least_along, saddles
from cyclemap.text_files import read_csv_table, require_columns

# The outline scaled by this about its centroid is the inner edge of the frame that carries the rim's share.
RIM_INNER = 0.8
# Share of the mean pressure by which the pressure of the whole outline rises for each unit of the rim's share, while
# the inner region loses that of its own area.
RIM_RISE = RIM_INNER**2 / (1.0 - RIM_INNER**2)
# Rounding may leave a pressure that vanishes this much below zero.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class PatchFootprint:
    """Pressure over the whole area of an outline, exact, without a grid: even, leaning, more at the rim, or warped.

    With A the outline's area, w its rim share and (a, b) its warp, the pressure per unit load is

        p = (1 - w + (w + a q_a + b q_b) [outside the inner outline] / (1 - RIM_INNER^2) + gradient . x) / A,

    x = r - centroid, the inner outline being the outline scaled by RIM_INNER about its centroid. The saddles q_a and
    q_b are (x_1^2 - x_2^2)/R^2 and 2 x_1 x_2/R^2, R the outline's extent, less their projections on 1, x_1, x_2 over
    the frame, so that a warp changes neither load nor centre of pressure: an underside that is not quite flat rests
    more on one diagonal than on the other. A rigid object on even ground whose
    centre of mass is not its centroid leans just so that the centre of pressure lies under it (`under`); rim share and
    warp leave that centre where it is.

    Parameters
    ----------
    outline : what touches the ground.
    gradient : 1/m; the pressure must not be negative anywhere, with rim share and warp and without (InvalidInput).
    rim_share : share of the load on the frame alone, from -0.5625 (the frame carries nothing) to 1 (it carries all).
    warp : (a, b), numbers; on a square, b > 0 loads the corners (+, +) and (-, -) more, up to 0.36, a > 0 the sides
        that face along x, up to 0.72.

    >>> PatchFootprint(Ellipse(1.0, 1.0), rim_share=0.5).inner.semi_x
    0.8
    """

    outline: Outline
    gradient: tuple[float, float] = (0.0, 0.0)
    rim_share: float = 0.0
    warp: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "gradient", point("pressure gradient", self.gradient))
        share = finite_number("rim share", self.rim_share)
        object.__setattr__(self, "rim_share", share)
        if not -1.0 / RIM_RISE - _ROUNDING <= share <= 1.0:
            raise InvalidInput(f"rim share {share} leaves a pressure below zero: choose one from -0.5625 to 1")
        object.__setattr__(self, "warp", point("warp", self.warp))
        if (share != 0.0 or self.warp != (0.0, 0.0)) and not self.can_have_rim_share:
            raise InvalidInput(
                f"rim share {share}, warp {self.warp}: the outline scaled by {RIM_INNER} about its centroid does not "
                "lie inside this concave outline, so that it has no frame; leave both at 0 or give support points"
            )
        self._refuse_lifting()

    def _refuse_lifting(self) -> None:
        rim = self.outline.points(720) - self.outline.centroid
        lean = float((rim @ self.gradient).min())
        inside = 1.0 - self.rim_share + RIM_INNER * lean
        least = min(1.0 + lean, 1.0 + RIM_RISE * self.rim_share + lean, inside)
        if least >= -_ROUNDING and self.warp != (0.0, 0.0):
            least = min(least, self._least_on_frame(rim))
        if least < -_ROUNDING:
            raise InvalidInput(
                f"the pressure gradient {self.gradient} 1/m with rim share {self.rim_share} and warp {self.warp} lifts "
                f"the outline off the ground (least pressure {least:.3g} of the mean): bring the centre of mass nearer "
                "to the centroid, choose a smaller warp, or give support points"
            )

    def _least_on_frame(self, rim: NDArray[np.float64]) -> float:
        # A constant, a lean and saddles are harmonic, so that the frame's pressure is least on one of its edges.
        (a, b), (first, second) = np.array(self.warp) / (1.0 - RIM_INNER**2), self.saddles
        level = 1.0 + RIM_RISE * self.rim_share + a * first.constant + b * second.constant
        slope = np.array(self.gradient) + a * first.slope + b * second.slope
        pressure = Saddle(level, slope, a * first.bend + b * second.bend)
        return min(least_along(rim, pressure), least_along(RIM_INNER * rim, pressure))

    @classmethod
    def under(
        cls,
        outline: Outline,
        centre_of_mass: tuple[float, float],
        rim_share: float = 0.0,
        warp: tuple[float, float] = (0.0, 0.0),
    ) -> "PatchFootprint":
        """Return the footprint whose centre of pressure is the given centre of mass (m)."""
        lever = np.subtract(centre_of_mass, outline.centroid)
        if np.hypot(*lever) <= 1e-12 * outline.extent:
            return cls(outline, rim_share=rim_share, warp=warp)
        gx, gy = np.linalg.solve(cls(outline).second_moments, lever)
        return cls(outline, (float(gx), float(gy)), rim_share, warp)

    @cached_property
    def inner(self) -> Outline:
        """The inner edge of the frame."""
        return self.outline.shrunk(RIM_INNER)

    @cached_property
    def can_have_rim_share(self) -> bool:
        """Whether it has a frame, whose inner edge lies inside the outline: always, if that is convex."""
        if isinstance(self.outline, Ellipse) or self.outline.is_convex:
            return True
        assert isinstance(self.inner, Polygon)
        return self.outline.encloses(self.inner)

    @cached_property
    def saddles(self) -> tuple[Saddle, Saddle]:
        """The saddles q_a and q_b of the lever from the centroid."""
        return saddles(self.outline, self.inner)

    @cached_property
    def second_moments(self) -> NDArray[np.float64]:
        """Mean of (r - centroid)(r - centroid)^T over the area, (2, 2), m^2."""
        points, weights = area_quadrature(self.outline)
        lever = points - self.outline.centroid
        return np.asarray(np.einsum("k,ki,kj->ij", weights, lever, lever))

    @cached_property
    def centre(self) -> tuple[float, float]:
        """Centre of pressure, m."""
        x, y = self.outline.centroid + self.second_moments @ self.gradient
        return float(x), float(y)

    @property
    def extent(self) -> float:
        """Largest distance of the outline from its centroid, m."""
        return self.outline.extent

    @cached_property
    def quadrature(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points (k, 2), m, and shares of the load (k,), exact for polynomials up to degree 10 on either region."""
        if self.warp != (0.0, 0.0):
            points, without, by_share, by_warp = self.warp_quadrature
            return points, without + self.rim_share * by_share + by_warp @ self.warp
        if self.rim_share == 0.0:
            points, weights = area_quadrature(self.outline)
            return points, weights * self._leaning(points)
        points, without, by_share = self.rim_quadrature
        return points, without + self.rim_share * by_share

    @cached_property
    def rim_quadrature(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Points (k, 2), m, their shares of the load (k,) at rim share zero, and the derivatives of these by it."""
        points, whole, inner = self._regions(FAR_ORDER)
        return points, whole * self._leaning(points), RIM_RISE * (whole - inner)

    @cached_property
    def warp_quadrature(self) -> tuple[NDArray[np.float64], ...]:
        """Points (k, 2), m, shares of the load (k,) at rim share and warp zero, derivatives (k,) and (k, 2) by both."""
        points, whole, inner = self._regions(WARPED_FAR_ORDER)
        frame = (whole - RIM_INNER**2 * inner) / (1.0 - RIM_INNER**2)
        lever = points - self.outline.centroid
        saddle = np.stack([mode.at(lever) for mode in self.saddles], axis=-1)
        return points, whole * self._leaning(points), RIM_RISE * (whole - inner), frame[:, None] * saddle

    def _regions(self, order: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Points (k, 2), and their weights (k,) in the means over the whole outline and over the inner one."""
        points, weights = area_quadrature(self.outline, order)
        inside, inner = area_quadrature(self.inner, order)
        whole, within = np.concatenate([weights, 0.0 * inner]), np.concatenate([0.0 * weights, inner])
        return np.concatenate([points, inside]), whole, within

    def _leaning(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(1.0 + (points - self.outline.centroid) @ np.array(self.gradient))


@dataclass(frozen=True)
class PointFootprint:
    """Weight carried by points: positions (k, 2), m, and their shares of the load, positive, scaled to sum one.

    >>> PointFootprint(((0.0, 0.0), (2.0, 0.0)), (1.0, 3.0)).centre
    (1.5, 0.0)
    """

    positions: tuple[tuple[float, float], ...]
    weights: tuple[float, ...]

    def __post_init__(self) -> None:
        positions = finite_array("support points", self.positions, last=2)
        weights = finite_array("support weights", self.weights)
        if positions.ndim != 2 or weights.shape != positions.shape[:1]:
            raise InvalidInput(
                f"support points (k, 2) and weights (k,) do not match: {positions.shape}, {weights.shape}"
            )
        if np.any(weights < 0.0) or not weights.sum() > 0.0:
            raise InvalidInput(f"support weights must not be negative and not all zero: the least is {weights.min()}")
        loaded = weights > 0.0
        positions, weights = positions[loaded], weights[loaded]
        if np.ptp(positions, axis=0).max() == 0.0:
            raise InvalidInput("a footprint needs two support points apart: one point alone resists no turning")
        object.__setattr__(self, "positions", tuple(map(tuple, positions.tolist())))
        object.__setattr__(self, "weights", tuple((weights / weights.sum()).tolist()))

    @cached_property
    def quadrature(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points (k, 2), m, and weights (k,) that sum to one."""
        return np.array(self.positions), np.array(self.weights)

    @cached_property
    def centre(self) -> tuple[float, float]:
        """Centre of pressure, m."""
        points, weights = self.quadrature
        x, y = weights @ points
        return float(x), float(y)

    @cached_property
    def extent(self) -> float:
        """Largest distance of loaded points from the centre of pressure, m."""
        return float(np.hypot(*(self.quadrature[0] - self.centre).T).max())


Footprint = PatchFootprint | PointFootprint


def grid_footprint(outline: Outline, count: int) -> PointFootprint:
    """Return the paper's footprint: the centres of `count` x `count` cells of the bounding box, where inside, alike.

    Ma & Rodriguez (2018) use count = 8.

    >>> len(grid_footprint(Ellipse(1.0, 1.0), 4).positions)
    12
    """
    count = whole_number("points a side of a grid footprint", count, least=2)
    corners = outline.points(4)
    low, high = corners.min(axis=0), corners.max(axis=0)
    share = (np.arange(count) + 0.5) / count
    x, y = np.meshgrid(low[0] + share * (high[0] - low[0]), low[1] + share * (high[1] - low[1]), indexing="ij")
    cells = np.stack([x.ravel(), y.ravel()], axis=-1)
    inside = cells[outline.contains(cells)]
    if len(inside) < 2:
        raise InvalidInput(f"a {count} x {count} grid has {len(inside)} points inside the outline: make it finer")
    return PointFootprint(tuple(map(tuple, inside.tolist())), (1.0,) * len(inside))


def corner_footprint(outline: Polygon) -> PointFootprint:
    """Return the footprint of an object that stands on its corners, the same load on each."""
    return PointFootprint(outline.vertices, (1.0,) * outline.sides)


def load_footprint(path: str | Path) -> PointFootprint:
    """Read support points from a CSV file with the columns x_mm, y_mm, weight (object frame).

    Raises DataFileError, naming file and line, for a missing file or column, or a row that is not three numbers.
    """
    table = read_csv_table(path)
    columns = ("x_mm", "y_mm", "weight")
    require_columns(table, columns)
    x_mm, y_mm, weight = np.array([[table.number(row, name) for name in columns] for row in table.rows]).T
    try:
        return PointFootprint(tuple(zip(x_mm * 1e-3, y_mm * 1e-3, strict=True)), tuple(weight))
    except InvalidInput as cause:
        raise DataFileError(f"{path}: {cause}") from cause


def parse_footprint(text: str, outline: Outline) -> Footprint:
    """Return the footprint that a word names: `exact`, `grid:N`, `corners`, or the path of a CSV file.

    >>> parse_footprint("corners", Polygon(((0, 0), (1, 0), (1, 1)))).positions[2]
    (1.0, 1.0)
    """
    if text == "exact":
        return PatchFootprint(outline)
    if text == "corners" and isinstance(outline, Polygon):
        return corner_footprint(outline)
    if text.startswith("grid:") and text[5:].isdecimal():
        return grid_footprint(outline, int(text[5:]))
    if text.endswith(".csv"):
        return load_footprint(text)
    raise InvalidInput(f"footprint {text!r} is none of: exact, grid:N, corners (polygons), FILE.csv")
