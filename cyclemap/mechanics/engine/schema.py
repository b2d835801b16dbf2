"""What the equations, C and Python call by the same names, declared here and nowhere else, in their
order.

generate.py writes the enums, tables and structures of C from it; parts.py has the parts of a
pressure.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

from cyclemap.mechanics.engine.columns import Columns, Structure
from cyclemap.mechanics.engine.parts import PARTS, SHARES


class Status(IntEnum):
    """Why a stroke ended, from 0 on; below, why it cannot be run."""

    DISTANCE = 0
    LEFT = 1
    UNSOLVED = -1
    MANY_STEPS = -2
    NO_SLIP = -3
    POINTS_AWAY = -4
    NOT_ALONE = -5
    RING_STOPS = -6
    CHATTERS = -7
    RECORD_FULL = -8
    STOPPED = -9


# The state of a motion: orientation, rad, and the coordinate of the contact on its piece. A
# contact's unknowns: the object's spin by the rod's travel (while it slides: by the approach), and
# the slip along the tangent by the approach.
STATE = Columns("STATE_SIZE", "", "theta coordinate")
UNKNOWN = Columns("UNKNOWN_SIZE", "", "spin slip")
# Laws of a contact, and how many unknowns they have.
LAWS = {"stick": 1, "slide": 2, "turn": 1, "wedge": 1}
# Kinds of pieces of a contact curve, and their geometry: a side's first end and direction; a
# corner; semi-axes; the ring; the rod's centre in a wedge, angles of both normals, and the sense of
# the second contact's friction (-1: of a point, whose friction lies between the outer edges of both
# cones).
KINDS = {
    "side": Columns("SIDE_SIZE", "SIDE_", "x y along_x along_y"),
    "corner": Columns("CORNER_SIZE", "CORNER_", "x y"),
    "ellipse": Columns("ELLIPSE_SIZE", "ELLIPSE_", "semi_x semi_y"),
    "ring": Columns("RING_SIZE", "RING_", "x y"),
    "wedge": Columns("WEDGE_SIZE", "WEDGE_", "x y first_normal second_normal sense"),
}
# Kinds of contact with the laws that they may be under.
PAIRS = (
    *(("side", "stick"), ("side", "slide"), ("corner", "stick"), ("corner", "slide")),
    *(("ellipse", "stick"), ("ellipse", "slide"), ("ring", "stick"), ("ring", "turn")),
    ("wedge", "wedge"),
)


@dataclass(frozen=True)
class Mode:
    """How a contact moves: where, under which law, the sign of its friction, and whether the object
    is held in it.
    """

    name: str
    place: Literal["outline", "ring", "wedge"]
    law: str
    sign: float = 0.0
    is_held: bool = False


MODES = (
    Mode("stick", "outline", "stick", 1.0),
    Mode("slide_left", "outline", "slide", 1.0),
    Mode("slide_right", "outline", "slide", -1.0),
    Mode("slide_free", "outline", "slide"),
    Mode("ring", "ring", "stick"),
    Mode("ring_left", "ring", "turn", 1.0),
    Mode("ring_right", "ring", "turn", -1.0),
    Mode("ring_stuck", "ring", "stick", is_held=True),
    Mode("wedge_left", "wedge", "wedge", 1.0),
    Mode("wedge_right", "wedge", "wedge", -1.0),
    Mode("wedge_stuck", "wedge", "wedge", is_held=True),
)
PLACES = ("outline", "ring", "wedge")

# The law of friction, scaled by ``quasi_static.py``, packed by ``strokes.py``, copied into every
# motion, and turned into the object's frame by ``equations.py``: half axes, the ellipse's centre,
# its direction, and the centre of pressure.
LAW = Columns("LAW_SIZE", "LAW_", "mu_a mu_b m0 n0 phi centre_x centre_y")
# Pieces of a contact curve: kind, geometry, range; the pieces before and after.
PIECE = Columns("PIECE_COLUMNS", "PIECE_", "kind geometry:5 low high before after")
# Parameters of a motion. smu: friction of the rod, negative where it slides clockwise over the
# slider; in the ring the radius of the friction circle, negative where the object turns clockwise.
MOTION = Columns(
    "PARAMETERS",
    "",
    f"direction radius smu {LAW.entries} geometry:5 low high cos_direction sin_direction cos_phi "
    "sin_phi",
)
# Those by which a motion is differentiated, after its state: of the geometry, the first four
# numbers.
VARIED = {
    **{name: MOTION.at(name) for name in ("direction", "radius", "smu")},
    **{name: MOTION.at(name) for name in ("mu_a", "mu_b", "m0", "n0", "phi")},
    **{f"geometry_{k}": MOTION.at("geometry") + k for k in range(4)},
}
# What a contact begins with, besides the twist and the friction matrix: the constant wrench of the
# friction ellipse's centre; contact point and normal, approach and travel along of a rod that
# travels by one, metric of the curve, room to both ends of the piece; the second normal in a wedge.
FRAME = Columns(
    "FRAME_SIZE",
    "FRAME_",
    "force_x force_y torque x y cosine sine approach along metric after_low before_high "
    "second_cosine second_sine",
)
# Twist of the object's frame; the friction matrix M by columns; friction: wrench and Hessian.
TWIST = Columns("TWIST_SIZE", "", "vx vy omega")
MATRIX = Columns("MATRIX_SIZE", "M_", "xx yx xy yy")
FRICTION = Columns("FRICTION_SIZE", "", "force_x force_y torque xx xy yy xw yw ww")
# Margins: where one falls below zero a contact changes. Two are the law's; the last one is of a
# support point that comes to rest or sets out.
MARGIN = Columns("MARGINS", "", "approach after_low before_high first second rests")
# A motion at a state; slopes are by the rod's travel.
MOMENT = Columns(
    "ROW", "", f"state:{STATE.size} slope:{STATE.size} margin:{MARGIN.size} unknown:{UNKNOWN.size}"
)
# What one Newton iteration reports: its correction, what is left of the balance, both forces.
REPORT = Columns("REPORT", "", "correction residual normal_force tangential_force")
# A quadratic c + l . x + x . Q x, and a shape's own: dome r^2 + bow_x (x^2 - y^2) + 2 bow_y x y.
QUADRATIC = Columns("QUADRATIC_SIZE", "Q_", "level slope_x slope_y xx xy yy")
SHAPE = Columns("SHAPE_SIZE", "SHAPE_", "dome bow_x bow_y")
# A row of a foundation's balance: c and l at an orientation, their slopes by it, and how far the
# cubic to the next row is off half way.
BALANCE = Columns("BALANCE_COLUMNS", "BALANCE_", "lean:3 slope:3 error")
# How a floor's shape varies with the place: factors of these terms of it.
FIELD = Columns("FIELD_SIZE", "FIELD_", "x y xx xy yy")
# The shapes of a foundation that is pressed: the floor's and the plate's numbers.
SHAPES = tuple(f"{owner}_{name}" for owner in ("floor", "plate") for name in SHAPE.names)
# What a pressure can be differentiated by.
OF_PRESSURE = (*SHARES, *SHAPES)
# What a cycle can be differentiated by: angles in rad, lengths in extents, shares; the first is the
# map's slope.
PARAMETERS = (
    *("theta", "mu_a", "mu_b", "m0", "n0", "phi", "pusher_friction", "pusher_radius", "fraction"),
    *("angle", "distance", "hitch_x", "hitch_y", *OF_PRESSURE, "pin_friction_radius"),
)
# Sources of a motion's derivatives, in the order of `slopes`: its own parameters, then those of the
# pressure.
SOURCES = (*VARIED, *OF_PRESSURE)

# A task: which loop, from which pose. What comes of it: status (1: done), whether the rod left, the
# push's travel, poses after it and at the end, the ring's way. Its outputs are differentiated.
TASK = Columns("TASK_COLUMNS", "TASK_", "loop pose:3")
OUTPUT = Columns("OUTPUTS", "OUTPUT_", "pushed:3 ended:3 way")
RESULT = Columns(
    "RESULT_COLUMNS", "RESULT_", f"status has_left is_ambiguous travel {OUTPUT.entries}"
)
# The course of a task: number of the stroke (0: the push), the rod's way in the push or drag, the
# rod's place, the object's place and orientation, piece and mode; place of contact (of two, the
# first) and the rod's force, world frame; both forces at the contact, residual of the balance.
RECORD = Columns(
    "RECORD_COLUMNS",
    "RECORD_",
    "stroke way rod:2 place:2 theta piece mode touch:2 force:2 compression tangential residual",
)

# load: of each part, which add to one but for those without a load of their own. middle: centroid
# of the outline. far: centres of rotation farther than this (extents, velocity plane) are summed by
# nodes. Part i has the rows first_row[i] to [i + 1], and alike its nodes. Of a foundation that is
# pressed, which has no parts: both shapes, the centre of mass off the middle, the outline's corners
# off the middle or, without sides, its half axes, the square of how far it reaches from the middle,
# and how it is balanced at orientations over half a turn; where the floor's shape varies with the
# place, by how much, and up to which distance from the world's origin (else 0).
PRESSURE = Structure(
    "Pressure",
    f"load:{len(PARTS)} middle:2 far plate:{SHAPE.size} floor:{SHAPE.size} centre:2 reach "
    f"field:{SHAPE.size * FIELD.size} field_reach",
    f"first_row:{len(PARTS) + 1} first_node:{len(PARTS) + 1} side_count table_count",
    "rows nodes outline table",
)
# What is pushed with what: shared by many strokes, and never written. pieces: of the contact curve,
# the ring last.
OBJECT = Structure(
    "Object",
    f"friction:{LAW.size} radius tolerance",
    "piece_count",
    "pieces",
    (("pressure", PRESSURE),),
)
# What is done again and again with one object: a push from where the rod first touches
# (by_fraction: the derivative of that by the fraction), in a direction as seen from the object or
# from the world; length 0: none; then a drag to goals.
LOOP = Structure(
    "Loop",
    "start_coordinate by_fraction direction length rod_friction pin_friction",
    "start_piece with_object goal_count",
    "goals",
    (("object", OBJECT),),
)
