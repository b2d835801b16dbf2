"""Small loops that the tests of robust resets share: short pushes, coarse grids."""

from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics import EllipseFriction, Material, SidePush, Wear
from cyclemap.resets.robust.material_score import QuickGrid

SHORT = SidePush(distance=0.06)  # a short push is a quick one
GRID = QuickGrid(samples=16, modes=16, nodes=4, allowed=0.5)
NOISE = WrappedNormal(0.2)  # much of it: few modes hold every law

LAW = EllipseFriction(0.27, 0.24, 0.02, 0.01, 0.6)
ROUGH = Material("rough", LAW)
EVEN = Material("even", EllipseFriction.isotropic(0.25))
WEARING = Material("wearing", LAW, wear=Wear(EllipseFriction(0.25, 0.22, -0.02, 0.0, 0.2), 40.0))


def short_loop(material: Material) -> CollectionLoop:
    """MIT's loop on a material with a short push."""
    return CollectionLoop.mit(material, push=SHORT)
