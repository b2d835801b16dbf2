"""Explain real pushes and drag-backs of rect1: `python -m tests.inference.rect1_strokes [plywood] [abs]`.

Prints, for each explanation, what was identified and the errors in the sample and of contact points left out.
"""

import os
import sys
from pathlib import Path

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from cyclemap.evidence.data_blocks.measured_strokes import mean_errors, read_measured_drags, read_measured_pushes
from cyclemap.evidence.data_blocks.stroke_block import StrokeBlock, drag_turn_block, push_end_block
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identification.identify import identify
from cyclemap.mechanics import Slider

RECT1 = Slider.mit("rect1")
SHAPE = ("ellipticity_x", "ellipticity_y", "offset_x", "offset_y")
TIP = ("tip_offset_x", "tip_offset_y")
SHARES = ("rim_share", "corner_share", "inner_share")
RING = {"hitch_scale": 1.0, "hitch_turn": 0.0, "pin_friction_radius": 0.0}
HELD = {"pusher_friction": 0.15, **dict.fromkeys(SHARES, 0.0), **RING}
PUSH_EXPLANATIONS = {
    "even pressure": (*SHAPE, "pusher_friction"),
    "frames shifted": (*SHAPE, "pusher_friction", *TIP),
    "frames shifted, weight on the rim": (*SHAPE, "pusher_friction", "rim_share", *TIP),
    "frames shifted, weight on rim, corners and inner part": (*SHAPE, "pusher_friction", *SHARES, *TIP),
}
DRAG_EXPLANATIONS = {
    "even pressure, ideal ring": SHAPE,
    "weight on the rim": (*SHAPE, "rim_share"),
    "shorter lever": (*SHAPE, "hitch_scale"),
    "friction in the ring": (*SHAPE, "pin_friction_radius"),
    "weight on the rim, friction in the ring": (*SHAPE, "rim_share", "pin_friction_radius"),
    "weight on rim, corners and inner part": (*SHAPE, *SHARES),
}


def data_folder() -> Path:
    """Where the measured data lie: the folder that the tests use."""
    return Path(os.environ.get("CYCLEMAP_DATA", str(Path(__file__).parents[3] / "shared" / "data")))


def main(surfaces: list[str]) -> None:
    """Identify each explanation on each surface, pushes first."""
    for surface in surfaces or ["plywood", "abs"]:
        pushes = read_measured_pushes(
            data_folder() / "mit_push_endpoints_v10.csv", {"surface": surface, "shape": "rect1"}
        )
        for title, free in PUSH_EXPLANATIONS.items():
            told(surface, "pushes", title, push_end_block(pushes, RECT1), free, 3.0)
        drags = read_measured_drags(data_folder() / "mit_rect1_dragback_v10.csv", {"surface": surface})
        for title, free in DRAG_EXPLANATIONS.items():
            told(surface, "drags", title, drag_turn_block(drags, RECT1), free, 1.5)


def told(surface: str, sort: str, title: str, block: StrokeBlock, free: tuple[str, ...], student: float) -> None:
    """Identify one explanation by five folds of contacts, and print it."""
    own = {parameter.name: 0.0 for parameter in block.own_parameters}
    fixed = {name: value for name, value in {**HELD, **own}.items() if name in block.parameters and name not in free}
    found = identify([block], free, fixed, starts=1, folds=5, student=student)
    print(f"{surface} {sort}, {title}: {errors(found, sort)}")
    print("   ", "; ".join(str(one) for one in found.estimates))
    print("   ", "; ".join(found.notes) or "no notes", flush=True)


def errors(found: Identification, sort: str) -> str:
    """Mean and median errors in the sample and of rows left out, in words."""
    assert found.validation is not None
    words = []
    for name, residual in (("in sample", found.fit.residuals), ("left out", found.validation.residuals)):
        if sort == "pushes":
            mean = mean_errors(residual.reshape(-1, 3))
            words.append(f"{name} {mean['place_mean_mm']:.2f} mm, {mean['turn_mean_deg']:.2f} deg")
        else:
            turn = np.degrees(np.abs(residual))
            words.append(f"{name} median {np.median(turn):.2f} deg, mean {turn.mean():.2f} deg")
    return "; ".join(words)


if __name__ == "__main__":
    main(sys.argv[1:])
