# SPDX-License-Identifier: MIT OR Apache-2.0
"""Words, constants, and what the contact of two materials has."""
import pytest

import ellgran


def test_words_and_constants():
    law = ellgran.Law("  nfd 3e6  0.3 200 100 tangential tfd 0.5 ")
    assert law.words == "nfd 3e6 0.3 200 100 tangential tfd 0.5"
    assert (law.youngs_modulus, law.poissons_ratio, law.friction) == (3e6, 0.3, 0.5)
    assert (law.shear_viscosity, law.bulk_viscosity, law.restitution) == (200.0, 100.0, 1.0)
    other = law.with_viscosities(7, 8)
    assert other.words == "nfd 3e6 0.3 7.0 8.0 tangential tfd 0.5"
    assert (other.shear_viscosity, other.bulk_viscosity, other.friction) == (7.0, 8.0, 0.5)
    with pytest.raises(AttributeError, match="colour"):
        law.colour
    with pytest.raises(ValueError, match="nfd E nu eta1 eta2"):
        ellgran.Law("hertz 1 0.3").with_viscosities(1, 1)


def test_a_wrong_word_is_named():
    with pytest.raises(ellgran.LawError, match="eta1 eta2") as caught:
        ellgran.Law("nfd 3e6 0.3 200")
    assert caught.value.status == 100
    with pytest.raises(ellgran.LawError, match="'tangent'"):
        ellgran.Law("hertz 3e6 0.3 tangent tfd 0.5")
    with pytest.raises(ellgran.LawError):
        ellgran.Law("")
    with pytest.raises(ellgran.LawError, match="cannot be mixed"):
        ellgran.Laws("hertz 1 0.3", "lsd 1 1")
    with pytest.raises(ellgran.ArgumentError, match="type_count = 0"):
        ellgran.Laws()
    with pytest.raises(ValueError, match="types 1 3"):
        ellgran.Laws("hertz 1 0.3", pairs={(1, 3): "hertz 1 0.3"})


def test_moduli_and_relaxation_times_mix_as_the_theory_says():
    a, b = "nfd 3e6 0.3 200 200 tangential tfd 0.5", "nfd 1e7 0.2 100 50 tangential tfd 0.3"
    laws = ellgran.Laws(a, b)
    mixed = laws.mixture(1, 2)
    c1, c2 = (1 - 0.09) / 3e6, (1 - 0.04) / 1e7
    g1, g2 = 3e6 / 2.6, 1e7 / 2.4
    assert mixed.effective_modulus == pytest.approx(1 / (c1 + c2), rel=1e-12)
    assert mixed.effective_shear_modulus == pytest.approx(1 / (1.7 / g1 + 1.8 / g2), rel=1e-9)

    def relaxation(nu, eta1, eta2, c):
        return (2 / 3 * eta1 * (1 - nu + nu * nu) + eta2 * (1 - 2 * nu) ** 2) / (1 - nu) ** 2 * c

    t1, t2 = relaxation(0.3, 200, 200, c1), relaxation(0.2, 100, 50, c2)
    assert mixed.normal_relaxation_time == pytest.approx((t1 * c1 + t2 * c2) / (c1 + c2), rel=1e-12)
    assert laws.mixture(1, 1).normal_relaxation_time == pytest.approx(t1, rel=1e-12)
    # Proportional viscosity: one relaxation time for all deformation.
    time = ellgran.Laws("hertz 3e6 0.3 damping relaxation 1e-4 tangential tfd 0.5").mixture()
    assert time.normal_relaxation_time == pytest.approx(1e-4, rel=1e-12)
    assert time.tangential_relaxation_time == pytest.approx(1e-4, rel=1e-12)
    with pytest.raises(ValueError, match="lsd"):
        ellgran.Laws("lsd 1 1").mixture()


def test_a_pair_of_types_may_have_its_own_law():
    laws = ellgran.Laws("hertz 1e6 0.3", "hertz 1e6 0.3", pairs={(1, 2): "hertz 5e6 0.3"})
    assert laws.mixture(2, 1).effective_modulus == pytest.approx(5 * laws.mixture(1, 1).effective_modulus)
    assert "E*" in laws.describe(1, 2) and laws.type_count == 2
    with pytest.raises(ellgran.ArgumentError, match="3"):
        laws.describe(1, 3)
