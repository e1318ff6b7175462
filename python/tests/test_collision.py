# SPDX-License-Identifier: MIT OR Apache-2.0
"""One collision: conserved quantities, and the central one that restitution integrates."""
import numpy as np
import pytest

import ellgran
from scenes import two_spheres

OBLIQUE = dict(
    positions=[[0, 0, -0.006], [0.003, 0, 0.0091]],
    semi_axes=[0.005, 0.005, 0.01],
    quaternions=[[np.cos(np.pi / 6), 0, np.sin(np.pi / 6), 0], [np.cos(-0.65), 0, np.sin(-0.65), 0]],
    velocities=[[0, 0, 0], [-0.25, 0, -0.5]],
    angular_velocities=[[1.0, 2.0, 3.0], [-2.0, 0.5, 1.0]],
    density=2500.0,
)


def momentum(bodies):
    linear = bodies.masses[:, None] * bodies.velocities
    rotations = bodies.rotations
    own = np.einsum("kji,kj->ki", rotations, bodies.angular_velocities) * bodies.inertia
    angular = np.cross(bodies.positions, linear) + np.einsum("kij,kj->ki", rotations, own)
    return linear.sum(axis=0), angular.sum(axis=0)


def kinetic(bodies):
    own = np.einsum("kji,kj->ki", bodies.rotations, bodies.angular_velocities)
    return 0.5 * ((bodies.masses[:, None] * bodies.velocities**2).sum() + (bodies.inertia * own**2).sum())


def test_momentum_and_energy_add_up():
    bodies = ellgran.Bodies(**OBLIQUE)
    untouched = bodies.copy()
    collision = ellgran.collide("nfd 1e7 0.3 400 400 tangential tfd 0.5", bodies, steps=800)
    assert np.array_equal(bodies.positions, untouched.positions)
    for before, after in zip(momentum(collision.before), momentum(collision.after)):
        assert np.abs(after - before).max() < 1e-12 * np.abs(before).max()
    lost = kinetic(collision.before) - kinetic(collision.after)
    assert 0.05 < lost / kinetic(collision.before) < 0.9
    assert collision.dissipated_energy[-1] == pytest.approx(lost, rel=5e-3)
    assert np.abs(collision.displacement).max() > 0 and collision.normal_force.max() > 0
    assert len(collision.columns()["force_x"]) == len(collision.time)


def test_an_elastic_collision_keeps_its_energy():
    collision = ellgran.collide("hertz 1e7 0.3", ellgran.Bodies(**OBLIQUE))
    assert kinetic(collision.after) == pytest.approx(kinetic(collision.before), rel=1e-4)


def test_a_central_one_has_the_restitution_of_its_law():
    spheres = two_spheres(gap=1e-3, velocities=[[0, 0, 0.02], [0, 0, -0.08]])
    collision = ellgran.collide("nfd 1e7 0.3 100 100", spheres, steps=1000)
    rebound = collision.after.velocities[1, 2] - collision.after.velocities[0, 2]
    assert rebound / 0.1 == pytest.approx(ellgran.restitution("nfd 1e7 0.3 100 100", spheres, 0.1), abs=1e-3)


@pytest.mark.parametrize("viscosities", ["1000 1000", "1000 0", "10000 5000"])
def test_the_memory_of_the_solid_dissipates_what_the_motion_loses(viscosities):
    spheres = two_spheres(gap=1e-3, velocities=[[0, 0, 0.02], [0, 0, -0.08]])
    law = f"nfd 1e7 0.3 {viscosities} viscosity memory"
    collision = ellgran.collide(law, spheres, steps=1000)
    lost = kinetic(collision.before) - kinetic(collision.after)
    assert lost > 0.01 * kinetic(collision.before)
    assert collision.dissipated_energy[-1] == pytest.approx(lost, rel=1e-6)
    # A single evaluation has no past: the restitution is that of the collision, or none.
    with pytest.raises(ValueError, match="use collide"):
        ellgran.restitution(law, spheres, 0.1)
    with pytest.raises(ValueError, match="use collide"):
        ellgran.with_restitution(law, 0.8, 0.1, spheres)


def test_a_fixed_body_stays():
    spheres = two_spheres(gap=1e-3, velocities=[[0, 0, 0], [0, 0, -0.1]])
    spheres.masses = [np.inf, spheres.masses[1]]
    after = ellgran.collide("hertz 1e7 0.3", spheres).after
    assert not after.positions[0].any() and not after.velocities[0].any()
    assert after.velocities[1, 2] == pytest.approx(0.1, rel=1e-3)


def test_what_is_no_collision_is_said():
    with pytest.raises(ValueError, match="do not meet"):
        ellgran.collide("hertz 1e7 0.3", two_spheres(gap=1e-3, velocities=[[0, 0, 0], [0, 0, 0.1]]))
    with pytest.raises(ValueError, match="do not meet"):
        ellgran.collide("hertz 1e7 0.3", two_spheres(gap=1e-3))
    with pytest.raises(ValueError, match="do not meet"):
        ellgran.collide("hertz 1e7 0.3", two_spheres(gap=1e-3, velocities=[[0, 0, 0], [1.0, 0, -0.1]]))
    with pytest.raises(ValueError, match="overlap by"):
        ellgran.collide("hertz 1e7 0.3", two_spheres(gap=-1e-5, velocities=[[0, 0, 0], [0, 0, -0.1]]))
    with pytest.raises(ValueError, match="2 bodies"):
        ellgran.collide("hertz 1e7 0.3", two_spheres()[:1])
