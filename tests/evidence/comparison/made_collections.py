"""Made collections whose law is known: paths of a sine map, and tables of pushes that a loop made
itself.
"""

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.evidence.pushes.push_table import PushTable, load_pushes
from cyclemap.evidence.pushes.theta0_pairs import Theta0Pairs
from cyclemap.maps import CircleMap, DriftingMap, WrappedNormal, sample_staircase

SINE, NOISE = CircleMap.arnold(0.11, 0.6), WrappedNormal(0.15)
WORN = DriftingMap.between([(0, CircleMap.arnold(0.05, 0.3)), (400, CircleMap.arnold(0.12, 0.3))])
POSE_HEADER = "rep,surface,shape,a_mm_s2,v_mm_s,i,s,t,push_mm,x0,y0,theta0,x1,y1,theta1"


def pairs_of(path) -> Theta0Pairs:
    return Theta0Pairs(path[:-1], path[1:], path)


def sine_pairs(cycles=300, seed=0, circle_map=SINE, start=0.5) -> Theta0Pairs:
    return pairs_of(sample_staircase(circle_map, NOISE, cycles, start, seed).theta)


def pose_row(number, theta, turn, displacement, **facts) -> str:
    """A line of a table of poses: a push from (0.1, -0.2) m."""
    known = {
        "surface": "plywood",
        "shape": "rect1",
        "i": 0,
        "s": 0.7,
        "t": 0.0,
        "v": 20,
        "push_mm": 150,
        **facts,
    }
    c, s = np.cos(theta), np.sin(theta)
    x = 0.1 + c * displacement[0] - s * displacement[1]
    y = -0.2 + s * displacement[0] + c * displacement[1]
    begin = f"{number},{known['surface']},{known['shape']},0,{known['v']},{known['i']},{known['s']},{known['t']}"
    return f"{begin},{known['push_mm']},0.1,-0.2,{theta:.12f},{x:.12f},{y:.12f},{theta + turn:.12f}"


def write_poses(file, rows) -> PushTable:
    file.write_text("\n".join([POSE_HEADER, *rows]) + "\n")
    return load_pushes(file)


def own_pushes(loop: CollectionLoop, thetas, off=(0.0, 0.0, 0.0), **facts) -> list[str]:
    """Rows of pushes as the loop makes them, off by (rad, m, m)."""
    rows = []
    for number, theta in enumerate(thetas):
        push = loop.model.push(loop.start_pose(float(theta)), loop.push)
        rows.append(
            pose_row(
                number,
                float(theta),
                push.turn + off[0],
                push.displacement + np.array(off[1:]),
                **facts,
            )
        )
    return rows
