"""Writes the part of the engine that is generated: CasADi's functions as C, and the tables that the
driver reads.
"""

from collections.abc import Iterable
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cyclemap.mechanics.engine import equations, schema
from cyclemap.mechanics.engine.columns import braced, enum_of, numbered
from cyclemap.mechanics.engine.parts import NODE, PARTS, ROW, ROW_KINDS, SHARES

# Verner's efficient method of order 7 with its estimator of order 6 (Numerically optimal
# Runge-Kutta pairs with interpolants, Numerical Algorithms 53, 2010: pair IIa). For errors of 1e-10
# it evaluates two fifths less often than Dormand & Prince's method of order 5, for errors of 1e-7
# no more often.
STAGES, ORDER = 10, 7
ROWS = (
    (),
    (0.005,),
    (-1.0767901234567901, 1.1856790123456790),
    (0.040833333333333333, 0.0, 0.1225),
    (0.63891392362557267, 0.0, -2.4556726382236568, 2.2722587145980841),
    (-2.6615773750187571, 0.0, 10.804513886456137, -8.3539146573961994, 0.82048759495665697),
    (
        6.0677414346967710,
        0.0,
        -24.711273635911086,
        20.427517930788894,
        -1.9061579788166471,
        1.0061722492420680,
    ),
    (
        *(12.054670076253203, 0.0, -49.754784950468989, 41.142888638604677, -4.4617601499740042),
        *(2.0423348222391750, -0.098348436654061074),
    ),
    (
        *(10.138146522881808, 0.0, -42.641136031717502, 35.763840039922571, -4.3480228403929077),
        *(2.0098622683770359, 0.34874904603382724, -0.27143900510483128),
    ),
    (
        *(-45.030072034298677, 0.0, 187.32724376545888, -154.02882369350187, 18.564653063475362),
        *(-7.1418096792950789, 1.3088085781613786),
    ),
)
WEIGHTS = (
    *(0.047155618486272222, 0.0, 0.0, 0.25750564298434152, 0.26216653977412620),
    *(0.15216092656738557, 0.49399691700324842, -0.29430311714032504, 0.081317472324951099, 0.0),
)
LOWER = (
    *(0.044608606606341176, 0.0, 0.0, 0.26716403785713727, 0.22010183001772930),
    *(0.21884317031431568, 0.22898717054112028, 0.0, 0.0, 0.020295184663356282),
)
C = np.array((0, 0.005, 49 / 450, 49 / 300, 0.4555, 0.60950944899783813, 0.884, 0.925, 1.0, 1.0))
# The stages and the end.
PLACES = np.append(C, 1.0)

# Weights (11,) for the middle of a step: of the slopes, for the state there off that at the start;
# of what depends on the state, for its value there. The least that meet all conditions of order 5
# (Hairer, Norsett & Wanner 1993, II.6).
MIDDLE_STATE = (
    *(
        0.035872124140919226,
        0.0,
        0.0,
        0.2927778629723282,
        0.15466583111049065,
        0.035335738322645936,
    ),
    *(
        -0.022795887222108478,
        -0.01598795836457182,
        -0.002983084893816224,
        -0.00813462606585775,
        0.03124999999997027,
    ),
)
MIDDLE_VALUE = (
    *(
        -0.013511819410986205,
        0.0,
        0.0,
        0.02972671393272141,
        0.5677895152953676,
        0.49678072753427055,
    ),
    *(
        -0.06264859328084359,
        -0.09655820701226067,
        -0.043937232907102934,
        -0.06514110415106912,
        0.18749999999990288,
    ),
)
PANEL_ORDER = 12
# Gauss's rules along what bounds a contact, and the exponents of their errors that are asked for,
# of rough to fine motions. Arcs take those from LEAST_RULE on, four nodes at once.
BOUNDARY_RULES, BOUNDARY_DIGITS = (4, 6, 8, 12, 16, 20, 24, 32), (18.0, 21.5, 25.0, 31.0)
LEAST_RULE = BOUNDARY_RULES.index(8)
# Places on an ellipse's rim between which a pressure is looked at.
RIM_SAMPLES = 32
# Trapezoidal rules over half a period of an ellipse's integrals, and the exponent that their errors
# have at most.
RULES, DIGITS = (8, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512), 34.0


