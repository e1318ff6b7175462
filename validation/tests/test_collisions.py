# SPDX-License-Identifier: MIT OR Apache-2.0
"""Collisions by finite elements: the elements against closed forms and other elements, the stored results against present ones."""
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import spherical_jn
from stored import read_csv


def _rows(compare, name="collisions.csv"):
    return read_csv(compare.HERE / name)


def test_a_free_sphere_vibrates_as_lamb_has_it(collisions):
    """The torsional vibrations of order 2, x j_2'(x) = j_2(x), are the lowest of all."""
    x = brentq(lambda k: k * spherical_jn(2, k, derivative=True) - spherical_jn(2, k), 2.0, 3.0)
    shear_speed = np.sqrt(0.5 / 1.3)
    body = collisions.free_body.free_body(np.eye(3), 0.3, (0.1, 0.1), collisions.compare.GRIDS["coarse"], 8)
    # Two of its five forms keep the plane of symmetry.
    assert np.abs(body.frequencies[:2] / (x * shear_speed) - 1).max() < 0.015


@pytest.mark.parametrize("overlap", [1e-4, 1e-2])
def test_at_rest_the_elements_agree_with_axisymmetric_ones(collisions, overlap):
    compare = collisions.compare
    width = compare.WIDTH * float(np.sqrt(0.5 * overlap))
    body = collisions.free_body.free_body(np.eye(3), compare.POISSON, (width, width), compare.GRIDS["coarse"], 10)
    force = collisions.two_bodies.Pair(body, body, (np.eye(3), np.eye(3))).pressed(overlap)
    # Hertz.
    error = 4 / 3 * 0.5 / (1 - compare.POISSON**2) * np.sqrt(0.5) * overlap**1.5 / force - 1
    stored = next(
        row["free"] for row in read_csv(compare.HERE.parent / "elastic_contact" / "finite_bodies.csv") if (row["aspect"], row["overlap"]) == (1, overlap)
    )
    assert abs(error - stored) < 0.01


def test_a_coarse_collision_of_now_is_the_stored_one(collisions):
    compare = collisions.compare
    pose = next(pose for pose in compare.POSES if pose.name == "tip to tip")
    only = ("normal, viscous", "63 degrees")
    rows, _ = compare.collided(pose, 0.003, "coarse", only=only)
    stored = {row["impact"]: row for row in _rows(compare) if (row["pose"], row["speed"], row["grid"]) == ("tip to tip", 0.003, "coarse")}
    assert {row["impact"] for row in rows} == set(only)
    for row in rows:
        for name in ("peak_force", "duration", "restitution", "velocity_x", "velocity_z", "spin_lower", "vibration", "friction", "viscosity"):
            assert abs(row[name] - stored[row["impact"]][name]) < 2e-4 * (1 + abs(row[name])), (row["impact"], name)


def test_the_inertia_of_every_node_gives_the_rebound_of_the_reduced_body(collisions):
    compare = collisions.compare
    pose = next(pose for pose in compare.POSES if pose.name == "side by side")
    of = compare.scale(pose, 0.01)
    widths = tuple(compare.WIDTH * width for width in of.half_widths)
    found, _ = collisions.whole_mesh.against_a_plane(
        compare.matrices(pose.bodies())[0], compare.POISSON, widths, compare.GRIDS["coarse"], 0.005, of.duration, 200
    )
    stored = next(
        row["restitution"] for row in _rows(compare) if (row["pose"], row["speed"], row["impact"], row["grid"]) == (pose.name, 0.01, "normal", "coarse")
    )
    assert abs(found - stored) < 0.005
    # It is far from an elastic impact.
    assert stored < 0.9


def test_the_stored_energies_add_up(collisions):
    for row in _rows(collisions.compare):
        assert abs(row["kept"] + row["vibration"] + row["friction"] + row["viscosity"] + row["rest"] - 1) < 1e-6
        assert abs(row["rest"]) < 0.01, (row["pose"], row["speed"], row["impact"], row["grid"])


def test_the_law_of_now_gives_the_stored_rebounds(collisions):
    compare = collisions.compare
    rows = [row for row in _rows(compare, "laws.csv") if (row["law"], row["speed"], row["impact"]) == ("NFD+TFD", 0.003, "45 degrees")]
    assert len(rows) == 4
    for row in rows:
        pose = next(pose for pose in compare.POSES if pose.name == row["pose"])
        impact = compare.impacts(row["speed"])[row["impact"]]
        found, _ = compare.by_law(pose, impact, compare.words(impact))
        for name in ("peak_force", "restitution", "velocity_x", "velocity_z", "spin_lower", "spin_upper"):
            assert abs(found[name] - row[name]) < 1e-6 * (1 + abs(row[name])), (row["pose"], row["impact"], name)


def test_our_law_through_the_engines_ends_as_the_stored_rebounds(collisions):
    """What came out of LAMMPS and LIGGGHTS, as it is stored. tests/lammps and tests/liggghts run one of these collisions."""
    compare, engines = collisions.compare, collisions.engines
    stored = {(row["pose"], row["speed"], row["impact"]): row for row in _rows(compare, "laws.csv") if row["law"] == "NFD+TFD"}
    rows = _rows(compare, "engines.csv")
    for control, tolerance in zip(engines.CONTROLS, (1e-7, 1e-4)):
        found = {(row["pose"], row["speed"], row["impact"]): row for row in rows if row["law"] == control}
        assert found.keys() == stored.keys(), control
        for key, row in found.items():
            for name in ("restitution", "velocity_x", "velocity_z", "spin_lower", "spin_upper", "kept"):
                assert abs(row[name] - stored[key][name]) < tolerance, (control, key, name)


def test_without_engines_nothing_is_written_and_it_says_so(collisions, monkeypatch, capsys):
    for name in ("ELLGRAN_LAMMPS", "ELLGRAN_LAMMPS_PLUGIN", "ELLGRAN_LIGGGHTS"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(collisions.engines, "write_csv", lambda *_: pytest.fail("written"))
    assert collisions.engines.make([], []) == {}
    said = capsys.readouterr().out
    assert "NOT RUN THROUGH THE ENGINES" in said
    for label in collisions.engines.LAWS:
        assert f"{label}: " in said


def test_lammps_spheres_are_our_law_in_their_words(collisions):
    compare = collisions.compare
    rows = [row for row in _rows(compare, "engines.csv") if (row["law"], row["impact"]) == ("LAMMPS granular, spheres", "normal, viscous")]
    assert len(rows) == 12
    for row in rows:
        pose = next(pose for pose in compare.POSES if pose.name == row["pose"])
        law = compare.words(compare.impacts(row["speed"])["normal, viscous"])
        found, _ = compare.by_law(pose, compare.impacts(row["speed"])["normal, viscous"], f"{law} unloading first_order", True)
        assert abs(found["restitution"] - row["restitution"]) < 1e-5, (row["pose"], row["speed"])
