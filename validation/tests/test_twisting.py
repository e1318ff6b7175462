# SPDX-License-Identifier: MIT OR Apache-2.0
"""Twisting about the normal: the boundary elements against closed forms, and the law against its stored comparison."""
import numpy as np
import pytest
from half_space_kernels import Rectangles, Shear
from scipy.special import ellipe, ellipk
from stored import read_csv


def test_the_boundary_elements_are_lubkins_circle_and_its_cycle(tangential):
    twisting = tangential.twisting
    scene, steps, count = tangential.grains.Scene(1.0, 0.3, 0.0), 12, 26
    relative, closed = twisting.twists(steps)["reversed at 1"]
    turned = twisting.Turned(scene, relative)
    found = turned.full_problem(count)
    exact = -twisting.masing(relative[:, 1], steps)
    # 0.005 on this grid, 0.0015 on 50 rectangles and 24 steps.
    assert np.abs(found[:, 2] - exact).max() < 0.008
    assert np.abs(found[:, :2]).max() < 1e-12
    with_forces = np.stack([0 * exact, 0 * exact, exact], axis=1)
    assert abs(turned.dissipated(found, closed) / turned.dissipated(with_forces, closed) - 1) < 0.04


def test_lubkins_curve_begins_with_the_stiffness_and_ends_with_the_torque_of_sliding(tangential):
    lubkin = tangential.twisting.lubkin
    small = np.array([1e-4, 1e-3])
    assert np.abs(lubkin(small) / small - 1).max() < 1e-3
    assert abs(lubkin(np.array([30.0]))[0] - 1) < 1e-6
    # Where a circle of half the radius sticks, c = a/2: by Gauss' quadrature, with I = K - E.
    nodes, weights = np.polynomial.legendre.leggauss(60)
    inner = ellipk(0.75) - ellipe(0.75)
    # s = 1 - t^2/2 from the rim to c = 1/2.
    way = 0.5 * (nodes + 1)
    radius = 1 - 0.5 * way**2
    profile = ellipk(1 - radius**2) - ellipe(1 - radius**2)
    outer = np.sum(0.5 * weights * way * radius**2 * profile)
    unit = 3 * np.pi**2 / 64
    assert abs(lubkin(np.array([inner / unit]))[0] - (inner / 8 + 3 * outer) / unit) < 1e-5


