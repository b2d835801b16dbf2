"""Footprints that one set of compiled equations serves: those that differ by their rim share alone."""

from dataclasses import dataclass, replace

from cyclemap.mechanics.footprint import Footprint, PatchFootprint


@dataclass(frozen=True)
class PressureFamily:
    """A footprint without its rim share, which is a number that the equations take.

    `framed`: whether the equations hold the rim's term at all; without it they are half as long.
    """

    footprint: Footprint
    framed: bool = False

    @classmethod
    def of(cls, footprint: Footprint) -> "PressureFamily":
        """Return the family of a footprint, framed only where its rim share is not zero."""
        if rim_share(footprint) == 0.0:
            return cls(footprint)
        assert isinstance(footprint, PatchFootprint)
        return cls(replace(footprint, rim_share=0.0), framed=True)


def rim_share(footprint: Footprint) -> float:
    """Return the rim share of a footprint; support points have none."""
    return footprint.rim_share if isinstance(footprint, PatchFootprint) else 0.0


def can_have_rim_share(footprint: Footprint) -> bool:
    """Whether a footprint can be given a rim share."""
    return isinstance(footprint, PatchFootprint) and footprint.can_have_rim_share
