"""`cyclemap compare`: a prediction beside data, in sentences, tables, JSON and a picture."""

import math
from functools import partial

from rich.table import Table

from cyclemap.cli.collected.readable_data import (
    PLAIN_UNITS,
    UNITS,
    facts_report,
    readable_data,
    selected_values,
)
from cyclemap.cli.collected.run_fit import QUANTITIES
from cyclemap.cli.commands import CompareOptions
from cyclemap.cli.output import comparison_report, people_table, progress_bar, publish, result_name
from cyclemap.collection.portrait_curves import turn_curve
from cyclemap.evidence.comparison import cycle_agreement
from cyclemap.evidence.comparison.compare import Comparison, compare
from cyclemap.evidence.comparison.push_agreement import (
    PushAgreement,
    QuantityAgreement,
    mean_distances,
)
from cyclemap.evidence.laws.circular_distance import PValue
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics.plate_footprint import plate_note
from cyclemap.views.compare_page import (
    answered_sets,
    compare_page,
    data_sentence,
    headline,
    trust_sentences,
    verdicts,
)
from cyclemap.written import (
    DEGREES,
    MILLIMETRES,
    NUMBER,
    Json,
    Unit,
    degrees,
    if_known,
    json_of,
    written,
)

PUSH_COLUMNS = ("", "measured", "std", "predicted", "bias", "spread", "RMSE", "%", "std %")


def run_compare(asked: CompareOptions) -> None:
    """Compare the loop's prediction with the data, draw both, and print the answers for people or
    as JSON.
    """
    read = readable_data(asked.data, asked.table, asked.results.out)
    chosen = asked.loop.chosen_loop(asked.data)
    loop = chosen.loop
    name = chosen.loop.material.name
    with progress_bar(f"{name} beside {asked.data.name}") as report:
        compared = compare(
            loop,
            read,
            noise=None if chosen.sigma is None else WrappedNormal(chosen.sigma),
            first=asked.first,
            select=selected_values(asked.select),
            # MIT's own 150 mm are no answer for data that do not tell.
            push_length=loop.push.distance if "push_mm" in chosen.settings else None,
            runs=asked.runs,
            seed=asked.seed,
            progress=report,
        )
    note = plate_note(loop.material, loop.slider)
    publish(
        compare_report(name, compared),
        compare_page(name, compared, turn_curve(compared.prediction.map_at(compared.middle))),
        asked.results,
        result_name("compare", loop),
        headline(name, compared),
        data_sentence(compared),
        *compared.data.reading,
        *(verdict.words for verdict in verdicts(compared)),
        *trust_sentences(compared),
        f"note: {note}" if note else "",
        *(
            people_table(
                f"{quantities[0].count} pushes{whose}", PUSH_COLUMNS, map(_push_cells, quantities)
            )
            for whose, quantities in answered_sets(compared)
        ),
        "" if compared.orientations is None else _tests_table(compared.orientations),
    )


def _tests_table(agreement: cycle_agreement.OrientationAgreement) -> Table:
    table = people_table(
        "Histogram of directions, measured against predicted", ("test", "statistic", "p-value")
    )
    for name, test in agreement.tests.items():
        is_angle = name == "wasserstein"
        value = f"{degrees(test.statistic):.2f}°" if is_angle else f"{test.statistic:.3f}"
        p_value = f"{test.value:.3f} ± {test.standard_error:.3f}"
        table.add_row(name.replace("_", " "), value, p_value)
    return table


def _push_cells(quantity: QuantityAgreement) -> list[str]:
    """The row of a quantity; of a mean that is nothing beside the spread a percentage
    says nothing."""
    lengths = (
        quantity.measured_mean,
        quantity.measured_std,
        quantity.predicted_mean,
        quantity.bias,
        quantity.spread,
        quantity.rmse,
    )
    shares = (
        f"{share:.1f}" if quantity.std_percent < 100.0 else "–"
        for share in (quantity.percent, quantity.std_percent)
    )
    return [
        QUANTITIES[quantity.name],
        *(f"{UNITS[quantity.name].of_si(value):.2f}" for value in lengths),
        *shares,
    ]


_PER_DEGREE = Unit("per_deg", math.radians)


