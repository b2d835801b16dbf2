"""`cyclemap compare`: a prediction beside data, in sentences, tables, JSON and a picture."""

import math
from pathlib import Path

from cyclemap.cli.json_report import (
    Json,
    comparison_report,
    degrees,
    degrees_of,
    direction_deg,
    number,
)
from cyclemap.cli.options import ResultOptions, TableOptions, readable_data
from cyclemap.cli.output import PeopleConsole, people_table, progress_bar, publish, result_stem
from cyclemap.cli.run_fit import selected_values
from cyclemap.collection.portrait_curves import turn_curve
from cyclemap.evidence.comparison import cycle_agreement
from cyclemap.evidence.comparison.compare import Comparison, compare
from cyclemap.evidence.comparison.push_agreement import (
    PushAgreement,
    QuantityAgreement,
    mean_distances,
)
from cyclemap.evidence.orientations.circular_distance import PValue
from cyclemap.maps import WrappedNormal
from cyclemap.mechanics.plate_footprint import plate_note
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop, told_settings
from cyclemap.views.compare_page import compare_page, data_sentence, headline, trust_sentences

PUSH_COLUMNS = ("", "measured", "std", "predicted", "bias", "spread", "RMSE", "%", "std %")
SYMBOLS = {"dtheta": "Δθ (°)", "dx": "Δx (mm)", "dy": "Δy (mm)"}


def run_compare(
    options: LoopOptions,
    data: Path,
    table: TableOptions,
    first: int,
    select: tuple[str, ...],
    runs: int,
    seed: int,
    results: ResultOptions,
) -> None:
    """Compare the loop's prediction with the data, draw both, and print the answers for people or
    as JSON.
    """
    read = readable_data(data, table, results.out)
    loop, sigma = chosen_loop(options, data)
    name = loop.material.name
    with progress_bar(f"{name} beside {data.name}") as report:
        found = compare(
            loop,
            read,
            noise=None if sigma is None else WrappedNormal(sigma),
            first=first,
            select=selected_values(select),
            # MIT's own 150 mm are no answer for data that do not tell.
            push_length=loop.push.distance
            if "push_mm" in told_settings(options, data)[1]
            else None,
            runs=runs,
            seed=seed,
            progress=report,
        )
    page = compare_page(name, found, turn_curve(found.prediction.map_at(found.middle)))
    stem = result_stem(results.out, "compare", loop)
    picture = publish(compare_report(name, found), page, stem, results)
    if picture is None:
        return
    console = PeopleConsole()
    verdicts = (verdict.words for verdict in found.verdicts)
    note = plate_note(loop.material, loop.slider)
    told = (data_sentence(found), *found.data.reading, *verdicts, *trust_sentences(found))
    console.tell(headline(name, found), *told, *([f"note: {note}"] if note else []))
    for whose, quantities in found.told_pushes:
        title = f"{quantities[0].count} pushes{whose}"
        console.print_table(people_table(title, PUSH_COLUMNS, map(_push_cells, quantities)))
    if found.orientations is not None:
        tests = people_table(
            "Histogram of directions, measured against predicted", ("test", "statistic", "p-value")
        )
        for name, test in found.orientations.tests.items():
            value = (
                f"{math.degrees(test.statistic):.2f}°"
                if name == "wasserstein"
                else f"{test.statistic:.3f}"
            )
            tests.add_row(
                name.replace("_", " "), value, f"{test.value:.3f} ± {test.standard_error:.3f}"
            )
        console.print_table(tests)
    console.print(f"picture: {picture}")


def _push_cells(one: QuantityAgreement) -> list[str]:
    """The row of a quantity; of a mean that is nothing beside the spread a percentage
    says nothing."""
    scale = math.degrees(1.0) if one.name == "dtheta" else 1000.0
    lengths = (
        one.measured_mean,
        one.measured_std,
        one.predicted_mean,
        one.bias,
        one.spread,
        one.rmse,
    )
    shares = (
        f"{share:.1f}" if one.std_percent < 100.0 else "–"
        for share in (one.percent, one.std_percent)
    )
    return [SYMBOLS[one.name], *(f"{scale * value:.2f}" for value in lengths), *shares]


_DEGREE, _METRE = math.degrees(1.0), 1000.0


