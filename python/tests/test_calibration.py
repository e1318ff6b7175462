# SPDX-License-Identifier: MIT OR Apache-2.0
"""Restitution against what is known in closed form, viscosities from it, and the time step."""
import re
from math import exp, gamma, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

import ellgran
from scenes import two_spheres

SPEEDS = np.array([0.01, 0.1, 1.0])


@pytest.mark.parametrize("cut", ["limit_force yes", "limit_force no"])
@pytest.mark.parametrize("e", [0.3, 0.7, 0.95])
def test_damping_by_restitution_gives_that_restitution_at_any_speed(e, cut):
    found = ellgran.restitution(f"hertz 1e7 0.3 damping restitution {e} {cut}", two_spheres(), SPEEDS)
    assert found == pytest.approx(e, abs=5e-6 if cut.endswith("yes") else 1e-4)


def test_an_elastic_impact_gives_all_back():
    assert ellgran.restitution("hertz 1e7 0.3", two_spheres(), SPEEDS) == pytest.approx(1.0, abs=1e-6)
    assert ellgran.restitution("lsd 1e3 0", two_spheres(), SPEEDS) == pytest.approx(1.0, abs=1e-6)


def test_the_linear_law_is_an_oscillator():
    spheres = two_spheres()
    k, c, m = 1e3, 2e-2, spheres.masses[0] / 2
    rate, frequency = c / (2 * m), sqrt(k / m - (c / (2 * m)) ** 2)
    found = ellgran.restitution(f"lsd {k} {c} limit_force no", spheres, SPEEDS)
    assert found == pytest.approx(exp(-pi * rate / frequency), abs=2e-5)


def test_small_viscosity_loses_what_the_series_says():
    """e = 1 - C x + 3/5 (C x)^2 with x = 3/2 A_n (k/m)^(2/5) v^(1/5): T. Schwager, T. Poeschel, Phys. Rev. E 57 (1998) 650;
    R. Ramirez et al., Phys. Rev. E 60 (1999) 4465."""
    spheres = two_spheres()
    law = "nfd 1e7 0.3 10 10 unloading first_order limit_force no"
    mixed = ellgran.Laws(law).mixture()
    k, m = 4 / 3 * mixed.effective_modulus * sqrt(0.5e-3), spheres.masses[0] / 2
    constant = 0.8 * 1.25**0.6 * gamma(0.6) * gamma(1.5) / gamma(2.1)
    assert constant == pytest.approx(1.15344, abs=1e-5)
    y = constant * 1.5 * mixed.normal_relaxation_time * (k / m) ** 0.4 * SPEEDS**0.2
    assert 0.005 < y.min() and y.max() < 0.1
    found = ellgran.restitution(law, spheres, SPEEDS)
    assert np.abs(found - (1 - y + 0.6 * y**2)).max() < 0.5 * y.max() ** 3


def test_restitution_falls_with_speed_and_converges_with_the_steps():
    law, spheres = "nfd 1e7 0.3 100 100", two_spheres()
    coarse, fine = (ellgran.restitution(law, spheres, SPEEDS, steps=n) for n in (200, 1600))
    assert (np.diff(fine) < 0).all() and fine[0] < 1
    assert np.abs(coarse - fine).max() < 2e-5


def test_bounces_of_the_engine():
    """The tutorial's table is what LAMMPS printed for spheres on a plane."""
    page = (Path(__file__).parents[2] / "docs" / "tutorials" / "calibrate.md").read_text()
    rows = re.findall(r"^\| `((?:nfd|hertz) [^`]+)` \|([\d. |]+)\|$", page, re.M)
    assert len(rows) >= 4
    plate = 1e5 * 3e-3
    impact = ellgran.Bodies([[0, 0, -plate], [0, 0, 3e-3]], [[plate] * 3, [3e-3] * 3], density=2500)
    impact.masses = [np.inf, impact.masses[1]]
    for words, numbers in rows:
        printed = [float(number) for number in numbers.split("|")]
        assert ellgran.restitution(words, impact, [0.1, 0.3, 1.0, 3.0]) == pytest.approx(printed, abs=1.5e-4), words


