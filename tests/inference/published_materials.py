"""Infer abs, delrin and pu from published statistics: `python -m tests.inference.published_materials [MATERIAL ...]`.

Prints where the searches ended, the best fit, the text of the material's file, and the table of published and predicted
numbers. Takes some minutes a material.
"""

import json
import math
import os
import sys
from dataclasses import dataclass, fields, replace

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.evidence.data_blocks.cycle_pair_block import found_with
from cyclemap.evidence.identification.identifiability import Uncertainty, uncertainty
from cyclemap.evidence.identification.joint_problem import JointProblem
from cyclemap.evidence.identification.least_squares import NO_ANSWER, Fit, minimise
from cyclemap.evidence.identification.noise_scales import NoiseLaw
from cyclemap.evidence.identification.priors import PRIOR_KIND, USUAL, prior_block
from cyclemap.evidence.identification.surface_parameters import SURFACE, SurfaceParameters
from cyclemap.evidence.published.cycle_nodes import NODES
from cyclemap.evidence.published.published_comparison import comparison_table, published_comparison
from cyclemap.evidence.published.published_statistics import SOURCE, published_statistics
from cyclemap.evidence.published.statistics_block import TOLERANCES, statistics_block
from cyclemap.mechanics import EllipseFriction, FoundWith, Material

MATERIALS = ("abs", "delrin", "pu")
STARTS = 8
# Few nodes do while searching; the misfit in the file is told with the full number.
SEARCH_NODES, ROUGH_TOLERANCE, ROUGH_STEPS = 31, 5e-4, 25
FINE_TOLERANCE, FINE_STEPS = 1e-5, 200
# The ring's lever may be longer or shorter than nominal, but not turned: that acts much alike.
HELD = {"hitch_turn": 0.0}
# Where no direction is published, turning the surface changes no statistic: its longer axis is laid along x.
UNTURNED = {"ellipticity_y": 0.0}
NOISE = {**TOLERANCES, PRIOR_KIND: 1.0}
DIGITS = 5
KEYS = {"pusher_mu": "pusher_friction", "rim_share": "rim_share", "hitch_scale": "hitch_scale"}
LENGTHS = ("pin_friction_radius",)
UNTOLD = "No direction is published, so neither can the surface's orientation: its longer axis lies along x. "
# A parameter whose error is nearly that of its prior was not told by the data.
TOLD = 0.8


@dataclass(frozen=True, eq=False)
class Inferred:
    """The best fit of several searches, and the errors of its parameters to first order."""

    problem: JointProblem
    fit: Fit
    errors: Uncertainty

    @property
    def surface(self) -> SurfaceParameters:
        return SurfaceParameters.from_values(self.problem.values(self.fit.vector))

    @property
    def intervals(self) -> list[str]:
        """Each parameter, value +- 1.96 standard errors; the priors bound what the data leave open."""
        parts = zip(self.problem.space.names, self.fit.vector, self.errors.standard_error, strict=True)
        return [f"{name} {value:.3g} +- {1.96 * error:.2g}" for name, value, error in parts]

    @property
    def told(self) -> dict[str, float]:
        """Standard error of each parameter over that of its prior: near 1 where the data say nothing."""
        names, errors = self.problem.space.names, self.errors.standard_error.tolist()
        return {name: error / USUAL[name][1] for name, error in zip(names, errors, strict=True)}


def inferred(material: str, begins: list[np.ndarray] | None = None) -> Inferred:
    """Infer a surface from what is published of it and weak priors.

    Rough searches with few nodes; their ends are refined with the full number, and the best is taken.
    """
    problem = posed(material, NODES)
    noise, law = np.array([NOISE[kind] for kind in problem.kind_names]), NoiseLaw()
    ends = rough_ends(material, STARTS) if begins is None else begins
    tried = [minimise(problem, end, noise, law, FINE_TOLERANCE, FINE_STEPS) for end in ends]
    for one in tried:
        print(f"{material}: {missed(problem, one):.1f} at {one.vector.round(4).tolist()}", flush=True)
    fit = min(tried, key=lambda one: one.deviance)
    return Inferred(problem, fit, uncertainty(problem, fit))


def missed(problem: JointProblem, fit: Fit) -> float:
    """Sum of squares of the residuals over their tolerances, priors included."""
    return float(np.sum((fit.residuals / fit.noise[problem.kind_index]) ** 2))


def posed(material: str, nodes: int) -> JointProblem:
    """Published numbers and priors, and what is free and what is held for them."""
    published = published_statistics(material)
    held = HELD if published.directions else HELD | UNTURNED
    beliefs = {name: belief for name, belief in USUAL.items() if name not in held}
    block = statistics_block(published, CollectionLoop.mit(), nodes=nodes)
    return JointProblem((block, prior_block(beliefs)), SURFACE.select(tuple(beliefs)), held)


