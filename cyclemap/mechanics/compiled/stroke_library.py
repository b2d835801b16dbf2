"""The C source of one kind of stroke: the CasADi functions of its laws, tables of them, and the driver."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import casadi as ca
import numpy as np

from cyclemap.mechanics import contact_solver, event_integration, motion, phase_variation, push_run, runge_kutta
from cyclemap.mechanics.contact_equations import (
    ARGUMENTS,
    RING_FRICTION,
    SLIDE,
    STATE_ARGUMENTS,
    STICK,
    contact_functions,
)
from cyclemap.mechanics.footprint import PointFootprint
from cyclemap.mechanics.motion_functions import (
    BEND,
    DIRECTION,
    ITERATIONS,
    NEAREST_STAGE,
    PARAMETERS,
    argument_slopes,
    arguments_function,
    rate_function,
    rate_slopes,
    touch_function,
)
from cyclemap.mechanics.patch_integrals import far_ratio
from cyclemap.mechanics.pressure_family import PressureFamily

# Kinds of contact by their numbers in C.
KINDS = ("side", "corner", "ellipse", "ring")
_RING = "ring"
_SHARED = ("solver", "tangent")
_FILES = (
    "kernel_prelude",
    "contact_motions",
    "contact_search",
    "support_points",
    "stroke_steps",
    "stroke_slopes",
    "stroke_events",
    "stroke_cycles",
)


@dataclass(frozen=True)
class StrokeKind:
    """What one library can run: a family of footprints, pushes on the kinds of contact of an outline, and the ring."""

    pressure: PressureFamily
    kinds: tuple[str, ...]

    @property
    def laws(self) -> tuple[tuple[str, str], ...]:
        """Kinds of contact with their laws."""
        return (*((kind, law) for kind in self.kinds for law in (STICK, SLIDE)), (_RING, RING_FRICTION))


def stroke_source(stroke: StrokeKind) -> str:
    """Return the C source of a library that runs strokes: prelude, functions, tables, driver."""
    functions = {name: _renamed(function, name) for name, function in _functions(stroke)}
    prelude, *driver = (Path(__file__).with_name(f"{name}.c").read_text() for name in _FILES)
    return "\n".join((prelude, _generated(functions), _tables(stroke, functions), *driver))


def _functions(stroke: StrokeKind) -> Iterable[tuple[str, ca.Function]]:
    equations = sorted({_equations(law) for _, law in stroke.laws})
    for law, near in product(equations, sorted({_served_by(stroke, near) for near in (True, False)})):
        contact = contact_functions(stroke.pressure, law, near)
        yield _of("solver", law, near), contact.solver
        yield _of("tangent", law, near), contact.state_tangent
    for kind in (*stroke.kinds, _RING):
        yield f"arguments_{kind}", arguments_function(kind)
        yield f"chain_{kind}", argument_slopes(kind, DIRECTION, STATE_ARGUMENTS)
    for kind, law in stroke.laws:
        yield f"rate_{kind}_{law}", rate_function(kind, law)
        yield f"rate_slopes_{kind}_{law}", rate_slopes(kind, law, DIRECTION)
    yield from ((f"touch_{kind}", touch_function(kind)) for kind in stroke.kinds)


def _served_by(stroke: StrokeKind, near: bool) -> bool:
    """The regime whose functions serve another one: support points are summed alike near and far."""
    return near or not _is_smooth(stroke)


def _is_smooth(stroke: StrokeKind) -> bool:
    return not isinstance(stroke.pressure.footprint, PointFootprint)


def _equations(law: str) -> str:
    """Without friction a ring is a contact that sticks: the driver sets it to zero for both."""
    return SLIDE if law == SLIDE else RING_FRICTION


def _of(member: str, law: str, near: bool) -> str:
    return f"{member}_{law}_{'near' if near else 'far'}"


def _generated(functions: dict[str, ca.Function]) -> str:
    generator = ca.CodeGenerator("kernels", {"with_header": False})
    for function in functions.values():
        generator.add(function)
    return str(generator.dump())


def _renamed(function: ca.Function, name: str) -> ca.Function:
    """Scalar functions are copied, others called."""
    if function.is_a("SXFunction"):
        inputs = function.sx_in()
        return ca.Function(name, inputs, function.call(inputs))
    inputs = function.mx_in()
    return ca.Function(name, inputs, function.call(inputs, False, True))


def _tables(stroke: StrokeKind, functions: dict[str, ca.Function]) -> str:
    sizes = [(f.sz_arg(), f.sz_res(), f.sz_iw(), f.sz_w()) for f in functions.values()]
    numbers = zip(("ARGUMENTS", "RESULTS", "INTEGERS", "WORK"), np.max(sizes, axis=0).tolist(), strict=True)
    lines = [f"enum {{ {', '.join(f'{name} = {value + 4}' for name, value in numbers)} }};"]
    lines.append(f"enum {{ EQUATION_ARGUMENTS = {len(ARGUMENTS)} }};")
    lines.append(
        f"enum {{ STAGES = {runge_kutta.STAGES}, PARAMETERS = {len(PARAMETERS)}, RING_KIND = {KINDS.index(_RING)} }};"
    )
    lines += [f"#define {name} {value}" for name, value in _constants(stroke).items()]
    order = event_integration.STAGE_ORDER
    lines.append(f"enum {{ PLACE_COUNT = {len(order)} }};")
    lines.append(f"static const int STAGE_ORDER[] = {_braced(order)}, NEAREST_STAGE[] = {_braced(NEAREST_STAGE)};")
    lines.append(f"static const int ITERATIONS[] = {_braced(ITERATIONS)};")
    for name, values in (
        ("STAGE_PLACES", event_integration.STAGE_PLACES),
        ("B", runge_kutta.B),
        ("ERROR", runge_kutta.ERROR),
        *((name, getattr(runge_kutta, name)) for name in ("ROUGH", "MIDDLE_STATE", "MIDDLE_VALUE")),
    ):
        lines.append(f"static const double {name}[] = {_braced(values)};")
    for name, table in (("A", runge_kutta.A), ("BEND", BEND)):
        rows = _braced(_braced(row) for row in table.tolist())
        lines.append(f"static const double {name}[{table.shape[0]}][{table.shape[1]}] = {rows};")
    return "\n".join([*lines, *_points(stroke), *_law_tables(stroke)]) + "\n"


def _points(stroke: StrokeKind) -> list[str]:
    """The support points with their shares of the load; of a patch none, but for what C wants in a table."""
    footprint = stroke.pressure.footprint
    points, weights = footprint.quadrature if isinstance(footprint, PointFootprint) else (np.zeros((0, 2)), np.zeros(0))
    rows = ", ".join(_braced(map(repr, row)) for row in np.column_stack([points, weights]).tolist())
    return [f"enum {{ POINT_COUNT = {len(points)} }};", f"static const double POINTS[][3] = {{{rows or '{0.0}'}}};"]


def _law_tables(stroke: StrokeKind) -> list[str]:
    """Which functions serve which kind of contact and law."""
    laws = []
    for kind, law in stroke.laws:
        contact = ", ".join(
            _braced(_of(member, _equations(law), _served_by(stroke, near)) for near in (True, False))
            for member in _SHARED
        )
        own = f"arguments_{kind}, chain_{kind}, rate_{kind}_{law}, rate_slopes_{kind}_{law}"
        laws.append(f"[{KINDS.index(kind)}][{int(law == SLIDE)}] = {{{2 if law == SLIDE else 1}, {contact}, {own}}}")
    touches = [f"[{KINDS.index(kind)}] = touch_{kind}" for kind in stroke.kinds]
    return [
        "typedef int Function(const double **, double **, casadi_int *, double *, int);",
        "typedef struct { int unknowns; Function *solver[2], *tangent[2];",
        "    Function *arguments, *chain, *rate, *rate_slopes; } Law;",
        f"static const Law LAWS[{len(KINDS)}][2] = {{{', '.join(laws)}}};",
        f"static Function *const TOUCH[{len(KINDS)}] = {{{', '.join(touches)}}};",
    ]


def _constants(stroke: StrokeKind) -> dict[str, object]:
    ratio, events, method = far_ratio(stroke.pressure), event_integration, runge_kutta
    limits = {"FAR_RATIO": ratio, "NEAR_LIMIT": ratio * motion.NEAR_LIMIT, "FAR_LIMIT": ratio * motion.FAR_LIMIT}
    return {
        **(limits if _is_smooth(stroke) else dict.fromkeys(limits, "INFINITY")),
        "SMOOTH": int(_is_smooth(stroke)),
        "LEFT_OVER": motion.LEFT_OVER,
        "LEFT_AT_POINTS": motion.LEFT_AT_POINTS,
        "AGAIN": motion.AGAIN,
        **{name: getattr(phase_variation, name) for name in ("STILL", "UNSOLVED")},
        "FOUND": contact_solver.FOUND,
        "ACCEPTED": contact_solver.ACCEPTED,
        "TURNS_BACK": motion.TURNS_BACK,
        **{name: getattr(method, name) for name in ("ORDER", "SAFETY", "SHRINK", "GROW", "LEAST_SHARE")},
        **{name: getattr(events, name) for name in ("SLACK_SHARE", "STRICT_SHARE", "DIP", "LEAST_ADVANCE", "STUCK")},
        **{name: getattr(events, name) for name in ("SHORT", "MOST_STEPS", "FIRST_PUSH_STEP", "FIRST_DRAG_STEP")},
        "MOST_PHASES": push_run.MOST_PHASES,
        "NO_LEG": event_integration.NO_LEG,
    }


def _braced(values: Iterable[object]) -> str:
    return f"{{{', '.join(str(value) for value in values)}}}"
