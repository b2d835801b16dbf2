"""What the caption of anisotropic-against-isotropic claims: batches draw together, isotropic paths
are one.
"""

import numpy as np
import pytest

from cyclemap.figures.cycles import experiment_caption

NAME = "anisotropic-against-isotropic"


@pytest.mark.slow
def test_anisotropic_batches_draw_together_and_isotropic_ones_keep_their_distance(result) -> None:
    unit = np.exp(1j * result.anisotropic.theta)
    # |mean of unit vectors| is 0 for evenly spread directions and 1 for equal ones.
    together = np.abs(unit.mean(axis=0))
    assert together[0] < 1e-9 and together[-1] > 0.3
    isotropic = np.abs(np.exp(1j * result.isotropic.theta).mean(axis=0))
    assert isotropic.max() < 1e-4


@pytest.mark.slow
def test_in_the_objects_frame_isotropic_paths_are_one_and_anisotropic_ones_spread(result) -> None:
    assert result.isotropic.spread < 5e-6
    assert result.anisotropic.spread > 0.01
    text = experiment_caption(result)
    assert "all 15 paths are one" in text and "the 15 paths spread by up to" in text
    assert "dynamic simulation at 20 mm/s; 15 cycles: 3 batches of 5" in text
