# SPDX-License-Identifier: MIT OR Apache-2.0
"""The stored scenes of thousands of grains: the balance of energies, and the discharge of the hopper."""
from pathlib import Path

import numpy as np
from stored import read_csv

STORED = Path(__file__).resolve().parent.parent / "scenes"


def test_the_energies_of_drum_and_hopper_add_up():
    for scene in ("drum", "hopper"):
        stored = read_csv(STORED / f"{scene}.csv")
        names = {row["run"] for row in stored}
        assert names == {"one rank", "four ranks", "restarted"}
        for name in names:
            rows = [row for row in stored if row["run"] == name]
            last = rows[-1]
            assert last["grains"] == rows[0]["grains"] >= 4900
            assert abs(last["left_over"]) < 1e-3 * (last["viscosity"] + last["friction"])


def test_restarted_scenes_are_the_whole_ones_until_they_are_restarted():
    for scene, half in (("drum", 0.45), ("hopper", 0.6)):
        stored = read_csv(STORED / f"{scene}.csv")
        whole, restarted = ([row for row in stored if row["run"] == name] for name in ("one rank", "restarted"))
        assert [row["step"] for row in whole] == [row["step"] for row in restarted]
        count = round(half * len(whole))
        assert [row["friction"] for row in whole[:count]] == [row["friction"] for row in restarted[:count]]


def test_the_hopper_discharges_at_the_same_rate_on_any_ranks():
    stored = read_csv(STORED / "hopper.csv")
    rates = []
    for name in ("one rank", "four ranks", "restarted"):
        rows = [row for row in stored if row["run"] == name]
        passed = [1 - row["above"] / rows[0]["above"] for row in rows]
        first, last = np.interp([0.1, 0.5], passed, [row["step"] for row in rows])
        rates.append(1 / (last - first))
    assert max(rates) / min(rates) < 1.05


def test_the_hopper_discharges_at_the_same_rate_in_both_engines():
    times = []
    for file in ("hopper.csv", "hopper_liggghts.csv"):
        rows = [row for row in read_csv(STORED / file) if row.get("run", "one rank") == "one rank"]
        assert rows[-1]["above"] < 0.02 * rows[0]["above"]
        passed = [1 - row["above"] / rows[0]["above"] for row in rows]
        steps = [row["step"] for row in rows]
        times.append(np.diff(np.interp([0.1, 0.5], passed, steps))[0])
    # Thousands of grains, of which those between a tenth and a half count.
    assert abs(times[0] / times[1] - 1) < 0.05
