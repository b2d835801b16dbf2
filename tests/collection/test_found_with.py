"""What was identified with a surface's friction reaches the loop, in SI units, from a Material and
from a file.
"""

import math
import pickle
import tomllib
from dataclasses import asdict, replace

from refusals import refused

from cyclemap.collection import CollectionLoop
from cyclemap.errors import DataFileError
from cyclemap.mechanics import (
    EllipseFriction,
    FoundWith,
    Material,
    MaterialPosterior,
    PatchFootprint,
    PlatePressure,
    Slider,
    load_material,
    material_toml,
)
from cyclemap.protocol import loop_from_settings

LAW = EllipseFriction(0.3, 0.25)
SQUARE = Slider.mit("rect1").outline


def loop_with(**shares):
    return CollectionLoop.mit(
        Material("found", LAW, plates=(PlatePressure("rect1", **shares),) if shares else ())
    )


def test_shares_of_the_weight_reach_the_footprint_each_alone_and_together():
    """A material with nothing found leaves the loop as it is; what is asked for overrules what was
    found.
    """
    bare = loop_with()
    for found, wanted in (
        ({"rim_share": 0.3}, (0.0, 0.3, 0.0)),
        ({"inner_share": 0.1}, (0.1, 0.0, 0.0)),
        ({"corner_share": 0.2}, (0.0, 0.0, 0.2)),
        ({"rim_share": 0.2, "inner_share": 0.1, "corner_share": 0.15}, (0.1, 0.2, 0.15)),
    ):
        loop = loop_with(**found)
        assert loop.footprint == PatchFootprint(SQUARE, *wanted)
        assert (loop.slider, loop.pusher, loop.reset) == (bare.slider, bare.pusher, bare.reset)
        assert CollectionLoop.mit(loop.material, footprint=None).footprint is bare.footprint is None


def test_a_plate_presses_as_its_own_name_says_and_another_evenly():
    material = Material(
        "floor", LAW, plates=(PlatePressure("rect1", 0.1), PlatePressure("tri3", corner_share=0.4))
    )
    tri3 = Slider.mit("tri3")
    for loop in (
        CollectionLoop.mit(material, slider=tri3),
        loop_from_settings({"shape": "tri3"}, CollectionLoop.mit(material)),
        loop_from_settings({"shape": "tri3", "mu_a": 0.4}, CollectionLoop.mit(material)),
    ):
        assert loop.model.pressure == PatchFootprint(tri3.outline, corner_share=0.4)
    assert CollectionLoop.mit(material, slider=Slider.mit("hex")).footprint is None
    assert (
        loop_from_settings({"footprint": "exact"}, CollectionLoop.mit(material)).footprint is None
    )


def test_every_number_found_is_read_from_a_file_in_its_unit(tmp_path):
    path = tmp_path / "found.toml"
    path.write_text(
        "[friction]\nmu_a = 0.3\nmu_b = 0.3\n[found_with]\npusher_mu = 0.2\npin_friction_mm = 2\n"
        "[plates.rect1]\nrim_share = 0.25\ninner_share = 0.1\ncorner_share = 0.05\n"
    )
    assert asdict(load_material(path).found_with) == {
        "pusher_friction": 0.2,
        "pin_friction_radius": 0.002,
    }
    loop = CollectionLoop.mit(path)
    assert loop.model.pressure == PatchFootprint(SQUARE, 0.1, 0.25, 0.05)
    assert loop.reset.pin_friction_radius == 0.002


REFUSED = [
    ("[found_with]\nrim = 0.1", "unknown key of .found_with."),
    ("[found_with]\nrim_share = 0.1", r"plates.rect1"),
    ("[plates.rect1]\nrim_share = 0.6\ncorner_share = 0.5", "together be at most 1"),
    ("[plates.rect1]\nrim = 0.1", "rim_share"),
    ("[posterior]\nparameters = ['mu_q']\nsamples = [[1.0], [1.0]]", "did you mean"),
    ("[posterior]\nparameters = ['rim_share']\nsamples = [[1.0], [1.0]]", "rect1.rim_share"),
    (
        "[posterior]\nparameters = ['mu_a', 'mu_a']\nsamples = [[1.0, 1.0], [1.0, 1.0]]",
        "mu_a twice",
    ),
    (
        "[posterior]\nparameters = ['mu_a', 'mu_b']\nsamples = [[1.0, 1.0], [1.0]]",
        "sample 1 must hold 2",
    ),
    ("[posterior]\nparameters = ['mu_a']\nsamples = [[0.3]]", "has 1 samples"),
    ("[posterior]\nparameters = ['mu_a']\nsamples = [[0.3], [-0.3]]", "sample 1: .*mu_a"),
    (
        "[posterior]\nparameters = ['rect1.rim_share']\nsamples = [[0.3], [1.3]]\n[plates.rect1]",
        "sample 1: .*1.3",
    ),
    (
        "[posterior]\nparameters = ['worn.mu_a']\nsamples = [[0.3], [0.3]]",
        "only where the surface wears",
    ),
    ("[cycle_noise]\ncorrelation = 0.5", "needs log_sigma"),
    ("[cycle_noise]\nlog_sigma = [1.0, 2.0]", "2 numbers"),
    ("[cycle_noise]\nlog_sigma = [1.0]\ncorrelation = 1.0", "it must lie in"),
    ("[worn]\nmu_a = 0.3\nmu_b = 0.3\ncycles = 9\ncourse = [[5, 0.5], [3, 0.6]]", "course of wear"),
    ("[posterior]\nparameters = 3\nsamples = [[0.3], [0.3]]", "a list of names"),
]


def test_tables_that_carry_nothing_are_refused_in_one_line(tmp_path):
    path = tmp_path / "found.toml"
    for text, told in REFUSED:
        path.write_text(f"[friction]\nmu_a = 0.3\nmu_b = 0.3\n{text}\n")
        refused(load_material, path, told=told, kind=DataFileError)


def test_a_sample_of_the_posterior_is_a_material_in_si_units_and_leaves_what_it_does_not_name():
    names = (
        "mu_a",
        "phi_deg",
        "pusher_mu",
        "pin_friction_mm",
        "rect1.rim_share",
        "hex.inner_share",
    )
    posterior = MaterialPosterior(
        names, ((0.31, 90.0, 0.2, 1.5, 0.4, 0.3), (0.29, -90.0, 0.1, 0.0, 0.2, 0.1))
    )
    given = Material("floor", LAW, plates=(PlatePressure("rect1", 0.1, 0.3), PlatePressure("hex")))
    refused(replace, given, posterior=posterior, told="needs pusher_mu in")
    found = FoundWith(pusher_friction=0.1, pin_friction_radius=0.0)
    refused(
        replace,
        given,
        found_with=found,
        plates=given.plates[:1],
        posterior=posterior,
        told="needs a table",
    )
    given = replace(given, found_with=found, posterior=posterior)
    first = given.sample(0)
    assert first.friction == EllipseFriction(0.31, 0.25, phi=math.pi / 2.0)
    assert first.found_with == FoundWith(pusher_friction=0.2, pin_friction_radius=0.0015)
    assert first.plates == (PlatePressure("rect1", 0.1, 0.4), PlatePressure("hex", 0.3))
    assert first.posterior is None and given.sample(1).friction.mu_a == 0.29
    refused(given.sample, 2, told="no posterior sample 2")
    # What a file keeps of it comes back to the last bit, and so does a pickle.
    assert pickle.loads(pickle.dumps(given)) == given
    assert tomllib.loads(material_toml(given))["posterior"]["samples"] == [
        list(row) for row in posterior.samples
    ]