def write_sources(folder: Path) -> None:
    """Write kernels.c into a folder: the schema, the functions, and tables of them and of the
    method's numbers.
    """
    functions = equations.kernels() | equations.contacts()
    generator = ca.CodeGenerator("kernels", {"with_header": False, "casadi_int": "int64_t"})
    for function in functions.values():
        generator.add(function)
    (Path(folder) / "kernels.c").write_text(
        "\n".join((_names(), generator.dump(), _tables(), *_in_wide())), encoding="utf-8"
    )


# How instructions of CasADi's are written for Wide, of the results of earlier ones.
WIDE_OPERATIONS = {
    **{ca.OP_ADD: "{0} + {1}", ca.OP_SUB: "{0} - {1}", ca.OP_MUL: "{0} * {1}"},
    **{ca.OP_DIV: "{0} / {1}", ca.OP_NEG: "-{0}", ca.OP_SQ: "{0} * {0}", ca.OP_TWICE: "{0} + {0}"},
    **{ca.OP_INV: "1.0 / {0}", ca.OP_FABS: "sizes({0})", ca.OP_SQRT: "roots({0})"},
    **{ca.OP_LOG1P: "logarithms({0})", ca.OP_SIGN: "signs({0})"},
}


def _in_wide() -> list[str]:
    """The functions of some places at once, in C."""
    return [_wide_code(name, function) for name, function in equations.rim_kernels().items()]


def _wide_code(name: str, function: ca.Function) -> str:
    """One function of one row of numbers, each of them Wide."""
    lines = [f"static ALWAYS_INLINE void {name}(const Wide *given, Wide *found) {{"]
    lines.append(f"    Wide {', '.join(f'a{place}' for place in range(function.sz_w()))};")
    for index in range(function.n_instructions()):
        operation = function.instruction_id(index)
        read, written = function.instruction_input(index), function.instruction_output(index)
        if operation == ca.OP_CONST:
            lines.append(
                f"    a{written[0]} = (Wide){{0.0}} + {function.instruction_constant(index)!r};"
            )
        elif operation == ca.OP_INPUT:
            lines.append(f"    a{written[0]} = given[{read[1]}];")
        elif operation == ca.OP_OUTPUT:
            lines.append(f"    found[{written[1]}] = a{read[0]};")
        else:
            value = WIDE_OPERATIONS[operation].format(*(f"a{place}" for place in read))
            lines.append(f"    a{written[0]} = {value};")
    return "\n".join([*lines, "}"])


def bend_weights() -> NDArray[np.float64]:
    """Weights (11, 11) of earlier stages: what their unknowns are off the tangent, over their
    places' squares, goes on.

    By a parabola through the last three; more would magnify what their states are off the path. The
    end, and the stage that lies there for the estimate alone, go by the first stage at that place.
    """
    weights = np.zeros((STAGES + 1, STAGES + 1))
    for i in range(2, STAGES + 1):
        used = np.arange(max(1 if i < 4 else 2, i - 3), i) if i < 9 else np.array((8,))
        for k in used:
            others = PLACES[used[used != k]]
            lagrange = np.prod((PLACES[i] - others) / (PLACES[k] - others))
            weights[i, k] = lagrange * (PLACES[i] / PLACES[k]) ** 2
    return weights


