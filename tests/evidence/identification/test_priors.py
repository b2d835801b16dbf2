"""Priors are rows in standard deviations: with nothing else, what was believed comes back with its own error."""

import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identification.priors import PRIOR_KIND, USUAL, prior_block
from cyclemap.evidence.identification.surface_parameters import SURFACE


def test_without_data_the_beliefs_and_their_deviations_come_back():
    of_surface = {name: belief for name, belief in USUAL.items() if name in SURFACE.names}
    found = identify([prior_block(of_surface)], list(of_surface), starts=1, noise={PRIOR_KIND: 1.0})
    assert len(found.estimates) == 9
    for one in found.estimates:
        value, deviation = USUAL[one.name]
        assert (one.value, one.standard_error) == pytest.approx((value, deviation), abs=1e-6 * deviation)


def test_no_belief_and_one_without_width_are_refused():
    with pytest.raises(InvalidInput, match="one parameter at least"):
        prior_block({})
    with pytest.raises(InvalidInput, match="rim_share"):
        prior_block({"rim_share": (0.5, 0.0)})
