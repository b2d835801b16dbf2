"""Priors are rows in standard deviations: with nothing else, what was believed comes back with its own error."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import PRIOR_KIND, USUAL, FunctionBlock, prior_block
from cyclemap.evidence.identification.identify import identify
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


def test_a_belief_alone_keeps_its_deviation_beside_data_that_share_groups():
    """What the data do not depend on has the interval of its belief, however near to it the estimate lies."""
    rows = np.arange(40) // 2
    data = 0.2 + 0.01 * np.cos(7.0 * np.arange(40))
    law = FunctionBlock(
        "law", ("pusher_friction", "rim_share"), lambda v: (v["pusher_friction"] - data, np.eye(2)[[0] * 40]), rows, "m"
    )
    beliefs = {"rim_share": (0.4, 0.1), "pusher_friction": (0.15, 0.05)}
    found = identify([law], list(beliefs), priors=beliefs, starts=1)
    assert found["rim_share"].value == pytest.approx(0.4, abs=1e-6)
    assert found["rim_share"].standard_error == pytest.approx(0.1, rel=1e-6)
    assert found["rim_share"].upper == pytest.approx(0.4 + 1.96 * 0.1, abs=1e-3)
    assert found["pusher_friction"].standard_error < 0.01
