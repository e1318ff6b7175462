# SPDX-License-Identifier: MIT OR Apache-2.0
"""The stored packings against what is known; their measures on packings that have closed forms."""
from pathlib import Path

import numpy as np
import pytest
from stored import read_csv

import ellgran

STORED = Path(__file__).resolve().parent.parent / "packings" / "packings.csv"


def _face_centred(cells: int) -> ellgran.Packing:
    """Spheres of diameter 1 that overlap by 1e-6, as dense as spheres can be; stretched along z they are ellipsoids."""
    edge = np.sqrt(2.0) * (1 - 1e-6)
    corners = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    basis = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]])
    places = edge * (corners[:, None, :] + basis + 0.25).reshape(-1, 3)
    stretch = np.array([1.0, 1.0, 1.5])
    return ellgran.Packing(ellgran.Bodies(places * stretch, 0.5 * stretch), ellgran.Box([0, 0, 0], cells * edge * stretch))


def test_a_crystal_has_its_solid_fraction_twelve_contacts_and_order(packings):
    packing = _face_centred(3)
    pairs = packings.compare.touching(packing)
    found = packings.packing_measures.measures(packing, pairs, 4)
    assert found.solid_fraction == pytest.approx(np.pi / np.sqrt(18.0), rel=1e-5)
    assert found.coordination == 12
    assert found.rattlers == 0
    assert found.order == pytest.approx(1.0)


def test_a_layer_cuts_the_grains_at_its_faces(packings):
    # Two layers of the crystal make a period: between equal heights of two periods the fraction is that of the whole.
    packing = _face_centred(4)
    period = packing.box.edges[2, 2] / 4
    pairs = packings.compare.touching(packing)
    for low in (0.9, 1.13, 1.4):
        found = packings.packing_measures.measures(packing, pairs, 4, (low, low + 2 * period))
        assert found.solid_fraction == pytest.approx(np.pi / np.sqrt(18.0), rel=1e-5)
        assert found.coordination == 12


def test_a_grain_in_a_cage_bears_no_load(packings):
    # A triangle of grains that hold one another, a chain that hangs on it, a pair apart.
    pairs = np.array([[0, 1], [1, 2], [2, 0], [2, 3], [3, 4], [5, 6]])
    stays = packings.packing_measures.bearing(7, pairs, 2)
    assert stays.tolist() == [True, True, True, False, False, False, False]
    kept = np.array([False] * 4 + [True] + [False] * 2)
    assert packings.packing_measures.bearing(7, pairs, 2, kept)[3:5].all()


def test_the_stored_packings_are_as_known():
    rows = read_csv(STORED)

    def mean(shape, quantity, protocol="compressed", friction=0.0):
        values = [r[quantity] for r in rows if (r["shape"], r["protocol"], r["friction"]) == (shape, protocol, friction)]
        return np.mean(values)

    spheroids = sorted({r["shape"] for r in rows if r["shape"].endswith(":1:1")}, key=lambda shape: float(shape.split(":")[0]))
    # Spheres at random close packing.
    assert mean("1:1:1", "solid_fraction") == pytest.approx(0.64, abs=0.01)
    assert mean("1:1:1", "coordination") == pytest.approx(6.0, abs=0.25)
    # Maxima of about 0.71 on both sides, the ends lower.
    fractions = {float(shape.split(":")[0]): mean(shape, "solid_fraction") for shape in spheroids}
    oblate = max((fraction, aspect) for aspect, fraction in fractions.items() if aspect < 1)
    prolate = max((fraction, aspect) for aspect, fraction in fractions.items() if aspect > 1)
    for (fraction, aspect), (low, high) in ((oblate, (0.5, 0.75)), (prolate, (1.4, 1.9))):
        assert 0.68 < fraction < 0.73
        assert low < aspect < high
    assert mean("1.25:1:0.8", "solid_fraction") == pytest.approx(0.735, abs=0.015)
    # Fewer contacts than twice the degrees of freedom; a pressure of 1e-6 of the modulus adds 0.1 to 0.2.
    assert all(mean(shape, "coordination") < 10.2 for shape in spheroids)
    assert mean("1.25:1:0.8", "coordination") < 12.2
    # Friction loosens, whatever the shape and the protocol.
    for shape in [*spheroids, "1.25:1:0.8"]:
        for protocol in ("compressed", "settled"):
            assert mean(shape, "solid_fraction", protocol, 0.5) < mean(shape, "solid_fraction", protocol, 0.0)


def test_two_thousand_grains_pack_as_one_thousand_do(packings):
    rows = read_csv(STORED)
    large = {(r["shape"], r["protocol"], r["friction"]): r for r in rows if r["grains"] == 2000}
    wanted = {(case.shape, case.protocol, case.friction) for case in packings.compare.cases(1)}
    assert set(large) == wanted
    compared = 0
    for key, row in large.items():
        small = [r["solid_fraction"] for r in rows if (r["shape"], r["protocol"], r["friction"]) == key and r["grains"] == 1000]
        if small:
            compared += 1
            # Half as much again as one realisation of 1000 differed from another, with friction and settled.
            assert row["solid_fraction"] == pytest.approx(np.mean(small), abs=0.015)
    assert compared == 48


def test_three_axes_close_contacts_for_long():
    rows = {(r["shape"], r["protocol"]): r for r in read_csv(STORED) if (r["grains"], r["realisation"], r["friction"]) == (300, 1, 0)}
    for protocol in ("compressed", "settled"):
        quickly, slowly = rows["1.25:1:0.8", protocol], rows["1.25:1:0.8", f"{protocol}, slowly"]
        assert quickly["coordination"] + 0.3 < slowly["coordination"] < 12.2
    assert rows["1.25:1:0.8", "compressed"]["solid_fraction"] < rows["1.25:1:0.8", "compressed, slowly"]["solid_fraction"] < 0.745