@pytest.mark.parametrize("ratio", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_without_slip_the_closed_form_turns_an_ellipse_as_a_rigid_surface(tangential, ratio, poisson):
    a, b, shear_modulus = 1.0, 1.0 / ratio, 0.7
    linear = tangential.twisting.without_slip((a, b), shear_modulus, poisson)
    rectangles = Rectangles((a, b), 64)

    def averaged(factor_x: float, factor_y: float) -> np.ndarray:
        def traction(x: np.ndarray, y: np.ndarray) -> np.ndarray:
            inside = 1 - (x / a) ** 2 - (y / b) ** 2
            return np.where(inside > 0, (factor_x * x + factor_y * y) / np.sqrt(np.maximum(inside, 1e-12)), 0.0)

        return rectangles.averaged(traction, parts=24)

    traction = np.stack([averaged(0.0, -linear.alpha / b**2), averaged(linear.beta / a**2, 0.0)])
    x, y = np.broadcast_arrays(rectangles.x, rectangles.y)
    within = (x / a) ** 2 + (y / b) ** 2 < 0.5
    moved = Shear(rectangles, shear_modulus, poisson)(traction)
    # A stiffness that was wrong by a hundredth would show; the rectangles at the rim are wrong by less.
    assert np.abs(moved - np.stack([-y, x]))[:, within].max() < 0.004
    torque = float(np.sum(x * traction[1] - y * traction[0])) * rectangles.area
    assert abs(torque / linear.stiffness - 1) < 0.006


def test_the_stiffness_without_slip_on_the_circle_is_that_of_reissner_and_sagoci(tangential):
    for poisson in (0.0, 0.3, 0.5):
        assert abs(tangential.twisting.without_slip((1.0, 1.0), 1.0, poisson).stiffness / (8 / 3) - 1) < 1e-12
        assert abs(tangential.twisting.without_slip((1.0, 0.9999), 1.0, poisson).stiffness / (8 / 3) - 1) < 2e-4


@pytest.mark.parametrize("ratio", [1.0, 1.3, 4.0])
def test_in_the_words_of_the_law_it_is_the_same_in_any_basis(tangential, ratio):
    a, b, shear_modulus, poisson = 1.2, 1.2 / ratio, 0.7, 0.3
    square = 1 - (b / a) ** 2
    first, second = ellipk(square), ellipe(square)
    d = (first - second) / square if ratio > 1 else np.pi / 4
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    squares = turn @ np.diag([a**2, b**2]) @ turn.T
    beta = turn @ np.diag([1 - d / first, d / first]) @ turn.T
    normal_stiffness = np.pi * shear_modulus * a / ((1 - poisson) * first)
    found = tangential.twisting.in_the_words_of_the_law(squares, beta, normal_stiffness, 1 / (1 - poisson), poisson / (1 - poisson))
    assert abs(found / tangential.twisting.without_slip((a, b), shear_modulus, poisson).stiffness - 1) < 1e-9


def test_the_bed_with_one_limit_is_the_closed_forms_in_pure_twist_and_displacement(tangential):
    twisting = tangential.twisting
    steps = np.linspace(0.0, 4.0, 81)
    pure = twisting.bed_with_one_limit(np.stack([0 * steps, steps], axis=1), 8)
    assert np.abs(pure[:, 1] - twisting.lubkin(steps)).max() < 0.03 and not pure[:, 0].any()
    pure = twisting.bed_with_one_limit(np.stack([steps, 0 * steps], axis=1), 8)
    assert np.abs(pure[:, 0] - (1 - np.maximum(0.0, 1 - steps) ** 1.5)).max() < 0.015 and not pure[:, 1].any()


def test_at_full_sliding_torque_and_force_are_together_near_an_ellipse(tangential):
    twisting = tangential.twisting
    for ratio in (1.0, 2.5, 8.0):
        # The closed form of the torque by the quadrature.
        assert abs(twisting.sliding_together((1.0, 1.0 / ratio), 30.0, 1e-6)[1] - 1) < 1e-4
        for direction in (0.0, 45.0, 90.0):
            for centre in (0.1, 0.3, 0.6, 1.0, 3.0):
                assert 0.88 < np.hypot(*twisting.sliding_together((1.0, 1.0 / ratio), direction, centre)) < 1.05


def test_the_law_of_now_gives_the_stored_torques(tangential):
    twisting, folder = tangential.twisting, tangential.compare.HERE
    steps = tangential.compare.TWIST_FINE.steps
    curves = read_csv(folder / "twisting_curves.csv")
    for file, of in (("twisting", twisting.twists), ("twisting_and_sliding", twisting.both)):
        for row in read_csv(folder / f"{file}.csv"):
            scene = tangential.grains.Scene(row["aspect"], row["poisson"], row["direction"])
            rows = [curve for curve in curves if all(curve[key] == row[key] for key in (*scene._fields, "path"))]
            relative, closed = of(steps)[row["path"]]
            turned = twisting.Turned(scene, relative)
            full, stored = (np.array([[curve[f"{which}_{part}"] for part in ("x", "y", "torque")] for curve in rows]) for which in ("full", "law"))
            law = turned.by_law(8)
            # Nine digits of what may be above 1.
            assert np.abs(law - stored).max() < 6e-9, row
            for key, value in twisting.errors(law, full, steps, alone=file == "twisting").items():
                assert value == pytest.approx(row[key], rel=1e-8, abs=1.2e-8), (key, row)
            if closed >= 0:
                assert abs(turned.dissipated(law, closed) - row["dissipated_by_law"]) < 1e-7, row


def test_the_law_of_now_has_the_stored_constants(tangential):
    for row in read_csv(tangential.compare.HERE / "twisting_constants.csv"):
        stiffness, limit = tangential.twisting.constants_of_the_law(tangential.grains.Scene(row["aspect"], row["poisson"], 0.0))
        assert stiffness == pytest.approx(row["stiffness_by_law"], rel=1e-8)
        assert limit == pytest.approx(row["limit_by_law"], rel=1e-8)
        # The stiffness of the boundary elements is the closed form's, whatever the law's is.
        assert abs(row["stiffness_by_elements"] - 1) < 0.005
