# SPDX-License-Identifier: MIT OR Apache-2.0
"""The law on arrays: to the last bit what the C interface gives for each pair; without copies; errors with names."""
import ctypes
import threading

import numpy as np
import pytest

import ellgran
from ellgran import _interface, contact_arrays
from ellgran._library import call, sized
from scenes import MATERIALS, all_pairs, random_bodies, two_spheres


def c_body(bodies, k):
    body = sized(
        _interface.EllgranBody, mass=bodies.masses[k], particle_type=int(bodies.types[k]), identifier=int(bodies.identifiers[k])
    )
    for name, array in (
        ("position", bodies.positions),
        ("quaternion", bodies.quaternions),
        ("semi_axes", bodies.semi_axes),
        ("velocity", bodies.velocities),
        ("angular_velocity", bodies.angular_velocities),
    ):
        getattr(body, name)[:] = array[k]
    return body


def same_bits(a, b):
    return np.array_equal(np.asarray(a).view(np.int64), np.asarray(b).view(np.int64))


@pytest.mark.parametrize(
    "materials",
    [
        MATERIALS,
        ("hertz 1e4 0.3 damping restitution 0.7", "hertz 3e4 0.2 damping restitution 0.9"),
        ("lsd 1e4 3 tangential linear 5e3 2 0.4", "lsd 2e4 5 tangential linear 5e3 2 0.2"),
    ],
)
def test_every_quantity_is_the_c_call_s_to_the_last_bit(materials):
    bodies, laws = random_bodies(40), ellgran.Laws(*materials)
    pairs = all_pairs(40)
    memory = ellgran.ContactMemory(laws, len(pairs))
    own = [(ctypes.c_int32(0), (ctypes.c_double * 16)()) for _ in pairs]
    step = sized(_interface.EllgranStep, time_step=0.01, advance_history=1)
    touching = 0
    for _ in range(2):
        found = ellgran.contacts(laws, bodies, pairs, time_step=0.01, memory=memory)
        touching += found.touching.sum()
        for k, (i, j) in enumerate(pairs):
            geometry, force = sized(_interface.EllgranContactGeometry), sized(_interface.EllgranContactForce)
            call(
                "ellgran_contact",
                laws._pointer,
                ctypes.byref(c_body(bodies, i)),
                ctypes.byref(c_body(bodies, j)),
                ctypes.byref(step),
                ctypes.byref(own[k][0]),
                ctypes.addressof(own[k][1]),
                ctypes.byref(geometry),
                ctypes.byref(force),
            )
            assert found.touching[k] == geometry.touching
            for name in contact_arrays._CONTACT:
                if name == "curvatures":
                    one = [geometry.curvature_a, geometry.curvature_b]
                else:
                    one = getattr(geometry if hasattr(geometry, name) else force, name)
                assert same_bits(getattr(found, name)[k], np.array(one)), name
            assert same_bits(memory.history[k], np.array(own[k][1][: laws.history_length]))
        bodies.positions += 0.01 * bodies.velocities
    assert touching > 50
    assert np.abs(found.displacement).max() > 0.0 or "tangential" not in materials[0]


def test_stiffnesses_collisions_and_waves_are_the_c_calls_to_the_last_bit():
    bodies, laws = random_bodies(20), ellgran.Laws(*MATERIALS)
    pairs = all_pairs(20)
    speeds = 0.1 + np.arange(len(pairs))
    springs = ellgran.stiffnesses(laws, bodies, pairs)
    times, depths = ellgran.elastic_collisions(laws, bodies, pairs, speeds)
    for k, (i, j) in enumerate(pairs):
        a, b = c_body(bodies, i), c_body(bodies, j)
        one = sized(_interface.EllgranContactStiffness)
        time, depth = ctypes.c_double(), ctypes.c_double()
        call("ellgran_contact_stiffness", laws._pointer, ctypes.byref(a), ctypes.byref(b), ctypes.byref(one))
        call(
            "ellgran_collision", laws._pointer, ctypes.byref(a), ctypes.byref(b), speeds[k], ctypes.byref(time),
            ctypes.byref(depth),
        )  # fmt: skip
        for name in contact_arrays._STIFFNESS:
            assert same_bits(getattr(springs, name)[k], np.array(getattr(one, name))), name
        assert same_bits([times[k], depths[k]], [time.value, depth.value])
    assert np.isfinite(springs.critical_step).sum() > 10
    waves = ellgran.rayleigh_times(laws, bodies)
    for k in range(20):
        time = ctypes.c_double()
        law = laws.materials[bodies.types[k] - 1]
        body = c_body(bodies, k)
        call("ellgran_rayleigh_time", ctypes.byref(law._parameters), ctypes.byref(body), ctypes.byref(time))
        assert same_bits([waves[k]], [time.value])