def rough_ends(material: str, starts: int, seed: int = 0) -> list[np.ndarray]:
    """Where searches from within the priors' deviations end; those without an answer are left out."""
    problem = posed(material, SEARCH_NODES)
    names, noise = problem.space.names, np.array([NOISE[kind] for kind in problem.kind_names])
    centre, width = np.array([USUAL[name] for name in names]).T
    rng, found = np.random.default_rng(seed), []
    for _ in range(starts):
        drawn = centre + 0.8 * width * rng.uniform(-1.0, 1.0, centre.size)
        begin = np.array([inside(name, at) for name, at in zip(names, drawn, strict=True)])
        try:
            found.append(minimise(problem, begin, noise, NoiseLaw(), ROUGH_TOLERANCE, ROUGH_STEPS).vector)
        except NO_ANSWER as cause:
            print(f"{material}: a search had no answer: {cause}", file=sys.stderr, flush=True)
    return found


def inside(name: str, value: float) -> float:
    """The value, or one just inside the parameter's bounds."""
    margin = 1e-3 * USUAL[name][1]
    return float(np.clip(value, SURFACE[name].lower + margin, SURFACE[name].upper - margin))


def inferred_material(name: str, found: Inferred) -> Material:
    """The material as its file holds it: rounded, with provenance, and the misfit of the rounded numbers."""
    material = Material(name, rounded_friction(found.surface.to_friction()), provenance(found), inferred=True)
    material = replace(material, found_with=rounded_found_with(found_with(found.surface)))
    return replace(material, misfit=published_comparison(material).sentence)


def provenance(found: Inferred) -> str:
    """From what the numbers were inferred, with their intervals, and which of them are hardly more than the prior."""
    untold = [name for name, share in found.told.items() if share > TOLD]
    beliefs = ", ".join(f"{name} {at:g} +- {by:g}" for name, (at, by) in USUAL.items() if name in found.told)
    text = (
        f"inferred from {SOURCE}: means and standard deviations of 2000 equal pushes and where the object lingers, "
        f"no forces and no single motions; with weak priors on how anisotropic floors are and on rod, rim and ring "
        f"({beliefs}). The friction scale cannot be told from motion: mean coefficient 0.25 by convention. "
        f"{'' if 'ellipticity_y' in found.told else UNTOLD}"
        f"Rough 95 % intervals about this optimum, priors included: {'; '.join(found.intervals)}; other optima may be "
        "nearly as good."
    )
    if not found.fit.converged:
        text += " The search was stopped a little short of the optimum."
    return text + (f" Hardly more than the prior: {', '.join(untold)}." if untold else "")


def rounded_friction(friction: EllipseFriction) -> EllipseFriction:
    numbers = [round(getattr(friction, name), DIGITS) for name in ("mu_a", "mu_b", "m0", "n0")]
    return EllipseFriction(*numbers, math.radians(round(math.degrees(friction.phi), 2)))


def rounded_found_with(found: FoundWith) -> FoundWith:
    numbers = {field.name: getattr(found, field.name) for field in fields(found)}
    return FoundWith(**{name: round(value, 6 if name in LENGTHS else 4) for name, value in numbers.items() if value})


def material_text(material: Material) -> str:
    """The TOML text of a material file."""
    friction, found = material.friction, material.found_with
    lines = [f"name = {json.dumps(material.name)}", f"provenance = {json.dumps(material.provenance)}"]
    lines += [
        f"misfit = {json.dumps(material.misfit)}",
        f"inferred = {json.dumps(material.inferred)}",
        "",
        "[friction]",
    ]
    lines += [f"{name} = {getattr(friction, name):g}" for name in ("mu_a", "mu_b", "m0", "n0")]
    lines += [f"phi_deg = {math.degrees(friction.phi):.2f}", "", "[found_with]"]
    lines += [f"{key} = {getattr(found, name):g}" for key, name in KEYS.items() if getattr(found, name) is not None]
    if found.pin_friction_radius is not None:
        lines.append(f"pin_friction_mm = {1e3 * found.pin_friction_radius:.3f}")
    return "\n".join(lines) + "\n"


def report(name: str, begins: list[np.ndarray] | None = None) -> Material:
    found = inferred(name, begins)
    print(f"== {name}: {missed(found.problem, found.fit):.1f} squared tolerances missed; {found.fit.message}")
    for text, share in zip(found.intervals, found.told.values(), strict=True):
        print(f"  {text}; error {share:.2f} of the prior's")
    material = inferred_material(name, found)
    print(material_text(material), flush=True)
    return material


if __name__ == "__main__":
    wanted = sys.argv[1:] or MATERIALS
    unknown = set(wanted) - set(MATERIALS)
    if unknown:
        sys.exit(f"unknown material {', '.join(sorted(unknown))}; known: {', '.join(MATERIALS)}")
    materials = [report(name) for name in wanted]
    print(comparison_table(published_comparison(material) for material in ["plywood", *materials]))
