"""`cyclemap staircase` and `fingerprint` from outside: their JSON, pictures and words."""

import math

import pytest

ZONE_KEYS = {"centre_deg", "arc_deg", "kind", "residence_cycles", "log10_residence_cycles"}
RUN_KEYS = {"seed", "cycles", "climb_deg", "steps", "heights_deg", "dwells"}
FIVE = "turn_deg offset_amplitude_deg offset_phase_deg ellipse_amplitude_deg ellipse_phase_deg"
BOW = ("bow_amplitude_deg", "bow_phase_deg", "bow_remainder_deg")


@pytest.mark.slow
def test_json_tells_prediction_run_and_data_and_nothing_else(
    here, saved_report, theta0_file, sine_path
) -> None:
    """Of a ring 9.8 mm from the centre, not 15: plywood's fixed points have met and gone."""
    theta0_file(here / "measured.csv", sine_path(0.03, 1_000))
    ghost = "staircase plywood --set hitch_x_mm=-6.9 --set hitch_y_mm=6.9"
    line = f"{ghost} --data measured.csv --out pictures"
    report = saved_report("pictures/staircase_plywood", line)
    assert list(report) == ["noise_deg", "prediction", "run", "uncertainty", "data"]
    (zone,) = report["prediction"]["zones"]
    assert set(zone) == ZONE_KEYS and zone["kind"] == "ghost"
    assert report["prediction"]["step_deg"] == pytest.approx(360.0)
    run = report["run"]
    assert set(run) == RUN_KEYS and run["cycles"] == 1_000
    assert len(run["heights_deg"]) == run["steps"] == len(run["dwells"]) - 1
    assert set(report["data"]) == RUN_KEYS - {"seed"} | {"fitted", "comparison", "problem"}
    assert report["data"]["fitted"]["noise_deg"] == pytest.approx(math.degrees(0.03), rel=0.1)


@pytest.mark.slow
def test_json_of_a_material_tells_the_protocols_numbers_and_where_the_full_map_locks(
    saved_report,
) -> None:
    report = saved_report("out/fingerprint_plywood", "fingerprint plywood --check --margin")
    ring = next(margin for margin in report["margins"] if margin["key"] == "hitch_x_mm")["above"]
    assert (ring["kind"], ring["directions"]) == ("saddle-node", 0)
    assert abs(ring["value"] + 6.271374) < 1e-5 and ring["error"] < 1e-6
    numbers = [8.0022, 117.279, 129.478, 101.365, -111.061]
    assert [report[key] for key in FIVE.split()] == pytest.approx(numbers, abs=1e-3)
    turned = report["push"]["turn_deg"] + report["drag"]["turn_deg"]
    assert turned == pytest.approx(report["turn_deg"])
    prediction, full = report["prediction"], report["full_map"]["fixed_points"]
    assert (prediction["material"], prediction["verdict"]) == ("plywood", "locks")
    assert prediction["trusted"] is True
    assert [row["stable"] for row in prediction["directions"]] == [True, False]
    assert [point["theta_deg"] for point in full] == pytest.approx([63.168, 199.876], abs=2e-3)
    checks = report["full_map"]["checked"]
    for predicted, checked, point in zip(prediction["directions"], checks, full, strict=True):
        assert checked["full_deg"] == point["theta_deg"] and checked["within_error"]
        assert checked["miss_deg"] <= predicted["error_deg"]
    low, high = prediction["lock_in_scale_range"]
    assert low < prediction["lock_in_scale"] < high < 1.0


@pytest.mark.slow
def test_without_a_material_only_the_protocol_is_told_and_settings_change_it(
    here, report_of
) -> None:
    plain = report_of("fingerprint")
    assert set(plain) == {*FIVE.split(), *BOW, "push", "drag", "remainder_per_rad"}
    changes = "--set push_mm=50 --set mu_a=.26 --set mu_b=.24 --format svg"
    changed = report_of(f"fingerprint {changes}")
    assert changed["turn_deg"] == pytest.approx(-1.5527, abs=1e-3) != plain["turn_deg"]
    assert changed["prediction"]["ellipticity"] == pytest.approx(0.5 * math.log(0.26 / 0.24))
    assert changed["prediction"]["offset"] == 0.0
    names = {path.name for path in (here / "out").iterdir()}
    assert {"fingerprint_protocol.png", "fingerprint_isotropic_changed.svg"} < names
