# SPDX-License-Identifier: MIT OR Apache-2.0
"""The viscous normal law against its stored comparison, and against a new computation of the exact memory."""
import numpy as np
import pytest
from stored import read_csv


@pytest.mark.parametrize("poisson", [0.0, 0.1, 0.3, 0.45])
@pytest.mark.parametrize("viscosities", [(1.0, 0.0), (0.0, 1.0), (0.7, 0.2)])
def test_the_energy_closure_is_the_first_order_of_the_solids_own_modulus(viscoelastic, poisson, viscosities):
    solid = viscoelastic.kelvin_voigt.Solid(1.0, poisson, *viscosities)
    shear, bulk = viscosities
    energy = (2 / 3 * shear * (1 - poisson + poisson**2) + bulk * (1 - 2 * poisson) ** 2) / (1 - poisson) ** 2 * (1 - poisson**2)
    assert abs(solid.first_order_time() / energy - 1) < 1e-13


def test_the_exact_memory_of_proportional_viscosity_is_the_law(viscoelastic):
    """One relaxation time: E*(s) = E* (1 + A s), so first order is all there is, Ting's receding contact included."""
    rows = viscoelastic.compare.impacts((0.3,), (0.3,), 150, ("shear alone", "proportional"))
    for row in rows:
        if row["viscosity"] == "proportional" and row["law"] in ("energy", "surface", "brilliantov"):
            assert row["force_error_loading"] < 1e-6 and row["force_error_receding"] < 1e-3
            assert abs(row["restitution"] - row["restitution_of_law"]) < 3e-4
        if row["viscosity"] == "shear alone" and row["law"] == "energy":
            stored = next(
                r
                for r in read_csv(viscoelastic.compare.HERE / "impacts.csv")
                if (r["poisson"], r["viscosity"], r["law"], r["rate"]) == (0.3, "shear alone", "energy", 0.3)
            )
            for name in ("restitution", "restitution_of_law"):
                assert abs(row[name] - stored[name]) < 1e-3


def test_boundary_elements_that_march_in_time_agree_with_the_exact_memory(viscoelastic):
    rows = viscoelastic.compare.marched((4,), 12, 12)
    late = [row for row in rows if row["poisson"] == 0.3 and 0.3 < row["time"] < 0.95]
    assert max(abs(row["exact_memory"] - row["boundary_elements"]) for row in late) < 0.03


def test_the_stored_march_agrees_to_one_per_cent(viscoelastic):
    rows = read_csv(viscoelastic.compare.HERE / "boundary_elements.csv")
    assert {row["ratio"] for row in rows} == {1, 4, 16}
    assert max(abs(row["exact_memory"] - row["boundary_elements"]) for row in rows) < 0.01


def test_the_stored_errors_say_what_the_report_says(viscoelastic):
    rows = read_csv(viscoelastic.compare.HERE / "impacts.csv")
    for row in rows:
        if row["rate"] == 0.01 and row["law"] == "energy":
            assert max(row["force_error_loading"], row["force_error_receding"]) < 3e-3
            if row["viscosity"] != "bulk alone":
                assert abs((1 - row["restitution_of_law"]) / (1 - row["restitution"]) - 1) < 3e-3
        # Below 0.01 of tau_m v/depth first order holds, whatever the viscosities.
        if row["memory"] < 0.01 and row["law"] == "energy":
            assert max(row["force_error_loading"], row["force_error_receding"]) < 0.01, row


def test_memory_is_better_than_first_order_wherever_that_errs_by_one_per_cent(viscoelastic):
    rows = read_csv(viscoelastic.compare.HERE / "impacts.csv")
    of = {(r["poisson"], r["viscosity"], r["rate"], r["law"]): r for r in rows}

    def errors(row):
        return (
            row["force_error_loading"],
            row["force_error_receding"],
            abs(row["restitution_of_law"] - row["restitution"]),
            abs(row["duration_of_law"] / row["duration"] - 1),
        )

    count = 0
    for (poisson, viscosity, rate, law), row in of.items():
        if law != "memory":
            continue
        assert row["force_error_loading"] < 1e-3 and row["force_error_receding"] < 0.02, row
        for first, memory in zip(errors(of[poisson, viscosity, rate, "energy"]), errors(row)):
            if first > 0.01:
                count += 1
                assert memory < first, row
    assert count > 60


def test_the_memory_of_now(viscoelastic):
    """One impact with one relaxing part, one with three, coarsely."""
    rows = viscoelastic.compare.impacts((0.3,), (0.3,), 100, ("bulk alone",))
    row = next(r for r in rows if r["law"] == "memory")
    assert row["force_error_loading"] < 1e-2 and row["force_error_receding"] < 0.02
    assert abs(row["restitution"] - row["restitution_of_law"]) < 0.01
    rows = viscoelastic.compare.impacts_of_two_solids((0.3,), 100, ("both in shear and bulk",))
    first, memory = ({r["law"]: r for r in rows}[law] for law in ("energy", "memory"))
    assert memory["force_error"] < 0.01 < first["force_error"]