def test_arrays_are_used_in_place():
    positions, axes, quaternions = np.zeros((2, 3)), np.ones((2, 3)), np.tile([1.0, 0, 0, 0], (2, 1))
    velocities, types = np.zeros((2, 3)), np.ones(2, dtype=np.int32)
    bodies = ellgran.Bodies(positions, axes, quaternions, velocities=velocities, types=types)
    assert bodies.positions is positions and bodies.semi_axes is axes and bodies.quaternions is quaternions
    assert bodies.velocities is velocities and bodies.types is types
    pairs = np.array([[0, 1]], dtype=np.int32)
    assert contact_arrays._pairs(pairs) is pairs
    positions[1, 0] = 1.9
    first = ellgran.contacts("hertz 1 0.3", bodies, pairs)
    assert first.penetration[0] == pytest.approx(0.1)
    where = first.force.ctypes.data
    positions[1, 0] = 1.8
    second = ellgran.contacts("hertz 1 0.3", bodies, pairs, out=first)
    assert second is first and first.force.ctypes.data == where
    assert first.penetration[0] == pytest.approx(0.2)
    assert np.shares_memory(bodies[0:1].positions, positions)
    for array in (first.force, first.penetration, first.contact_semi_axes):
        assert array.dtype == np.float64 and array.flags.c_contiguous


def test_other_arrays_are_converted():
    bodies = ellgran.Bodies(np.array([[0, 0, 0], [0, 0, 19]], dtype=np.float32).T.copy().T * 0.1, 1.0)
    assert bodies.positions.flags.c_contiguous and bodies.positions.dtype == np.float64
    found = ellgran.contacts("hertz 1 0.3", bodies, [[0, 1]])
    assert found.penetration[0] == pytest.approx(0.1, abs=1e-6)
    assert found.normal[0].tolist() == [0.0, 0.0, 1.0]


def test_only_what_is_asked_for_is_there():
    found = ellgran.contacts("hertz 1 0.3", two_spheres(1.0, -0.1), [[0, 1]], quantities=["force", "normal"])
    assert set(found.columns()) == {f"{name}_{axis}" for name in ("force", "normal") for axis in "xyz"}
    assert np.shares_memory(found.columns()["force_z"], found.force)
    with pytest.raises(AttributeError, match="penetration.*quantities"):
        found.penetration
    with pytest.raises(ValueError, match="'length'.*penetration"):
        ellgran.contacts("hertz 1 0.3", two_spheres(1.0), [[0, 1]], quantities=["length"])


def test_friction_needs_memory():
    spheres = two_spheres(1.0, -0.1, velocities=[[0, 0, 0], [0.5, 0, 0]])
    law = ellgran.Laws("hertz 1 0.3 tangential mindlin 0.5")
    memory = ellgran.ContactMemory(law, 1)
    forces = []
    for _ in range(3):
        forces.append(-ellgran.contacts(law, spheres, [[0, 1]], time_step=0.01, memory=memory).force[0, 0])
    assert 0.0 < forces[0] < forces[1] < forces[2]
    assert memory.touching[0] == 1
    alone = ellgran.contacts(law, spheres, [[0, 1]], memory=memory, advance_history=False)
    assert -alone.force[0, 0] == pytest.approx(forces[2], rel=1e-9)


@pytest.mark.parametrize(
    "wrong, error, words",
    [
        (dict(positions=[[0, 0, 0], [0, np.nan, 0]]), ellgran.BodyError, "particle 1.*NaN"),
        (dict(semi_axes=[[1, 1, 1], [1, 1, 0]]), ellgran.BodyError, "particle 1.*semi-axis = 0"),
        (dict(quaternions=[[1, 0, 0, 0], [0, 0, 0, 0]]), ellgran.BodyError, "particle 1.*quaternion"),
        (dict(types=[1, 3]), ellgran.BodyError, "particle 1.*type 3"),
        (dict(masses=[1, -1]), ellgran.BodyError, "particle 1.*mass = -1"),
    ],
)
def test_a_wrong_body_is_named(wrong, error, words):
    bodies = two_spheres(1.0)
    for name, value in wrong.items():
        setattr(bodies, name, value)
    with pytest.raises(error, match=words) as caught:
        ellgran.contacts("hertz 1 0.3 damping restitution 0.5", bodies, [[0, 1]])
    assert caught.value.status == _interface.ELLGRAN_ERROR_PARTICLE
    assert isinstance(caught.value, ValueError)


