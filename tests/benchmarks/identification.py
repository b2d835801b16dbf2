"""One step of an identification: residuals and derivatives of pushes, beside residuals alone and differences.

Run `python -m tests.benchmarks.identification` from the repository's root. It asserts nothing: times are for people.
"""

import os

# Before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import math

import numpy as np

from cyclemap.evidence import DataBlock
from cyclemap.evidence.data_blocks.stroke_block import push_end_block, surface_model
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.evidence.pushes.measured_strokes import MeasuredPush
from cyclemap.mechanics import Pose, Slider, WorldPush
from tests.benchmarks.timing import Row, seconds, show

PUSHES = 40
SURFACE = SurfaceParameters(
    ellipticity_x=0.1, offset_x=0.04, pusher_friction=0.2, rim_share=0.3, corner_share=0.2, inner_share=0.2
)
_LENGTH, _DIFFERENCE = 0.115, 1e-5


def made_pushes(count: int = PUSHES) -> list[MeasuredPush]:
    """Pushes of MIT's square from random places in random directions, without noise."""
    rng, slider = np.random.default_rng(0), Slider.mit("rect1")
    model, pushes = surface_model(SURFACE, slider), []
    for number in range(count):
        start, way = Pose(theta=float(rng.uniform(-math.pi, math.pi))), float(rng.uniform(-math.pi, math.pi))
        near = start.to_world(*rng.uniform(-0.02, 0.02, 2).tolist())
        first, last = ((near[0] + reach * math.cos(way), near[1] + reach * math.sin(way)) for reach in (-_LENGTH, 0.0))
        end = model.push(start, WorldPush(first, way, _LENGTH)).end
        pushes.append(MeasuredPush(start, end, first, last, number))
    return pushes


def by_differences(block: DataBlock, values: dict[str, float]) -> np.ndarray:
    """The derivatives by central differences, one parameter after the other."""
    columns = []
    for name in block.parameters:
        below, above = (block.residuals({**values, name: values[name] + sign * _DIFFERENCE})[0] for sign in (-1.0, 1.0))
        columns.append((above - below) / (2.0 * _DIFFERENCE))
    return np.stack(columns, axis=1)


def step_rows() -> list[Row]:
    """A step with all parameters free."""
    made = made_pushes()
    block = push_end_block(made, Slider.mit("rect1"))
    values = dict.fromkeys(block.parameters, 0.0) | {
        name: value for name, value in SURFACE.values().items() if name in block.parameters
    }
    note = f"{PUSHES} pushes, {len(block.parameters)} parameters"
    model = surface_model(SURFACE, Slider.mit("rect1"))
    pushes = [(one.start, WorldPush(one.tip_start, one.direction, one.length)) for one in made]
    return [
        Row("residuals and derivatives", seconds(lambda: block.residuals(values), 9), note),
        Row("the pushes alone, one a call", seconds(lambda: [model.push(*one) for one in pushes], 5), note),
        Row("residuals, derivatives by differences", seconds(lambda: by_differences(block, values), 1), note),
    ]


def main() -> None:
    """Print the table."""
    show("one step of an identification", step_rows())


if __name__ == "__main__":
    main()
