# SPDX-License-Identifier: MIT OR Apache-2.0
"""The elastic law against its stored comparison, and against new coarse boundary and finite elements."""
import numpy as np
from stored import read_csv


def test_the_stored_errors_on_paraboloids_are_within_the_grids_own(elastic):
    rows = read_csv(elastic.compare.HERE / "paraboloids.csv")
    assert [row["ratio"] for row in rows] == list(elastic.compare.RATIOS)
    for row in rows:
        assert abs(row["force"]) < 5e-5 and abs(row["peak"]) < 1e-4
        assert max(abs(row["major"]), abs(row["minor"])) < 4e-4
        for name in ("force", "major", "minor", "peak"):
            assert abs(row[name]) < 1.5 * row[f"{name}_bar"] + 5e-6, (row["ratio"], name)


def test_the_law_of_now_has_the_stored_errors_on_a_coarse_grid(elastic):
    stored = {row["ratio"]: row for row in read_csv(elastic.compare.HERE / "paraboloids.csv")}
    ratio = 10.0
    shape = elastic.ellipsoid_pair.Shape((float(np.sqrt(ratio)), 1.0, 1.0))
    law = elastic.compare.Law(elastic.ellipsoid_pair.Pair("", shape, shape), 1e-3)
    found = law.differences(elastic.half_space.press(law.paraboloid, law.force, elastic.compare.MODULUS, law.half_widths(1.25), 32))
    for name, value in found.items():
        assert abs(value - stored[ratio][f"{name}_32"]) < 1e-7, name


def test_a_sphere_on_a_plane_is_sneddons_sphere(elastic):
    """I.N. Sneddon, Int. J. Engng Sci. 3 (1965) 47: penetration a artanh(a/R), force E* ((a^2 + R^2) artanh(a/R) - a R)."""
    rows = [row for row in read_csv(elastic.compare.HERE / "exact_shapes.csv") if row["pair"] == "sphere on a plane"]
    radius = np.linspace(1e-3, 0.75, 20_000)
    depth = radius * np.arctanh(radius)
    force = (radius**2 + 1) * np.arctanh(radius) - radius
    for row in rows:
        # The stored overlap is the law's at that force, the error is taken at Sneddon's.
        exact = np.interp(4.0 / 3.0 * row["overlap"] ** 1.5, force, depth)
        assert abs((exact / row["overlap"]) ** 1.5 - 1 - row["force"]) < 1.5 * row["force_bar"] + 1e-6, row


def test_the_gap_of_a_turned_ellipsoid_lies_on_its_surface(elastic):
    turned = elastic.ellipsoid_pair.Shape((2.0, 1.0, 0.7), (np.cos(0.3), 0.0, np.sin(0.3), 0.0))
    witness, form = turned.witness(), np.linalg.inv(turned.matrix())
    for x, y in [(0.2, 0.1), (-0.3, 0.25)]:
        point = witness + [x, y, -float(turned.depth(np.array(x), np.array(y)))]
        assert abs(point @ form @ point - 1) < 1e-12


def test_finite_spheres_as_stored_on_a_coarse_mesh(elastic):
    row = next(r for r in read_csv(elastic.compare.HERE / "finite_bodies.csv") if r["aspect"] == 1 and r["overlap"] == 1e-3)
    found = elastic.compare.finite_bodies((4, 8), (1.0,), (1e-3,))[0]
    for support in ("free", "held"):
        assert abs(found[support] - row[support]) < 1.5 * row[f"{support}_bar"] + 1e-9
        assert -0.025 < row[support] < -0.008


def test_finite_bodies_tend_to_half_spaces_as_the_root_of_the_overlap(elastic):
    rows = {r["overlap"]: r for r in read_csv(elastic.compare.HERE / "finite_bodies.csv") if r["aspect"] == 1}
    for support in ("free", "held"):
        ratio = rows[1e-2][support] / rows[1e-4][support]
        assert 8 < ratio < 17, (support, ratio)
