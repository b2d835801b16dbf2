"""Bad use of any command: one line that names what was wrong, exit 2, and no file."""

import pytest

from cyclemap.cli.main import run

BAD_USES = [
    (["cycle", "plywod"], "did you mean 'plywood'"),
    (["cycle", "missing.toml"], "missing.toml"),
    (["cycle"], "give one material"),
    (["cycle", "plywood", "--material", "x.toml"], "give one material"),
    (["cycle", "plywood", "--set", "mu_aa=1"], "did you mean 'mu_a'"),
    (["cycle", "plywood", "--set", "mu_a"], "key=value"),
    (["cycle", "plywood", "--set", "mu_a=-0.1"], "mu_a"),
    (["cycle", "plywood", "--set", "mu_a=nan"], "mu_a"),
    (["cycle", "plywood", "--set", "mu_a=high"], "mu_a"),
    (["cycle", "plywood", "--set", "m0=0.9"], "energy"),
    (["cycle", "plywood", "--set", "pusher_mu=-1"], "pusher"),
    (["cycle", "plywood", "--set", "pusher_radius_mm=-5"], "pusher"),
    (["cycle", "plywood", "--set", "push_mm=-150"], "push"),
    (["cycle", "plywood", "--set", "fraction=1.5"], "fraction"),
    (["cycle", "plywood", "--set", "side=7"], "side"),
    (["cycle", "plywood", "--set", "side=0.5"], "side"),
    (["cycle", "plywood", "--set", "angle_deg=120"], "away"),
    (["cycle", "plywood", "--set", "hitch_x_mm=inf"], "hitch"),
    (["cycle", "plywood", "--set", "footprint=grid:0"], "grid"),
    (["cycle", "plywood", "--set", "footprint=round"], "footprint"),
    (["cycle", "plywood", "--set", "noise_deg=0"], "noise_deg"),
    (["cycle", "plywood", "--theta0-deg", "0,x"], "'x'"),
    (["cycle", "plywood", "--theta0-deg", "nan"], "'nan'"),
    (["cycle", "plywood", "--theta0-deg", "1e300"], "lost to rounding"),
    (["cycle", "plywood", "--theta0-deg", "1,,2"], "''"),
    (["cycle", "plywood", "--protocol", "none.toml"], "none.toml"),
    (["cycle", "plywood", "--speed", "3"], "--speed"),
    (["portrait", "plywood", "--data", "none.csv"], "none.csv"),
    (["portrait", "plywood", "--cycles", "0"], "--cycles"),
    (["portrait", "plywood", "--format", "gif"], "--format"),
    (["portait", "plywood"], "portait"),
    (["dynamics", "plywood", "--theta0-deg", "x"], "theta0-deg"),
    (["dynamics", "plywood", "--speed-mm-s", "0"], "speed must be positive"),
    (["dynamics", "plywood", "--set", "pusher_radius_mm=0"], "thicker rod"),
    (["dynamics"], "MATERIAL"),
    (["experiment", "plywood", "--batches", "0"], "batches"),
    (["experiment", "plywood", "--cycles", "0"], "cycles"),
    (["experiment", "plywood", "--speed-mm-s", "-1"], "speed must be positive"),
    (["staircase", "plywood", "--data", "nowhere.csv"], "nowhere.csv"),
    (["figures", "sadle-node"], "did you mean 'saddle-node'"),
    (["figures", "staircases", "--data", "nowhere"], "nowhere"),
    (["figures", "staircases", "--format", "gif"], "gif"),
    (["fingerprint", "--check"], "name a MATERIAL"),
    (["fingerprint", "plywood", "--set", "way_points_mm=[[0, 50]]"], "fixed in the world"),
    (["reset", "plywood", "--allow-tv", "0"], "--allow-tv"),
    (["reset", "plywood", "--within", "0"], "--within"),
    (["reset", "plywood", "--with", "wings"], "--with"),
    (["reset", "plywood", "--cycles", "1000000000"], "--cycles"),
    (["reset", "plywood", "--likely", "no-such-wood"], "unknown material 'no-such-wood'"),
    (["reset", "plywood", "--axes-percent", "100"], "--axes-percent"),
    (["reset", "plywood", "--robust"], "--robust"),
    (["simulate", "plywood", "--out", "made", "--wear-to", "plywod"], "did you mean 'plywood'"),
    (["simulate", "plywood", "--out", "made", "--noise-deg", "-1"], "-1.0 is not in the range"),
    (["simulate", "plywood", "--out", "made", "--pose-noise-mm", "nan"], "--pose-noise-mm': nan is in no range"),
    (["simulate", "plywood", "--out", "made", "--speed-mm-s", "0"], "0.0 is not in the range"),
    (["simulate", "plywood", "--out", "made", "--start-deg", "inf"], "start must be a finite number"),
    (["simulate", "plywood", "--out", "made", "--format", "csv"], "'csv' is not one of"),
]


@pytest.mark.parametrize(("arguments", "named"), BAD_USES, ids=lambda value: value if isinstance(value, str) else "")
def test_bad_use_exits_2_with_one_clear_line_and_writes_nothing(
    tmp_path, capsys, monkeypatch, arguments, named
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.startswith("error: ")
    assert shown.err.count("\n") == 1
    assert named in shown.err
    assert list(tmp_path.iterdir()) == []