def rough_weights() -> NDArray[np.float64]:
    """Weights (11,) of the fifth divided difference of the slopes at six stages, that of the last
    as in the method.

    What a method of order 5 of the same stages would add. It falls with the sixth power of the
    step, the estimate with the seventh: as large on usual steps, a share of it remains where the
    estimate nearly vanishes by chance, as it may when the centre of rotation crosses the rim within
    a step. Shares of .05 left single cycles eight accuracies off, .3 and .5 none beyond one and a
    half.
    """
    used = np.array((0, 3, 4, 5, 6, 7))
    apart = C[used, None] - C[used] + np.eye(used.size)
    weights = np.zeros(STAGES + 1)
    weights[used] = 1.0 / apart.prod(axis=1)
    return np.asarray(weights * WEIGHTS[used[-1]] / weights[used[-1]])


def _names() -> str:
    """Enums, structures and tables of what schema.py declares."""
    rows = (
        *(schema.STATE, schema.UNKNOWN, schema.TWIST, schema.MATRIX, schema.FRICTION),
        *(schema.MOTION, schema.FRAME, schema.MARGIN, schema.MOMENT, schema.REPORT),
        *(schema.PIECE, *schema.KINDS.values(), ROW, *ROW_KINDS.values(), NODE),
        *(schema.TASK, schema.RESULT, schema.OUTPUT, schema.RECORD),
        *(schema.QUADRATIC, schema.SHAPE, schema.BALANCE, schema.FIELD),
    )
    modes, parts = schema.MODES, [part.name for part in PARTS]
    shares = [SHARES.index(part.share) if part.share else -1 for part in PARTS]
    balances = [parts.index(part.balance) if part.balance else -1 for part in PARTS]
    integers = {
        "UNKNOWNS": schema.LAWS.values(),
        "MODE_LAW": [list(schema.LAWS).index(mode.law) for mode in modes],
        "MODE_PLACE": [schema.PLACES.index(mode.place) for mode in modes],
        "MODE_HELD": [int(mode.is_held) for mode in modes],
        "VARIED_AT": schema.VARIED.values(),
        "SHARE_OF_PART": shares,
        "BALANCE_OF_PART": balances,
        "BY_PRESSURE": [schema.PARAMETERS.index(name) for name in schema.OF_PRESSURE],
    }
    return "\n".join(
        [
            "#include <stdint.h>",
            *(columns.enum() for columns in rows),
            enum_of({status.name: status.value for status in schema.Status}),
            numbered([mode.name for mode in modes]),
            numbered(schema.PLACES, "AT_"),
            numbered(tuple(schema.LAWS), "LAW_", "LAWS"),
            numbered(tuple(schema.KINDS), "KIND_", "KINDS"),
            numbered(tuple(ROW_KINDS)),
            numbered(parts, size_name="PARTS"),
            numbered(schema.PARAMETERS, "BY_", "MOST_VARIED"),
            numbered(schema.SOURCES, "SOURCE_", "SOURCES"),
            enum_of(
                {
                    "VARIED": len(schema.VARIED),
                    "SHARES": len(SHARES),
                    "OF_PRESSURE": len(schema.OF_PRESSURE),
                }
            ),
            *(
                f"static const int {name}[] = {braced(values)};"
                for name, values in integers.items()
            ),
            f"static const double SIGN[] = {braced(mode.sign for mode in modes)};",
            *(each.definition() for each in (schema.PRESSURE, schema.OBJECT, schema.LOOP)),
        ]
    )