def test_wrong_arguments_are_named():
    bodies = two_spheres(1.0)
    with pytest.raises(ellgran.ArgumentError, match=r"pairs\[1\] names particle 2"):
        ellgran.contacts("hertz 1 0.3", bodies, [[0, 1], [1, 2]])
    with pytest.raises(ValueError, match=r"pairs has the shape \(2,\), it must be \(n, 2\)"):
        ellgran.contacts("hertz 1 0.3", bodies, [0, 1])
    with pytest.raises(TypeError, match="pairs must hold integers"):
        ellgran.contacts("hertz 1 0.3", bodies, [[0.0, 1.0]])
    # As 32 bits these would be bodies 0 and 1, and type 1.
    with pytest.raises(ValueError, match=r"pairs holds 4294967297, which is not from -2147483648 to 2147483647"):
        ellgran.contacts("hertz 1 0.3", bodies, np.array([[0, 2**32 + 1]]))
    with pytest.raises(ValueError, match="types holds 4294967297"):
        ellgran.Bodies(np.zeros((2, 3)), 1.0, types=[1, 2**32 + 1])
    with pytest.raises(ellgran.LawError, match="'herz'"):
        ellgran.contacts("herz 1 0.3", bodies, [[0, 1]])
    with pytest.raises(ellgran.ArgumentError, match="time_step = -1"):
        ellgran.contacts("hertz 1 0.3", bodies, [[0, 1]], time_step=-1)
    with pytest.raises(ValueError, match="memory is of 2 pairs"):
        ellgran.contacts("hertz 1 0.3", bodies, [[0, 1]], memory=ellgran.ContactMemory("hertz 1 0.3", 2))
    with pytest.raises(ellgran.ArgumentError, match=r"speeds\[0\] = 0"):
        ellgran.elastic_collisions("hertz 1 0.3", bodies, [[0, 1]], 0.0)
    with pytest.raises(ValueError, match=r"semi_axes has the shape \(2,\)"):
        ellgran.Bodies(np.zeros((2, 3)), [1.0, 2.0])
    with pytest.raises(AttributeError, match="velocity"):
        bodies.velocity = 0.0
    flat = ellgran.Bodies([[0, 0, 0], [0, 0, 1.99]], [[1000.0, 1.0, 1.0], [1.0, 1000.0, 1.0]])
    flat.semi_axes[1] = [1000.0, 1.0, 1.0]
    with pytest.raises(ellgran.ContactError, match=r"pairs\[0\].*factors exact"):
        ellgran.contacts("hertz 1 0.3 factors hale", flat, [[0, 1]])


def test_no_pairs_and_no_bodies():
    assert len(ellgran.contacts("hertz 1 0.3", two_spheres(), np.zeros((0, 2), np.int32))) == 0
    assert ellgran.contacts("hertz 1 0.3", two_spheres(), []).force.shape == (0, 3)
    assert len(ellgran.Bodies([], [])) == 0
    none = ellgran.Bodies(np.zeros((0, 3)), 1.0)
    assert len(ellgran.contacts("hertz 1 0.3", none, np.zeros((0, 2), np.int32))) == 0


def test_side_by_side():
    first, second = random_bodies(5, 1), random_bodies(5, 2)
    both, pairs = ellgran.side_by_side(first, second)
    assert pairs.tolist() == [[k, 5 + k] for k in range(5)]
    assert np.array_equal(both[5:].positions, second.positions)
    with pytest.raises(ValueError, match="5 bodies i and 4 bodies j"):
        ellgran.side_by_side(first, second[:4])


def test_threads_compute_side_by_side():
    bodies, laws, pairs = random_bodies(60), ellgran.Laws(*MATERIALS), all_pairs(60)
    expected = ellgran.contacts(laws, bodies, pairs).force
    results = [None] * 4

    def work(k):
        for _ in range(5):
            results[k] = ellgran.contacts(laws, bodies, pairs).force

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same_bits(result, expected) for result in results)


def test_a_single_body_has_arrays_of_its_own():
    axes, velocity = np.array([2.0, 1.0, 1.0]), np.zeros(3)
    one = ellgran.Bodies([[0.0, 0.0, 0.0]], axes, velocities=velocity)
    axes[:] = 5.0
    one.velocities[0] = [1.0, 2.0, 3.0]
    one.quaternions[0] = [0.0, 1.0, 0.0, 0.0]
    one.angular_velocities += 1.0
    assert one.semi_axes.tolist() == [[2.0, 1.0, 1.0]] and not velocity.any()


def test_a_memory_that_cannot_be_written_is_refused():
    law = "hertz 1e4 0.3 tangential tfd 0.5"
    memory = ellgran.ContactMemory(law, 1)
    memory.history.flags.writeable = False
    with pytest.raises(ValueError, match="can be written"):
        ellgran.contacts(law, two_spheres(gap=-1e-5), [[0, 1]], memory=memory)
