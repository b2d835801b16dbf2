"""What scores are asked with, checked where it is given."""

from __future__ import annotations

from typing import Any

from cyclemap.checks import finite_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise, UniformNoise


def check_score_options(scores: Any, **least: int) -> None:
    """Raise InvalidInput where `tv` is no total variation, or a count of `scores` is below its `least`; None passes.

    >>> from types import SimpleNamespace
    >>> check_score_options(SimpleNamespace(tv=0.05, pushes=50, starts=None), pushes=1, starts=8)
    """
    if not 0.0 < finite_number("tv", scores.tv) < 1.0:
        raise InvalidInput(f"tv is {scores.tv:g}: a total variation lies between 0 and 1")
    for name, fewest in least.items():
        if getattr(scores, name) is not None:
            whole_number(name, getattr(scores, name), least=fewest)


def checked_score_noise(noise: Noise) -> Noise:
    """Return the noise of a cycle, or raise InvalidInput where it is none or damps no Fourier modes.

    >>> from cyclemap.maps import WrappedNormal
    >>> checked_score_noise(WrappedNormal(0.02)).sigma
    0.02
    """
    if not isinstance(noise, Noise):
        raise InvalidInput(f"the noise is {noise!r}: scores need some, for example WrappedNormal(0.02)")
    if isinstance(noise, UniformNoise):
        raise InvalidInput(
            f"the noise is {noise!r}, which damps no Fourier modes: add a narrow smooth noise, "
            "IndependentSum((WrappedNormal(0.01), UniformNoise(...)))"
        )
    return noise
