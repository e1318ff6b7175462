# SPDX-License-Identifier: MIT OR Apache-2.0
"""The stored scenes of thousands of grains: the balance of energies, and the discharge of the hopper."""
from pathlib import Path

import numpy as np
from stored import read_csv

STORED = Path(__file__).resolve().parent.parent / "scenes"


def test_the_energies_of_drum_and_hopper_add_up():
    drums = read_csv(STORED / "drum.csv")
    names = {row["run"] for row in drums}
    assert names == {"one rank", "four ranks", "restarted"}
    for rows in [*([row for row in drums if row["run"] == name] for name in names), read_csv(STORED / "hopper.csv")]:
        last = rows[-1]
        assert last["grains"] == rows[0]["grains"] >= 4900
        assert abs(last["left_over"]) < 1e-3 * (last["viscosity"] + last["friction"])


def test_the_restarted_drum_is_the_whole_one_until_it_is_restarted():
    drums = read_csv(STORED / "drum.csv")
    whole, restarted = ([row for row in drums if row["run"] == name] for name in ("one rank", "restarted"))
    assert [row["step"] for row in whole] == [row["step"] for row in restarted]
    half = len(whole) // 2
    assert [row["work"] for row in whole[:half]] == [row["work"] for row in restarted[:half]]


def test_the_hopper_discharges_at_the_same_rate_in_both_engines():
    times = []
    for file in ("hopper.csv", "hopper_liggghts.csv"):
        rows = read_csv(STORED / file)
        assert rows[-1]["above"] < 0.02 * rows[0]["above"]
        passed = [1 - row["above"] / rows[0]["above"] for row in rows]
        steps = [row["step"] for row in rows]
        times.append(np.diff(np.interp([0.1, 0.5], passed, steps))[0])
    # Thousands of grains, of which those between a tenth and a half count.
    assert abs(times[0] / times[1] - 1) < 0.05
