# SPDX-License-Identifier: MIT OR Apache-2.0
"""The same finite elements with the inertia of every node, in implicit steps: a check of the reduced bodies of free_body.py.

A body whose normal passes through its centre, against its mirror image: a rigid plane without friction.
"""
from __future__ import annotations

from typing import Tuple

import numpy as np

from free_body import Grid, Mesh, factorised
from two_bodies import Contact

#: Newmark's gamma, slightly above one half: what vibrates from step to step is damped.
_GAMMA = 0.51
_BETA = 0.25 * (_GAMMA + 0.5) ** 2


def against_a_plane(
    shape: np.ndarray, poisson: float, half_widths: Tuple[float, float], grid: Grid, speed: float, duration: float, steps: int
) -> Tuple[float, float]:
    """Rebound speed of the centre of mass over `speed`, and the largest force, of the whole body. `steps` in `duration`."""
    mesh = Mesh(shape, half_widths, grid)
    stiffness, mass = mesh.matrices(poisson)
    kept = np.ones(stiffness.shape[0], dtype=bool)
    kept[1::3] = ~mesh.on_symmetry_plane
    stiffness, mass = stiffness[kept][:, kept], mass[kept][:, kept]
    step = duration / steps
    inertia = (mass / (_BETA * step**2)).tocsr()
    solve = factorised((stiffness + inertia).tocsc())
    touching = (np.cumsum(kept) - 1)[3 * mesh.top + 2]
    count = len(touching)
    load = np.zeros((stiffness.shape[0], count))
    load[touching, np.arange(count)] = 1.0
    answers = np.asarray(solve(load))
    flexibility = np.zeros((3 * count, 3 * count))
    flexibility[2 * count :, 2 * count :] = answers[touching]
    contact = Contact(flexibility, count, 0.0, np.zeros(count, dtype=bool))
    upwards = np.zeros(len(kept))
    upwards[2::3] = 1.0
    upwards = upwards[kept]
    weight = mass @ upwards
    gap = -mesh.nodes[mesh.top, 2]
    place, rate, change = np.zeros(len(upwards)), speed * upwards, np.zeros(len(upwards))
    largest, last = 0.0, None
    for number in range(1, 10 * steps):
        ahead = place + step * rate + step**2 * (0.5 - _BETA) * change
        free = solve(inertia @ ahead)
        force = contact.solve(gap - free[touching], np.zeros(2 * count), np.zeros(3 * count))[0][2 * count :]
        place = free - answers @ force
        new = (place - ahead) / (_BETA * step**2)
        rate = rate + step * ((1 - _GAMMA) * change + _GAMMA * new)
        change = new
        largest = max(largest, 2 * float(force.sum()))
        if force.any():
            last = number
        elif last is not None and number - last > 0.3 * steps:
            break
    return -float(weight @ rate) / float(weight.sum()) / speed, largest
