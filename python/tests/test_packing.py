# SPDX-License-Identifier: MIT OR Apache-2.0
"""Neighbours against all pairs of all images; a packing in balance; tensors against what they are by definition."""
from itertools import product

import numpy as np
import pytest

import ellgran
from scenes import random_bodies

ELASTIC = "hertz 1e6 0.3"
TILTED = [[4.0, 0.0, 0.0], [1.0, 5.0, 0.0], [-0.7, 0.9, 6.0]]


def brute_force(packing, distance):
    """Every pair of a body with every image of another within two edges."""
    bodies, box = packing.bodies, packing.box
    radius = bodies.semi_axes.max(axis=1)
    reach = [range(-2, 3) if periodic else (0,) for periodic in box.periodic]
    found = set()
    for i, j in product(range(len(bodies)), repeat=2):
        for image in product(*reach):
            d = bodies.positions[j] + np.array(image) @ box.edges - bodies.positions[i]
            if np.linalg.norm(d) < radius[i] + radius[j] + distance and not (i == j and image == (0, 0, 0)):
                found.add((i, j, *image) if (i, j) < (j, i) or (i == j and image > (0, 0, 0)) else None)
    return found - {None}


@pytest.mark.parametrize("periodic", [(True, True, True), (False, False, False), (True, False, True)])
@pytest.mark.parametrize("edges", [[4.0, 5.0, 6.0], TILTED, [1.1, 5.0, 6.0]])
@pytest.mark.parametrize("distance", [0.0, 0.3])
def test_neighbours_are_those_of_all_pairs(periodic, edges, distance):
    generator = np.random.default_rng(2)
    # Some lie outside of the box, in other images.
    bodies = ellgran.Bodies(generator.uniform(-1.0, 3.0, (12, 3)), generator.uniform(0.2, 0.6, (12, 3)))
    packing = ellgran.Packing(bodies, ellgran.Box([-1.0, 0.5, 0.0], edges, periodic))
    packing.bodies.positions = ellgran.Box([-1.0, 0.5, 0.0], edges, periodic).wrapped(bodies.positions)
    for k in range(2):
        pairs, images = packing.neighbours(distance)
        same = [
            (int(i), int(j), *image) if i != j or tuple(image) > (0, 0, 0) else (int(i), int(j), *[-c for c in image])
            for (i, j), image in zip(pairs, images.tolist())
        ]
        assert len(set(same)) == len(same) > 0
        assert set(same) == brute_force(packing, distance)
        packing.bodies.positions[3] += packing.box.edges[0] * packing.box.periodic[0]


def test_many_bodies_have_as_many_contacts_as_all_pairs_have():
    bodies = random_bodies(300)
    packing = ellgran.Packing(bodies, ellgran.Box.around(bodies))
    laws = ellgran.Laws(ELASTIC, ELASTIC)
    found = packing.contacts(laws)
    i, j = np.triu_indices(300, 1)
    every = ellgran.contacts(laws, bodies, np.stack([i, j], axis=1))
    assert len(found) == every.touching.sum() > 300
    assert np.array_equal(found.pairs, np.stack([i, j], axis=1)[every.touching])
    assert np.array_equal(found.force, every.force[every.touching])
    assert ellgran.coordination_numbers(found, 300).sum() == 2 * len(found)


def test_a_wrong_position_is_named():
    bodies = random_bodies(5)
    bodies.positions[3, 1] = np.inf
    with pytest.raises(ValueError, match="particle 1003"):
        ellgran.Packing(bodies, ellgran.Box([0, 0, 0], [5, 5, 5])).neighbours()
    with pytest.raises(ValueError, match="left-handed"):
        ellgran.Box([0, 0, 0], [1.0, 1.0, -1.0])


@pytest.fixture(scope="module")
def packed():
    """Sixty prolate grains, well above the fraction at which they jam."""
    return ellgran.packing(ELASTIC, [1.5, 1.0, 1.0], 0.76, count=60, density=2.0, seed=3)


def test_a_packing_in_three_lines(packed):
    assert packed.solid_fraction == pytest.approx(0.76)
    contacts = packed.contacts(ELASTIC)
    assert ellgran.coordination_numbers(contacts, 60).mean() > 7.0
    sums, torques = np.zeros((60, 3)), np.zeros((60, 3))
    np.add.at(sums, contacts.pairs[:, 1], contacts.force)
    np.add.at(sums, contacts.pairs[:, 0], -contacts.force)
    np.add.at(torques, contacts.pairs[:, 0], contacts.torque_i)
    np.add.at(torques, contacts.pairs[:, 1], contacts.torque_j)
    mean = contacts.normal_force.mean()
    assert np.abs(sums).max() < 2e-3 * mean and np.abs(torques).max() < 3e-3 * mean
    again = ellgran.packing(ELASTIC, [1.5, 1.0, 1.0], 0.3, count=20, seed=5)
    same = ellgran.packing(ELASTIC, [1.5, 1.0, 1.0], 0.3, count=20, seed=5)
    assert np.array_equal(again.bodies.positions, same.bodies.positions)
    assert len(again.contacts(ELASTIC)) <= 20
    with pytest.raises(ValueError, match="count = 0 must be 1 or greater"):
        ellgran.packing(ELASTIC, 1.0, 0.5, count=0)
    with pytest.raises(ValueError, match="solid_fraction = 1.5"):
        ellgran.packing(ELASTIC, 1.0, 1.5)


