# SPDX-License-Identifier: MIT OR Apache-2.0
"""Collisions integrated with the law: one, with all that moves, or many central ones for their restitution."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import in_place
from .bodies import Bodies, Floats
from .contact_arrays import ContactMemory, contacts, elastic_collisions
from .law import Law, Laws, as_laws
from .packings import turned

_PAIR = np.array([[0, 1]], dtype=np.int32)


@dataclass
class Collision:
    """One collision of two bodies.

    Attributes
    ----------
    before, after : Bodies
        The two bodies at first touch and after the last, at different places.
    time : numpy.ndarray, shape (k,)
        Of the steps, from first touch on.
    penetration, normal_force, elastic_energy, dissipated_energy : numpy.ndarray, shape (k,)
        At these times.
    force, displacement : numpy.ndarray, shape (k, 3)
        Force on the second body, tangential displacement; world frame.
    """

    before: Bodies
    after: Bodies
    time: Floats
    penetration: Floats
    normal_force: Floats
    elastic_energy: Floats
    dissipated_energy: Floats
    force: Floats
    displacement: Floats

    def columns(self) -> Dict[str, NDArray]:
        """One-dimensional arrays by name, as ``pandas.DataFrame`` takes them."""
        table = {
            name: getattr(self, name)
            for name in ("time", "penetration", "normal_force", "elastic_energy", "dissipated_energy")
        }
        for name in ("force", "displacement"):
            for k, axis in enumerate("xyz"):
                table[f"{name}_{axis}"] = getattr(self, name)[:, k]
        return table


def collide(laws: Union[Laws, Law, str], bodies: Bodies, *, steps: int = 500, most_steps: int = 100_000) -> Collision:
    """The collision of two bodies that fly freely towards one another, with rotation and friction.

    Parameters
    ----------
    laws : Laws, Law or str
        The laws between their types.
    bodies : Bodies
        Two of them, apart or just touching; they are not changed. Masses may be ``inf``.
    steps : int
        Time steps in the duration of the elastic collision.
    most_steps : int
        When it has not ended by then, it fails.

    Returns
    -------
    Collision

    Raises
    ------
    ValueError
        They do not meet.

    Notes
    -----
    Velocity Verlet with velocities of the half step, as the engines have it. Its error is of the order of ``1/steps`` for
    viscous laws.
    """
    laws = as_laws(laws)
    if len(bodies) != 2:
        raise ValueError(f"a collision is of 2 bodies, not of {len(bodies)}")
    state = bodies.copy()
    _approach(laws, state)
    before = state.copy()
    speed = _closing_speed(laws, state)
    if not speed > 0.0:
        raise ValueError("the bodies touch, but do not approach")
    duration, _ = elastic_collisions(laws, state, _PAIR, speed)
    if not np.isfinite(duration[0]):
        raise ValueError("both bodies have infinite mass: nothing can collide")
    step = float(duration[0]) / steps
    memory = ContactMemory(laws, 1)
    momenta = _momenta(state)
    inverse_mass = 1.0 / state.masses[:, None]
    rows: List[List[float]] = []
    taken, force, torque = 0.0, np.zeros((2, 3)), np.zeros((2, 3))
    touched = False
    for number in range(1, most_steps + 1):
        # Kick and drift, so that the velocities are those of the half step that leads to the new place.
        kick = 0.5 * step if number == 1 else step
        state.velocities += kick * force * inverse_mass
        momenta += kick * torque
        _drift(state, momenta, step)
        found = contacts(laws, state, _PAIR, time_step=step, memory=memory)
        before_step = force, torque
        force = np.stack([-found.force[0], found.force[0]])
        torque = np.stack([found.torque_i[0], found.torque_j[0]])
        # What the contact takes from the bodies on the way, of which it holds some. The powers that the library names do not
        # have what viscosity memory dissipates while nothing moves.
        taken -= 0.5 * step * float(((before_step[0] + force) * state.velocities).sum())
        taken -= 0.5 * step * float(((before_step[1] + torque) * state.angular_velocities).sum())
        stored = float(found.elastic_energy[0] + found.tangential_energy[0])
        rows.append(
            [
                number * step,
                max(float(found.penetration[0]), 0.0),
                float(found.normal_force[0]),
                stored,
                taken - stored,
                *found.force[0],
                *found.displacement[0],
            ]
        )
        touched = touched or bool(found.touching[0])
        if touched and not found.touching[0]:
            break
        if not touched and number > steps:
            raise ValueError("the bodies do not meet")
    else:
        raise ValueError(f"the bodies still touch after {most_steps} steps: they stick, or steps is too large")
    # The angular velocity of the step was that of its middle.
    spins = _angular_velocities(state, momenta)
    free = np.isfinite(state.masses)
    state.angular_velocities[free] = spins[free]
    table = np.array(rows)
    return Collision(
        before=before,
        after=state,
        time=table[:, 0],
        penetration=table[:, 1],
        normal_force=table[:, 2],
        elastic_energy=table[:, 3],
        dissipated_energy=table[:, 4],
        force=table[:, 5:8],
        displacement=table[:, 8:11],
    )


def _approach(laws: Laws, state: Bodies) -> None:
    """Lets the bodies fly until they all but touch: no step is longer than the gap allows at the fastest approach."""
    radius = state.semi_axes.max(axis=1)
    fastest = float(
        np.linalg.norm(state.velocities[1] - state.velocities[0])
        + (np.linalg.norm(state.angular_velocities, axis=1) * radius).sum()
    )
    momenta = _momenta(state)
    least = float(state.semi_axes.min())
    for number in range(1000):
        gap = -float(contacts(laws, state, _PAIR, quantities=["penetration"]).penetration[0])
        if number == 0 and gap < -1e-6 * least:
            raise ValueError(f"the bodies overlap by {-gap:.6g} before they move: put them apart")
        if gap <= 1e-9 * least:
            return
        d = state.positions[1] - state.positions[0]
        leaving = (state.velocities[1] - state.velocities[0]) @ d > 0.0
        if not fastest > 0.0 or (leaving and np.linalg.norm(d) > radius.sum()):
            raise ValueError("the bodies do not meet")
        _drift(state, momenta, gap / fastest)
    raise ValueError("the bodies come near one another, but do not meet")


def _closing_speed(laws: Laws, state: Bodies) -> float:
    found = contacts(laws, state, _PAIR, quantities=["normal", "contact_point"])
    arms = found.contact_point - state.positions
    velocities = state.velocities + np.cross(state.angular_velocities, arms)
    return float((velocities[0] - velocities[1]) @ found.normal[0])


def _momenta(state: Bodies) -> Floats:
    """Angular momenta, world frame; those of fixed bodies are angular velocities."""
    inertia = np.where(np.isfinite(state.inertia), state.inertia, 1.0)
    rotations = state.rotations
    spins = np.einsum("kji,kj->ki", rotations, state.angular_velocities)
    return np.asarray(np.einsum("kij,kj->ki", rotations, inertia * spins))


def _angular_velocities(state: Bodies, momenta: Floats) -> Floats:
    inertia = np.where(np.isfinite(state.inertia), state.inertia, 1.0)
    rotations = state.rotations
    return np.asarray(
        np.einsum("kij,kj->ki", rotations, np.einsum("kji,kj->ki", rotations, momenta) / inertia)
    )


def _drift(state: Bodies, momenta: Floats, step: float) -> None:
    """Free flight; the angular velocity is that of the middle of the step."""
    fixed = ~np.isfinite(state.masses)
    state.positions += step * state.velocities
    begin = state.quaternions.copy()
    spins = _angular_velocities(state, momenta)
    spins[fixed] = state.angular_velocities[fixed]
    turned(begin, 0.5 * step * spins, out=state.quaternions)
    spins = _angular_velocities(state, momenta)
    spins[fixed] = state.angular_velocities[fixed]
    turned(begin, step * spins, out=state.quaternions)
    state.angular_velocities = spins


def restitution(
    laws: Union[Laws, Law, str], bodies: Bodies, speed: ArrayLike, pairs: ArrayLike = _PAIR, *, steps: int = 200
) -> Floats:
    """Coefficients of restitution of central impacts: speed of rebound over speed of impact, from the law integrated in time.

    Parameters
    ----------
    laws : Laws, Law or str
        The laws between the types of the bodies.
    bodies : Bodies
        n of them; velocities and rotations are not read.
    speed : array_like, shape (m,) or ()
        Speed along the normal at first touch, length/time, > 0.
    pairs : array_like of int, shape (m, 2) or (1, 2)
        Indices of the bodies of each pair; one pair serves all speeds. Default: bodies 0 and 1.
    steps : int
        Time steps in the duration of the elastic collision.

    Returns
    -------
    numpy.ndarray, shape (m,), or shape () for a single speed
        Between 0 and 1; 0 where the bodies do not part within 50 durations of the elastic collision.

    Raises
    ------
    ValueError
        The normal of a pair does not pass both centres: then rotation takes part, and `collide` gives the motion. Or a law has
        ``viscosity memory``: its force depends on what was before, which `collide` remembers.

    Notes
    -----
    ``m_eff delta'' = -F(delta, delta')`` by the Runge-Kutta method of fourth order, ``m_eff`` from both masses. With 200 steps the
    error is about 1e-6, and below 1e-4 for laws of ``limit_force no``, whose attraction ends in a root of the penetration.
    """
    laws = as_laws(laws)
    if laws._remembers_normal_force:
        raise ValueError("the force of viscosity memory depends on what was before: use collide, which remembers it")
    which = in_place(pairs, (None, 2), "pairs", np.int32)
    speeds = np.atleast_1d(np.asarray(speed, dtype=np.float64))
    count = max(len(which), len(speeds))
    which = in_place(np.broadcast_to(which, (count, 2)), (count, 2), "pairs", np.int32)
    speeds = np.broadcast_to(speeds, (count,))
    # Two bodies for each impact: bodies i, then bodies j.
    both = Bodies.joined(bodies[which[:, 0]], bodies[which[:, 1]])
    both.velocities = np.zeros((2 * count, 3))
    both.angular_velocities = np.zeros((2 * count, 3))
    order = np.stack([np.arange(count), count + np.arange(count)], axis=1).astype(np.int32)
    geometry = contacts(laws, both, order, quantities=["penetration", "normal", "contact_point"])
    normal = geometry.normal
    d = both.positions[count:] - both.positions[:count]
    off = np.linalg.norm(np.cross(normal, geometry.contact_point - both.positions[:count]), axis=1)
    off += np.linalg.norm(np.cross(normal, d), axis=1)
    wrong = np.flatnonzero(off > 1e-6 * both.semi_axes.min())
    if len(wrong):
        raise ValueError(
            f"pairs[{wrong[0]}]: the normal does not pass both centres, so the bodies turn in the impact: use collide"
        )
    touch = np.einsum("ij,ij->i", d, normal) + geometry.penetration
    both.positions[:count] = 0.0
    inverse_mass = 1.0 / both.masses[:count] + 1.0 / both.masses[count:]
    duration, deepest = elastic_collisions(laws, both, order, speeds)
    if not np.isfinite(duration).all():
        raise ValueError("both bodies of a pair have infinite mass: nothing can collide")
    found = contacts(laws, both, order, quantities=["normal_force"])
    # A law is asked at a penetration that it counts as a contact.
    least = 1e-9 * deepest

    def acceleration(depth: Floats, rate: Floats) -> Floats:
        both.positions[count:] = normal * (touch - np.maximum(depth, least))[:, None]
        both.velocities[count:] = -normal * rate[:, None]
        contacts(laws, both, order, out=found)
        return np.asarray(-found.normal_force * inverse_mass)

    def advanced(depth: Floats, rate: Floats, step: Floats) -> List[Floats]:
        a1 = acceleration(depth, rate)
        v2 = rate + 0.5 * step * a1
        a2 = acceleration(depth + 0.5 * step * rate, v2)
        v3 = rate + 0.5 * step * a2
        a3 = acceleration(depth + 0.5 * step * v2, v3)
        v4 = rate + step * a3
        a4 = acceleration(depth + step * v3, v4)
        return [
            depth + step / 6.0 * (rate + 2.0 * v2 + 2.0 * v3 + v4),
            rate + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
            a1,
        ]

    longest = duration / steps
    # A dashpot may go with a root of the penetration: the first steps are short.
    step = 1e-3 * longest
    depth, rate = np.zeros(count), speeds.copy()
    rebound = np.zeros(count)
    running = np.ones(count, dtype=bool)
    for _ in range(50 * steps):
        step = np.minimum(1.1 * step, longest)
        new_depth, new_rate, force = advanced(depth, rate, step)
        # Without force on the way out the speed is that of the end.
        free = running & (rate < 0.0) & (force == 0.0)
        rebound[free] = -rate[free]
        ends = running & ~free & (new_depth <= 0.0)
        if ends.any():
            # The last step ends where the bodies part.
            part = step.copy()
            for _ in range(4):
                end_depth, end_rate, _unused = advanced(depth, rate, part)
                part = np.where(ends, part - end_depth / np.where(end_rate < 0.0, end_rate, -speeds), step)
                part = np.clip(part, 0.0, step)
            rebound[ends] = -end_rate[ends]
        running &= ~(free | ends)
        if not running.any():
            break
        depth, rate = np.where(running, new_depth, 0.0), np.where(running, new_rate, 0.0)
    ratio = rebound / speeds
    return ratio if np.ndim(speed) or len(ratio) > 1 else ratio[0]
