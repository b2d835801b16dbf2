"""What `probe` says of engines: MuJoCo's pyramidal cone pushes by direction, its elliptic one and
Drake alike.
"""

from collections.abc import Callable

import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import Probe, probe, simulated_push
from cyclemap.mechanics import Pose, SidePush, corner_footprint
from tests.benchmarks.peers.push_problem import four_corners

PUSHES = 24
# What the engines' own steps leave in a push of 74 degrees and 80 mm.
ALIKE_DEG, ALIKE_MM = 0.3, 0.3


def probed(end_pose: Callable[[Pose, SidePush], Pose]) -> Probe:
    """The engine's pushes of MIT's square on its four corners, from all around."""
    loop = CollectionLoop.mit("isotropic", accuracy=1e-6)
    loop = CollectionLoop(
        loop.slider, loop.material, footprint=corner_footprint(loop.slider.outline), accuracy=1e-6
    )

    def ended(
        theta: float, start: tuple[float, float], end: tuple[float, float]
    ) -> tuple[float, float, float]:
        found = end_pose(Pose(0.0, 0.0, theta), SidePush())
        return found.x, found.y, found.theta

    return probe(simulated_push(loop, ended), loop, PUSHES)


def largest(found: Probe) -> tuple[float, float]:
    """The largest harmonic of the turn (degrees) and of the place (mm)."""
    turn = max(one.amplitude for one in found.harmonics if one.outcome == "dtheta")
    place = max(one.amplitude for one in found.harmonics if one.outcome != "dtheta")
    return 57.29578 * turn, 1e3 * place


def mujoco_push(cone: str) -> Callable[[Pose, SidePush], Pose]:
    pytest.importorskip("mujoco")
    from tests.benchmarks.peers.mujoco_push import MujocoPush

    return MujocoPush(four_corners(), cone=cone).end_pose


def test_the_pyramidal_cone_depends_on_direction_with_a_fourth_harmonic() -> None:
    found = probed(mujoco_push("pyramidal"))
    assert found.found
    assert largest(found)[0] > 5.0
    strongest = max(
        (one for one in found.harmonics if one.outcome == "dtheta"), key=lambda one: one.amplitude
    )
    assert strongest.order == 4


def test_the_elliptic_cone_pushes_alike() -> None:
    turn, place = largest(probed(mujoco_push("elliptic")))
    assert turn < ALIKE_DEG and place < ALIKE_MM


def test_drake_pushes_alike() -> None:
    pytest.importorskip("pydrake")
    from tests.benchmarks.peers.drake_push import drake_push

    turn, place = largest(probed(drake_push(four_corners())))
    assert turn < ALIKE_DEG and place < ALIKE_MM