def _tables() -> str:
    coefficients = np.array([row + (0.0,) * (STAGES - 1 - len(row)) for row in ROWS])
    nodes, weights = np.polynomial.legendre.leggauss(PANEL_ORDER)
    order = [i for i in np.argsort(C, kind="stable").tolist() if C[i] < 1.0] + [STAGES]
    counts = {
        "STAGES": STAGES,
        "ORDER": ORDER,
        "PLACE_COUNT": len(order),
        "RULE_COUNT": len(RULES),
        "PANEL_ORDER": PANEL_ORDER,
        "BOUNDARY_RULE_COUNT": len(BOUNDARY_RULES),
        "RIM_SAMPLES": RIM_SAMPLES,
        "LEAST_RULE": LEAST_RULE,
        "LONGEST_RULE": BOUNDARY_RULES[-1],
        "DIGIT_CLASSES": len(BOUNDARY_DIGITS),
    }
    boundary = [np.polynomial.legendre.leggauss(order) for order in BOUNDARY_RULES]
    along = np.concatenate([nodes for nodes, _ in boundary]) / 2.0 + 0.5
    # The last is the first to the bit.
    around = np.append(np.arange(RIM_SAMPLES), 0) * 2.0 * np.pi / RIM_SAMPLES
    # The half axes of Bernstein's ellipse from which a rule serves, and the larger one of an arc's
    # poles, at which sums are of the fifth order: errors are larger by (2 n)^4 / 4!.
    twice, digits = 2.0 * np.array(BOUNDARY_RULES), np.array(BOUNDARY_DIGITS)[:, None]
    reach = digits / twice
    pole_reach = np.cosh((digits + np.log(twice**4 / 24.0)) / twice)
    lines = [enum_of(counts)]
    integers = {"STAGE_ORDER": order}
    angles = np.concatenate([(np.arange(count // 2) + 0.5) * np.pi / count for count in RULES])
    integers["FIRST_NODE"] = np.cumsum([0, *(count // 2 for count in RULES)]).tolist()
    integers["RULES"] = list(RULES)
    integers["BOUNDARY_FIRST"] = np.cumsum([0, *BOUNDARY_RULES]).tolist()
    numbers: dict[str, Iterable[float]] = {
        "NODE_COSINES": np.cos(angles),
        "NODE_SINES": np.sin(angles),
        # Squared hyperbolic cosines of the distances at which singularities may be.
        "PATCH_REACH": np.cosh(DIGITS / (2.0 * np.array(RULES))) ** 2,
        "STAGE_PLACES": PLACES[order],
        "B": WEIGHTS,
        "ERROR": np.append(np.subtract(WEIGHTS, LOWER), 0.0),
        "ROUGH": rough_weights(),
        "MIDDLE_STATE": MIDDLE_STATE,
        "MIDDLE_VALUE": MIDDLE_VALUE,
        "RIM_COSINES": np.cos(around),
        "RIM_SINES": np.sin(around),
        "BOUNDARY_NODES": along,
        "BEGUN": (1.0 - along) ** 2,
        "BOTH": along * (1.0 - along),
        "ENDED": along**2,
        "BOUNDARY_WEIGHTS": np.concatenate([weights for _, weights in boundary]) / 2.0,
        "GAUSS_NODES": nodes,
        "GAUSS_WEIGHTS": weights,
    }
    lines += [f"static const int {name}[] = {braced(values)};" for name, values in integers.items()]
    lines += [
        f"static const double {name}[] = {braced(map(float, values))};"
        for name, values in numbers.items()
    ]
    for name, table in (
        ("A", coefficients),
        ("BEND", bend_weights()),
        ("REACH_X", np.cosh(reach) ** -2),
        ("REACH_Y", np.sinh(reach) ** -2),
        ("POLE_REACH", pole_reach**2),
    ):
        rows = braced(braced(row) for row in table.tolist())
        lines.append(f"static const double {name}[{table.shape[0]}][{table.shape[1]}] = {rows};")
    lines.append(
        "typedef int Function(const casadi_real **, casadi_real **, casadi_int *, casadi_real *, "
        "int);"
    )
    for name in ("BEGIN", "SLOPES", "ALL_SLOPES"):
        entries = braced(
            f"[KIND_{kind.upper()}][LAW_{law.upper()}] = {name.lower()}_{kind}_{law}"
            for kind, law in schema.PAIRS
        )
        lines.append(f"static Function *const {name}[KINDS][LAWS] = {entries};")
    lines.append(
        f"static Function *const FINISH[] = {braced(f'finish_{law}' for law in schema.LAWS)};"
    )
    return "\n".join(lines) + "\n"