def compare_report(material: str, found: Comparison) -> Json:
    """The report of a comparison; what could not be asked is null or an empty list."""
    ends_off: Json | None = None
    if found.pushes:
        (place, turn), (isotropic_place, isotropic_turn) = mean_distances(found.pushes)
        ends_off = {
            "mean_mm": number(_METRE * place),
            "isotropic_mean_mm": number(_METRE * isotropic_place),
        }
        ends_off |= {"mean_deg": degrees(turn), "isotropic_mean_deg": degrees(isotropic_turn)}
    return {
        "prediction": {
            "material": material,
            "kind": found.prediction.kind,
            "noise_deg": number(math.degrees(math.sqrt(found.prediction.noise.variance))),
            "posterior_samples": len(found.prediction.samples),
            "refitted": False,  # a loop follows from its settings: nothing was fitted to these data
        },
        "data": {
            "cycles": 0 if found.data.pairs is None else found.data.pairs.theta.size,
            "left_out": dict(found.data.left_out),
            "unreadable_files": found.data.unreadable,
        },
        "pushes": [_pushes(one) for one in found.pushes],
        "ends_off": ends_off,
        "cycle": None if found.cycle is None else _cycle(found.cycle),
        "orientations": None if found.orientations is None else _orientations(found.orientations),
        "directions": None if found.directions is None else _directions(found.directions),
        "staircase": None if found.staircase is None else _staircase(found.staircase),
        "verdicts": [
            {"question": one.question, "agrees": one.agrees, "words": one.words}
            for one in found.verdicts
        ],
        "uncertified": list(found.uncertified),
    }


def _pushes(found: PushAgreement) -> Json:
    facts = found.facts
    scales = {"dtheta": ("dtheta_deg", _DEGREE), "dx": ("dx_mm", _METRE), "dy": ("dy_mm", _METRE)}
    return {
        "surface": facts["surface"],
        "object": facts["object"],
        "speed_mm_s": number(_METRE * facts["speed"]),
        "side": number(facts["side"]),
        "fraction": number(facts["fraction"]),
        "angle_deg": number(_DEGREE * facts["angle"]),
        "push_mm": number(_METRE * found.length),
        "pushes": found.count,
        **{scales[one.name][0]: _quantity(one, scales[one.name][1]) for one in found.quantities},
    }


def _quantity(found: QuantityAgreement, scale: float) -> Json:
    lengths = (
        "measured_mean",
        "measured_std",
        "predicted_mean",
        "predicted_std",
        "bias",
        "spread",
        "rmse",
    )
    return {
        **{name: number(scale * getattr(found, name)) for name in lengths},
        "bias_error": None if found.bias_error is None else number(scale * found.bias_error),
        "model_error": number(scale * found.model_error),
        "rmse_percent": number(found.percent),
        "measured_std_percent": number(found.std_percent),
    }


def _cycle(found: cycle_agreement.CycleAgreement) -> Json:
    return {
        "pairs": found.agreement.pairs,
        "rms_deg": degrees(found.agreement.rms),
        "bins": found.agreement.bins,
        "bin_rms_deg": degrees(found.agreement.bin_rms),
        "measured_turn_deg": degrees(found.turn.measured_mean),
        "predicted_turn_deg": degrees(found.turn.predicted_mean),
        **degrees_of(found.turn, "bias", "bias_error", "model_error"),
        **degrees_of(found, "isotropic_rms", "scatter"),
        "lag_correlation": number(found.lag_correlation),
        "map_test": _p_value(found.p_value),
    }


def _orientations(found: cycle_agreement.OrientationAgreement) -> Json:
    tests, distance = (
        {name: _p_value(one) for name, one in found.tests.items()},
        found.tests["wasserstein"],
    )
    wasserstein = {"statistic_deg": degrees(distance.statistic), "p_value": number(distance.value)}
    return {
        "count": found.count,
        **{**tests, "wasserstein": wasserstein},
        "histogram": {
            "edges_deg": [degrees(edge) for edge in found.measured.edges],
            "measured_per_deg": [number(one / _DEGREE) for one in found.measured.density],
            "predicted_per_deg": [number(one / _DEGREE) for one in found.predicted.density],
        },
    }


def _directions(found: cycle_agreement.DirectionAgreement) -> Json:
    return {
        "predicted": [
            {
                "kind": one.kind,
                "centre_deg": _direction(one.centre),
                "predicted_peak_deg": _direction(one.predicted_mode),
                "measured_peak_deg": _direction(one.measured_mode),
                "difference_deg": degrees(one.difference),
                "p_value": None if one.p_value is None else number(one.p_value.value),
            }
            for one in found.matches
        ],
        "measured_peaks_deg": [_direction(one) for one in found.measured_modes],
    }


def _staircase(found: cycle_agreement.StaircaseAgreement) -> Json:
    return {
        "turns": _simulated(found.quantities["turns"], 1.0),
        "steps": _simulated(found.quantities["steps"], 1.0),
        "step_height_deg": _simulated(found.quantities["step_height"], _DEGREE),
        "residence_cycles": _simulated(found.quantities["residence"], 1.0),
        "theory": None if found.theory is None else comparison_report(found.theory, errors=False),
    }


def _simulated(found: cycle_agreement.SimulatedQuantity, scale: float) -> Json:
    names = ("measured", "predicted", "lower", "upper")
    scaled = {
        name: None if (value := getattr(found, name)) is None else number(scale * value)
        for name in names
    }
    return {**scaled, "p_value": None if found.p_value is None else number(found.p_value.value)}


def _p_value(found: PValue | None) -> Json | None:
    return (
        None
        if found is None
        else {"statistic": number(found.statistic), "p_value": number(found.value)}
    )


def _direction(radians: float | None) -> float | None:
    return None if radians is None else direction_deg(radians)
