"""Measured values go to other processes and come back the same."""

import pickle

import numpy as np

from cyclemap.evidence import read_theta0_pairs


def test_measured_pairs_come_back_with_what_was_left_out(tmp_path) -> None:
    file = tmp_path / "staircase.csv"
    rows = ("0,1,1,2,first", "1,3,3,1,", "2,4,4,,")
    file.write_text("rep,theta0_accum_deg,theta0_mod360_deg,dtheta_to_next_deg,flag\n" + "\n".join(rows) + "\n")
    pairs = read_theta0_pairs(file)
    copy = pickle.loads(pickle.dumps(pairs))
    assert copy.dropped == pairs.dropped == {"first": 1}
    assert np.array_equal(copy.theta, pairs.theta) and np.array_equal(copy.path, pairs.path)
