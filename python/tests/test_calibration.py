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
    page = calibration_page()
    rows = re.findall(r"^\| `((?:nfd|hertz) [^`]+)` \|([\d. |]+)\|$", page, re.M)
    assert len(rows) >= 4
    plate = 1e5 * 3e-3
    impact = ellgran.Bodies([[0, 0, -plate], [0, 0, 3e-3]], [[plate] * 3, [3e-3] * 3], density=2500)
    impact.masses = [np.inf, impact.masses[1]]
    for words, numbers in rows:
        printed = [float(number) for number in numbers.split("|")]
        assert ellgran.restitution(words, impact, [0.1, 0.3, 1.0, 3.0]) == pytest.approx(printed, abs=1.5e-4), words


def calibration_page():
    return (Path(__file__).parents[2] / "docs" / "tutorials" / "calibrate.md").read_text()


def numbers_of(page, pattern):
    """The numbers in the one place of the page that is like this, whatever the spaces."""
    found = list(re.finditer(pattern.replace(" ", r"\s+"), page))
    assert len(found) == 1, pattern
    return [float(number) for number in found[0].groups()]


NUMBER = r"([\d.]+(?:e\d+)?)"


def test_two_runs_find_a_viscosity():
    """Between two rows of the table the logarithm of the coefficient is as good as proportional to the viscosity."""
    page = calibration_page()
    at_1 = {
        float(eta): float(row.split("|")[2])
        for eta, row in re.findall(r"^\| `nfd 7e10 0\.22 (\S+) \S+` \|([\d. |]+)\|$", page, re.M)
    }
    e, speed, low, high, found = numbers_of(
        page, rf"for {NUMBER} at {NUMBER} m/s the rows of {NUMBER} and {NUMBER} give {NUMBER}, which its own row confirms"
    )
    assert speed == 1.0
    share = np.log(e / at_1[low]) / np.log(at_1[high] / at_1[low])
    # two digits
    assert low + share * (high - low) == pytest.approx(found, rel=0.025)
    assert at_1[found] == pytest.approx(e, abs=5e-4)
    assert np.log(at_1[high]) / np.log(at_1[low]) == pytest.approx(high / low, rel=0.05)


def test_softer_grains_take_longer_steps():
    page = calibration_page().replace("six", "6").replace("ten", "10")
    fewest, most = numbers_of(page, rf"a hundred times smaller the time step may be {NUMBER} to {NUMBER} times longer")
    hard, soft = "hertz 1e9 0.3", "hertz 1e7 0.3"
    times = [ellgran.elastic_collisions(law, two_spheres(), [[0, 1]], 0.1)[0][0] for law in (hard, soft)]
    # The numbers are whole.
    assert np.floor(times[1] / times[0]) == fewest
    waves = [ellgran.rayleigh_times(ellgran.Laws(law), two_spheres()).min() for law in (hard, soft)]
    assert waves[1] / waves[0] == pytest.approx(most)


@pytest.mark.parametrize("modulus, density, speed", [(1e7, 2500.0, 0.3), (3e6, 1000.0, 0.05)])
def test_the_overlap_of_an_impact(modulus, density, speed):
    factor, least = numbers_of(
        calibration_page(),
        rf"`{NUMBER} \(rho v\^2/E\)\^\(2/5\)` at most in an impact of two at the relative speed `v`: below 1 % with `E` above `{NUMBER} rho v\^2`",
    )
    radius = 1.3e-3
    spheres = ellgran.Bodies([[0, 0, 0], [0, 0, 2 * radius]], [radius] * 3, density=density)

    def overlap(modulus):
        return ellgran.elastic_collisions(f"hertz {modulus} 0.3", spheres, [[0, 1]], speed)[1][0] / radius

    # two digits, then one
    assert factor * (density * speed**2 / modulus) ** 0.4 == pytest.approx(overlap(modulus), rel=0.01)
    assert overlap(least * density * speed**2) == pytest.approx(0.01, rel=0.01)


def test_the_overlap_in_a_packing_at_rest():
    """That of the mean force with six contacts a grain at a solid fraction of 0.64; and the mean overlap of a packing."""
    page = calibration_page()
    factor, least = numbers_of(
        page,
        rf"`{NUMBER} \(p/E\)\^\(2/3\)` in a packing at rest under the pressure `p`, .*?: below 1 % with `E` above `{NUMBER} p`",
    )
    (share,) = numbers_of(page, rf"The mean overlap of a random packing is smaller, by up to {NUMBER} %")
    modulus = 1e7
    law = f"hertz {modulus} 0.3"

    # p = solid fraction x contacts a grain x F / (4 pi R^2): H. Rumpf, Chemie Ingenieur Technik 42, 538 (1970)
    for overlap in (1e-3, 1e-2):
        spheres = ellgran.Bodies([[0, 0, 0], [0, 0, 2 - overlap]], [1.0] * 3, density=1.0)
        force = ellgran.contacts(law, spheres, [[0, 1]]).normal_force[0]
        pressure = 0.64 * 6 * force / (4 * pi)
        # two digits, then one
        assert factor * (pressure / modulus) ** (2 / 3) == pytest.approx(overlap, rel=0.015)
    assert modulus / pressure == pytest.approx(least, rel=0.1)

    packing = ellgran.packing(law, [1.0, 1.0, 1.0], 0.638, count=80, seed=2)
    contacts = packing.contacts(law)
    pressure = np.trace(ellgran.stress_tensor(contacts, packing)) / 3
    # where the page speaks of 1 %
    assert 1e-5 < pressure / modulus < 1.2 / least
    smaller = 1 - contacts.penetration.mean() / (factor * (pressure / modulus) ** (2 / 3))
    assert 0.0 < smaller < share / 100
    assert contacts.penetration.mean() < 0.01


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
