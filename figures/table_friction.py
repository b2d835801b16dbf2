"""Table I: the friction ellipses of the materials, with what follows from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cyclemap.collection import CollectionLoop
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence import friction_ellipse_from_scans
from cyclemap.mechanics import EllipseFriction, load_material
from cyclemap.views.sentences import angle, listed

from .catalogue import MeasuredFolder
from .measured_sets import measured_scans, not_found
from .simulated_collections import SIMULATED

HEADER = (
    "material",
    "source",
    "μa",
    "μb",
    "m0",
    "n0",
    "φ (°)",
    "mean √(μa μb)",
    "axis ratio",
    "offset (% of mean)",
    "offset towards (°)",
)


@dataclass(frozen=True)
class FrictionRow:
    """One limit ellipse.

    surface : the paper's name.
    material : the row's.
    source : where the numbers come from.
    """

    surface: str
    material: str
    source: str
    law: EllipseFriction

    @property
    def mean(self) -> float:
        """The geometric mean of the axes: the radius of the circle of the same area."""
        return math.sqrt(self.law.mu_a * self.law.mu_b)

    @property
    def axis_ratio(self) -> float:
        """The longer axis over the shorter."""
        return max(self.law.mu_a, self.law.mu_b) / min(self.law.mu_a, self.law.mu_b)

    @property
    def offset(self) -> float:
        """Distance of the ellipse's centre from zero, over the mean."""
        return math.hypot(self.law.m0, self.law.n0) / self.mean

    @property
    def offset_direction(self) -> float:
        """Direction of the centre in the frame of the surface, rad in [0, 2π)."""
        return (self.law.phi + math.atan2(self.law.n0, self.law.m0)) % (2 * math.pi)


@dataclass(frozen=True)
class FrictionEllipses:
    """The table.

    absent : materials without friction scans.
    unfitted : those whose scans fix no ellipse, and why.
    """

    rows: tuple[FrictionRow, ...]
    absent: tuple[str, ...]
    unfitted: tuple[tuple[str, str], ...]


def compute(measured: MeasuredFolder) -> FrictionEllipses:
    """Gather the materials' ellipses, and fit one to the friction scans of each where the folder
    has them.
    """
    weight = CollectionLoop.mit().model.weight
    rows: list[FrictionRow] = []
    absent, unfitted = [], []
    for surface, materials in SIMULATED.items():
        for name in materials:
            # The fresh surface and, where it wears, the worn one.
            material = load_material(name)
            wear, source = material.wear, "inferred from motion" if material.inferred else "paper"
            fresh = source if wear is None else f"{source}, fresh"
            rows.append(FrictionRow(surface, name, fresh, material.friction))
            if wear is not None:
                rows.append(
                    FrictionRow(
                        surface, name, f"{source}, after {wear.cycles:.0f} pushes", wear.friction
                    )
                )
        scans = measured_scans(measured, surface)
        if scans is None:
            absent.append(surface)
            continue
        try:
            law = friction_ellipse_from_scans(scans, weight)
        except (InvalidInput, ConvergenceError) as error:
            unfitted.append((surface, str(error)))
        else:
            rows.append(
                FrictionRow(surface, surface, f"{len(scans)} recorded scans", law.friction())
            )
    return FrictionEllipses(tuple(rows), tuple(absent), tuple(unfitted))


def rows(result: FrictionEllipses) -> list[tuple[str, ...]]:
    """A row an ellipse."""
    told = []
    for row in result.rows:
        law, direction = row.law, f"{math.degrees(row.offset_direction):.1f}"
        given = [f"{value:.4f}" for value in (law.mu_a, law.mu_b, law.m0, law.n0)]
        derived = [f"{row.mean:.4f}", f"{row.axis_ratio:.3f}", f"{100 * row.offset:.1f}", direction]
        told.append((row.material, row.source, *given, f"{math.degrees(law.phi):.2f}", *derived))
    return told


def caption(result: FrictionEllipses) -> str:
    """Where the rows come from, and what the paper's ellipse is like beside the others."""
    paper = next(row for row in result.rows if row.source == "paper")
    others = [row for row in result.rows if row.source.startswith("inferred")]
    ratios, offsets = [row.axis_ratio for row in others], [100 * row.offset for row in others]
    scanned = [row.surface for row in result.rows if row.source.endswith("recorded scans")]
    told = [
        f"Limit ellipses of point friction. The paper gives that of {paper.material} alone, with φ "
        f"= {paper.law.phi:.4f} rad: its axes differ by {100 * (paper.axis_ratio - 1):.1f} %, and "
        f"its centre lies {100 * paper.offset:.1f} % of the mean coefficient from zero, towards "
        f"{angle(paper.offset_direction, 0)}. The others are inferred from how objects "
        "moved, which does not tell the size of friction: their mean is 0.25 by convention. Their "
        f"axis ratios are {min(ratios):.2f} to {max(ratios):.2f}, their offsets {min(offsets):.1f} "
        f"to {max(offsets):.1f} % of the mean.",
        f"Ellipses are fitted to recorded friction scans on {listed(scanned)}." if scanned else "",
        *[
            f"The recorded friction scans on {name} fix no ellipse: {why}."
            for name, why in result.unfitted
        ],
        not_found("friction scans", result.absent),
    ]
    return " ".join(filter(None, told))
