"""A robust reset among the others: scored on the nominal material like them, and put first."""

from __future__ import annotations

from dataclasses import replace

from cyclemap.errors import CycleMapError
from cyclemap.resets.design.reset_candidates import ResetCandidate
from cyclemap.resets.design.reset_design import ResetDesign
from cyclemap.resets.design.reset_survey import Progress, ResetSurvey
from cyclemap.resets.robust.robust_reset import RobustReset
from cyclemap.resets.robust.worst_case import Allowance

NAME = "drawn pushes, robust"


def allowance_of(design: ResetDesign) -> Allowance:
    """Return what a design's demands allow on every material."""
    wanted = design.demands
    return Allowance(wanted.allow_tv, wanted.extra_tv, wanted.within, wanted.drag_ratio)


def robust_first(design: ResetDesign, robust: RobustReset, progress: Progress | None = None) -> ResetDesign:
    """Return the design with the robust strategy as the first of its ranking, and as the one that is chosen.

    Its scores are those on the nominal material, with error bounds where it meets the demands there. Raises
    CycleMapError where its cycles lead out of the mechanics.
    """
    survey = ResetSurvey(design.cache, design.demands, False, progress or (lambda stage, done: None))
    survey.look([ResetCandidate(NAME, robust.strategy)], "scoring the robust pushes")
    if survey.left_out:
        raise CycleMapError(f"{NAME}: {survey.left_out[0].reason}")
    survey.confirm(1)
    scored = survey.scored[NAME]
    return replace(design, ranking=(scored, *design.ranking), chosen=scored)
