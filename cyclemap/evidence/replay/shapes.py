"""The objects of the MIT push dataset that can be replayed, by name: the shapes of the model, and `butter`."""

from __future__ import annotations

import numpy as np

from cyclemap.mechanics import Slider
from cyclemap.mechanics.outline import Polygon
from cyclemap.mechanics.slider import MIT_SHAPE_NAMES

# A quarter of the butterfly's outline, mm from its centre: from the middle of the waist to the end of the wing. The
# plate is symmetric about both axes. Nodes of the outline in the dataset's code (peterkty/pnpush, shape_db.py, "butt",
# and its CAD points), whose spline the mesh in mcubelab/pdproc (butter.obj) follows within 0.01 mm.
_QUARTER = (
    (27.3790177, 0.0),
    (28.021517, 4.9769114),
    (29.7530391, 9.9489481),
    (32.2795708, 14.9115157),
    (35.3071749, 19.8595996),
    (38.5418302, 24.7884652),
    (41.6895866, 29.6933079),
    (44.4564538, 34.5692232),
    (46.5484518, 39.4117064),
    (47.6716003, 44.215653),
    (47.5723138, 48.9696983),
    (46.2633978, 53.6184558),
    (43.8655401, 58.0887518),
    (40.4997342, 62.3073622),
    (36.2869737, 66.2010628),
    (31.3482126, 69.6966295),
    (25.8045628, 72.7208383),
    (19.7768994, 75.2004648),
    (13.3862555, 77.0622851),
    (6.7536245, 78.233075),
    (0.0, 78.6396103),
)

# Of the dataset's rect1, cut from the same plate: 0.8374 kg on 90 mm by 90 mm; the butterfly's own mass is not given
# there. It scales the forces alone, never the motion.
_PLATE_DENSITY = 0.8374 / 0.0081
_BUTTER_INERTIA = 0.003019


def butter_outline() -> Polygon:
    """Return the outline of the dataset's butterfly, m: 80 vertices counter-clockwise from its end at -y.

    >>> outline = butter_outline()
    >>> outline.sides, outline.is_convex, round(1e6 * outline.area)
    (80, False, 11667)
    """
    quarter = np.array(_QUARTER) * 1e-3
    right = np.vstack([quarter[::-1] * (1.0, -1.0), quarter[1:]])
    left = -right[1:-1]
    return Polygon(tuple(map(tuple, np.vstack([right, left]).tolist())))


def butter_slider() -> Slider:
    """Return the butterfly as a slider; mass and inertia are those of its outline in the plate of rect1.

    >>> round(butter_slider().mass, 3)
    1.206
    """
    outline = butter_outline()
    return Slider(outline, _PLATE_DENSITY * outline.area, (0.0, 0.0), inertia=_BUTTER_INERTIA, name="butter")


def dataset_sliders() -> dict[str, Slider]:
    """Return the objects of the MIT push dataset by the names that its files use.

    >>> len(dataset_sliders())
    11
    """
    return {**{name: Slider.mit(name) for name in MIT_SHAPE_NAMES}, "butter": butter_slider()}
