"""Footprints that one set of compiled equations serves: those that differ by rim share and warp alone."""

from dataclasses import dataclass, replace

from cyclemap.mechanics.footprint import Footprint, PatchFootprint


@dataclass(frozen=True)
class PressureFamily:
    """A footprint without its rim share and warp, which are numbers that the equations take.

    `framed`, `warped`: whether the equations hold the terms of rim share and warp at all; without the former they are
    half as long, without the latter half of that again. What is warped is framed, too.
    """

    footprint: Footprint
    framed: bool = False
    warped: bool = False

    @classmethod
    def of(cls, footprint: Footprint) -> "PressureFamily":
        """Return the family of a footprint, framed or warped only where its rim share or its warp is not zero."""
        share, warped = rim_share(footprint), warp(footprint) != (0.0, 0.0)
        if share == 0.0 and not warped:
            return cls(footprint)
        assert isinstance(footprint, PatchFootprint)
        return cls(replace(footprint, rim_share=0.0, warp=(0.0, 0.0)), framed=True, warped=warped)


def rim_share(footprint: Footprint) -> float:
    """Return the rim share of a footprint; support points have none."""
    return footprint.rim_share if isinstance(footprint, PatchFootprint) else 0.0


def warp(footprint: Footprint) -> tuple[float, float]:
    """Return the warp of a footprint; support points have none."""
    return footprint.warp if isinstance(footprint, PatchFootprint) else (0.0, 0.0)


def has_frame(footprint: Footprint) -> bool:
    """Whether a footprint can be given a rim share and a warp."""
    return isinstance(footprint, PatchFootprint) and footprint.can_have_rim_share
