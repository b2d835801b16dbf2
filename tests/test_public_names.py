"""The package's public names."""

import subprocess
import sys

import pytest

import cyclemap as cm

# The names that users were promised.
PROMISED = (
    *("CollectionLoop", "CircleMap", "fixed_points", "periodic_orbits", "rotation_number", "rotation_interval"),
    *("lyapunov_exponent", "transfer_operator", "WrappedNormal", "WrappedCauchy", "CycleMapError"),
    *("VonMises", "UniformNoise", "Orbit", "periodic_points", "basins", "slow_passages", "compose", "inverse"),
    *(
        "saddle_nodes",
        "tongue",
        "rotation_numbers",
        "rotation_plane",
        "metastable_sets",
        "quasi_stationary_distribution",
    ),
    *("slip_probabilities", "passage_response", "sample_staircase", "DriftingMap", "find_steps", "compare_steps"),
)


def test_every_public_name_resolves():
    """Each name of __all__ leads to something, and every promised name is among them."""
    found = [name for name in cm.__all__ if getattr(cm, name) is not None]
    assert len(found) == len(cm.__all__) and set(PROMISED) <= set(found)


def test_unknown_name_is_an_attribute_error():
    """A name that does not exist fails as it does for any module."""
    with pytest.raises(AttributeError, match="no attribute 'CollectionLop'"):
        _ = cm.CollectionLop


def test_import_is_light():
    """Importing the package alone loads none of the heavy libraries."""
    heavy = "casadi", "scipy", "matplotlib"
    code = f"import sys, cyclemap; print([name for name in {heavy!r} if name in sys.modules])"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert printed.strip() == "[]"