def test_stress_is_the_derivative_of_the_elastic_energy(packed):
    """-dU/d(strain)/V, grains neither turned nor deformed."""
    contacts = packed.contacts(ELASTIC)
    stress = ellgran.stress_tensor(contacts, packed)

    def energy(strain):
        stretch = np.eye(3) + strain
        bodies = packed.bodies.copy()
        bodies.positions = bodies.positions @ stretch.T
        box = ellgran.Box(packed.box.origin, packed.box.edges @ stretch.T)
        return ellgran.Packing(bodies, box).contacts(ELASTIC, quantities=["elastic_energy"]).elastic_energy.sum()

    scale = np.abs(stress).max()
    assert np.trace(stress) > 0.0
    for k, m in product(range(3), repeat=2):
        strain = np.zeros((3, 3))
        strain[k, m] = 1e-6
        slope = -(energy(strain) - energy(-strain)) / 2e-6 / packed.box.volume
        # The strain displaces along k what is apart along m.
        assert stress[m, k] == pytest.approx(slope, abs=1e-4 * scale)
    assert np.abs(stress - stress.T).max() < 1e-3 * scale
    moving = ellgran.Packing(packed.bodies.copy(), packed.box)
    moving.bodies.velocities = np.random.default_rng(0).normal(size=(60, 3)) + [5.0, 0.0, 0.0]
    more = ellgran.stress_tensor(contacts, moving, kinetic=True) - stress
    spread = moving.bodies.velocities - moving.bodies.velocities.mean(axis=0)
    expected = moving.bodies.masses[0] * (spread**2).sum() / packed.box.volume
    assert np.trace(more) == pytest.approx(expected, rel=1e-12)


def test_fabric_and_orientation(packed):
    contacts = packed.contacts(ELASTIC)
    fabric = ellgran.fabric_tensor(contacts.normal)
    assert np.trace(fabric) == pytest.approx(1.0) and np.abs(fabric - np.eye(3) / 3).max() < 0.08
    weighted = ellgran.fabric_tensor(contacts.normal, contacts.normal_force)
    assert np.trace(weighted) == pytest.approx(1.0)
    assert ellgran.fabric_tensor([[0, 0, 1], [0, 0, -1]])[2, 2] == 1.0
    with pytest.raises(ValueError, match=r"contacts name body \d+, which is not one of 4"):
        ellgran.coordination_numbers(contacts, 4)
    with pytest.raises(ValueError, match="at least one contact"):
        ellgran.fabric_tensor(np.zeros((0, 3)))

    half = np.pi / 8
    turned = ellgran.Bodies(np.zeros((4, 3)), [1, 3, 2], [np.cos(half), 0, 0, np.sin(half)])
    order, director = ellgran.nematic_order(turned)
    # The long axis, y, turned by 45 degrees about z.
    assert order == pytest.approx(1.0)
    assert np.abs(director @ [-np.sqrt(0.5), np.sqrt(0.5), 0]) == pytest.approx(1.0)
    assert ellgran.body_axes(turned, "shortest") == pytest.approx(np.tile([0.5**0.5, 0.5**0.5, 0.0], (4, 1)))
    assert ellgran.body_axes(turned, 2).tolist() == [[0, 0, 1]] * 4
    order, _ = ellgran.nematic_order(packed.bodies)
    assert order < 0.35
    assert np.trace(ellgran.orientation_tensor(packed.bodies)) == pytest.approx(1.0)
    with pytest.raises(ValueError, match="'middle'"):
        ellgran.body_axes(turned, "middle")


def test_rotations_compose():
    quaternions = ellgran.random_rotations(5, np.random.default_rng(1))
    bodies = ellgran.Bodies(np.zeros((5, 3)), 1.0, quaternions)
    vector = np.array([[0.3, -0.2, 0.9]] * 5)
    after = ellgran.Bodies(np.zeros((5, 3)), 1.0, ellgran.turned(quaternions, vector))
    angle = np.linalg.norm(vector[0])
    x, y, z = vector[0] / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    assert after.rotations == pytest.approx(rotation @ bodies.rotations, abs=1e-12)