def test_masses_pairs_and_walls():
    law, spheres = "nfd 1e7 0.3 100 100", two_spheres()
    wall = two_spheres()
    wall.masses = [np.inf, wall.masses[1]]
    # The effective mass is twice that of two spheres: as a heavier pair.
    heavier = two_spheres()
    heavier.masses = 2 * heavier.masses
    assert ellgran.restitution(law, wall, 0.1) == pytest.approx(ellgran.restitution(law, heavier, 0.1), abs=1e-9)
    several = ellgran.restitution(law, ellgran.Bodies.joined(spheres, heavier), 0.1, [[0, 1], [2, 3]])
    assert several == pytest.approx([ellgran.restitution(law, s, 0.1) for s in (spheres, heavier)], abs=1e-12)
    askew = ellgran.Bodies([[0, 0, 0], [0.4e-3, 0, 1.9e-3]], [2e-3, 1e-3, 1e-3], density=2500)
    with pytest.raises(ValueError, match="use collide"):
        ellgran.restitution(law, askew, 0.1)
    fixed = two_spheres(masses=None)
    fixed.masses = [np.inf, np.inf]
    with pytest.raises(ValueError, match="infinite mass"):
        ellgran.restitution(law, fixed, 0.1)


@pytest.mark.parametrize("target, ratio", [(0.2, 1.0), (0.7, 0.0), (0.98, 3.0)])
def test_viscosities_from_a_restitution_and_back(target, ratio):
    grains = ellgran.Bodies([[0, 0, 0], [0, 0, 2e-3]], [2e-3, 1e-3, 1e-3], density=2500)
    law = ellgran.with_restitution("nfd 3e6 0.3 0 0 tangential tfd 0.5", target, 0.3, grains, bulk_over_shear=ratio)
    assert ellgran.restitution(law, grains, 0.3) == pytest.approx(target, abs=2e-6)
    assert law.bulk_viscosity == pytest.approx(ratio * law.shear_viscosity, rel=1e-12)
    assert law.words.startswith("nfd 3e6 0.3 ") and law.words.endswith(" tangential tfd 0.5")


def test_what_cannot_be_calibrated_is_said():
    spheres = two_spheres()
    for target in (0.0, 1.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="target"):
            ellgran.with_restitution("nfd 1e7 0.3 1 1", target, 0.1, spheres)
    with pytest.raises(ValueError, match="nfd E nu eta1 eta2"):
        ellgran.with_restitution("hertz 1e7 0.3", 0.5, 0.1, spheres)
    with pytest.raises(ValueError, match="2 bodies"):
        ellgran.with_restitution("nfd 1e7 0.3 1 1", 0.5, 0.1, spheres[:1])


def test_step_advice_is_that_of_the_stiffest_contact():
    laws = ellgran.Laws("hertz 1e7 0.3", "hertz 2e7 0.3")
    grains = ellgran.Bodies(
        np.zeros((3, 3)), [[2e-3, 1e-3, 1e-3], [1e-3, 3e-3, 2e-3], [1e-3, 1e-3, 1e-3]], density=2500, types=[1, 2, 1]
    )
    advice = ellgran.step_advice(laws, grains, 0.5)
    # Two grains of type 2 would be stiffer, but they are heavier: the collision of two of the first type is as the C call has it.
    first = ellgran.Bodies([[0, 0, 0], [0, 0, 2e-3 * 0.99]], [2e-3, 1e-3, 1e-3], density=2500)
    time, _ = ellgran.elastic_collisions("hertz 1e7 0.3", first, [[0, 1]], 0.5)
    assert 0.0 < advice.collision <= time[0]
    assert advice.rayleigh == pytest.approx(ellgran.rayleigh_times(laws, grains).min(), rel=1e-15)
    assert 0.0 < advice.step <= min(advice.collision / 50, advice.rayleigh / 5, advice.critical)
    faster = ellgran.step_advice(laws, grains, 5.0)
    assert faster.collision < advice.collision and faster.penetration > advice.penetration
    with pytest.raises(ValueError, match="speed = 0"):
        ellgran.step_advice(laws, grains, 0.0)
    with pytest.raises(ValueError, match="at least one grain"):
        ellgran.step_advice(laws, grains[:0], 1.0)