def compare_report(material: str, compared: Comparison) -> Json:
    """The report of a comparison; what could not be asked is null or an empty list."""
    ends_off: Json | None = None
    if compared.pushes:
        (place, turn), (isotropic_place, isotropic_turn) = mean_distances(compared.pushes)
        ends_off = {
            "mean_mm": written(place, MILLIMETRES),
            "isotropic_mean_mm": written(isotropic_place, MILLIMETRES),
            "mean_deg": degrees(turn),
            "isotropic_mean_deg": degrees(isotropic_turn),
        }
    return {
        "prediction": {
            "material": material,
            "kind": compared.kind,
            "noise_deg": degrees(math.sqrt(compared.prediction.noise.variance)),
            "posterior_samples": len(compared.prediction.samples),
            "refitted": False,  # a loop follows from its settings: nothing was fitted to these data
        },
        "data": {
            "cycles": 0 if compared.data.pairs is None else compared.data.pairs.theta.size,
            "left_out": dict(compared.data.left_out),
            "unreadable_files": compared.data.unreadable,
        },
        "pushes": [*map(_pushes, compared.pushes)],
        "ends_off": ends_off,
        "cycle": if_known(_cycle, compared.cycle),
        "orientations": if_known(_orientations, compared.orientations),
        "directions": if_known(_directions, compared.directions),
        "staircase": if_known(_staircase, compared.staircase),
        "verdicts": written(verdicts(compared)),
        "uncertified": list(compared.uncertified),
    }


def _pushes(agreement: PushAgreement) -> Json:
    return {
        **facts_report(agreement.facts, "acceleration"),
        "push_mm": written(agreement.length, MILLIMETRES),
        "pushes": agreement.count,
        **{
            UNITS[of.name].named(of.name): json_of(of, unit=PLAIN_UNITS[of.name])
            for of in agreement.quantities
        },
    }


def _cycle(agreement: cycle_agreement.CycleAgreement) -> Json:
    return {
        **json_of(agreement.agreement),
        "measured_turn_deg": degrees(agreement.turn.measured_mean),
        "predicted_turn_deg": degrees(agreement.turn.predicted_mean),
        **json_of(agreement.turn, "bias", "bias_error", "model_error", unit=DEGREES),
        **json_of(agreement, "isotropic_rms", "scatter", unit=DEGREES),
        **json_of(agreement, "lag_correlation"),
        "map_test": if_known(_test, agreement.p_value),
    }


def _test(test: PValue, unit: Unit = NUMBER) -> Json:
    return json_of(test, "statistic", "value", unit=unit)


def _orientations(agreement: cycle_agreement.OrientationAgreement) -> Json:
    units = {"wasserstein": DEGREES}
    return {
        "count": agreement.count,
        **{name: _test(test, units.get(name, NUMBER)) for name, test in agreement.tests.items()},
        "histogram": {
            **json_of(agreement.measured, "edges", unit=DEGREES),
            "measured_per_deg": written(agreement.measured.density, _PER_DEGREE),
            "predicted_per_deg": written(agreement.predicted.density, _PER_DEGREE),
        },
    }


def _directions(agreement: cycle_agreement.DirectionAgreement) -> Json:
    return {
        "predicted": [
            {
                **json_of(match, "kind", "centre", "predicted_mode", "measured_mode", "difference"),
                "p_value": if_known(_p_value, match.p_value),
            }
            for match in agreement.matches
        ],
        **json_of(agreement, "measured_modes"),
    }


def _staircase(agreement: cycle_agreement.StaircaseAgreement) -> Json:
    numbers = agreement.quantities
    return {
        "turns": _simulated(numbers["turns"]),
        "steps": _simulated(numbers["steps"]),
        "step_height_deg": _simulated(numbers["step_height"], PLAIN_UNITS["dtheta"]),
        "residence_cycles": _simulated(numbers["residence"]),
        "theory": if_known(partial(comparison_report, errors=False), agreement.theory),
    }


def _simulated(quantity: cycle_agreement.SimulatedQuantity, unit: Unit = NUMBER) -> Json:
    return {
        **json_of(quantity, "measured", "predicted", "lower", "upper", unit=unit),
        "p_value": if_known(_p_value, quantity.p_value),
    }


def _p_value(test: PValue) -> float:
    return test.value
