# SPDX-License-Identifier: MIT OR Apache-2.0
"""Finite elements in three dimensions: two whole ellipsoids pressed together without friction, at rest, small strain.

The elements are those of collisions/free_body.py. `free` and `held` are as in finite_bodies.py; where the normal misses the centre, inertia balances
the torque of the contact force too.
"""
from __future__ import annotations

from typing import NamedTuple, Tuple

import numpy as np

from collisions.free_body import Grid, Mesh, factorised
from ellipsoid_pair import Pair, Shape
from finite_bodies import pressed

# Where the mesh ceases to follow the contact, as a distance in the unit ball: so near that the mesh of a slender tilted body does not fold.
_REACH = 0.5


class Compliance(NamedTuple):
    """Of the nodes that may touch, along the normal, under forces on the part of the body that is meshed."""

    #: In the plane of contact, shape (nodes, 2).
    places: np.ndarray
    matrix: np.ndarray
    #: How far a unit force on the other side moves the touching point towards the centre of mass.
    from_the_other_side: float
    unknowns: int


def compliance(shape: Shape, poisson: float, half_widths: Tuple[float, float], grid: Grid, quarter: bool) -> Compliance:
    """Modulus 1. Half of the body is meshed, or where x = 0 is a plane of symmetry a `quarter`."""
    mesh = Mesh(shape.matrix(), half_widths, grid, _REACH)
    nodes = mesh.nodes
    small = 1e-6 * half_widths[0] / grid.across
    kept = np.ones((len(nodes), 3), dtype=bool)
    kept[mesh.on_symmetry_plane, 1] = False
    if quarter:
        mesh.cells = mesh.cells[(nodes[mesh.cells][:, :, 0] < small).all(axis=1)]
        kept[nodes[:, 0] > small] = False
        kept[np.abs(nodes[:, 0]) < small, 0] = False
    top = mesh.top[kept[mesh.top, 2]]
    kept = kept.ravel()
    stiffness, mass = (matrix[kept][:, kept] for matrix in mesh.matrices(poisson))
    arm = nodes - mesh.centre
    along_x, along_z, turn = np.zeros((3, *arm.shape))
    along_x[:, 0], along_z[:, 2] = 1.0, 1.0
    turn[:, 0], turn[:, 2] = arm[:, 2], -arm[:, 0]
    rigid = np.stack([motion.ravel()[kept] for motion in ([along_z] if quarter else [along_x, along_z, turn])], axis=1)
    weighted = mass @ rigid
    inertia = rigid.T @ weighted
    # Small beside the squares of the lowest vibrations' frequencies, so that it only fixes the rigid motions, which no force here drives.
    shift = 1e-6 / float(np.max(np.abs(arm))) ** 2
    solve = factorised((stiffness + shift * mass).tocsc())
    number = np.cumsum(kept) - 1
    touching = number[3 * top + 2]
    opposite = number[3 * int(np.argmin(np.linalg.norm(nodes - 2 * mesh.centre, axis=1))) + 2]

    def displacement(loads: np.ndarray) -> np.ndarray:
        """In the frame of the centre of mass, under forces that inertia balances."""
        found = np.asarray(solve(loads - weighted @ np.linalg.solve(inertia, rigid.T @ loads)))
        return found - rigid @ np.linalg.solve(inertia, weighted.T @ found)

    matrix = np.empty((len(top), len(top)))
    for first in range(0, len(top), 64):
        columns = touching[first : first + 64]
        loads = np.zeros((stiffness.shape[0], len(columns)))
        loads[columns, np.arange(len(columns))] = 1.0
        matrix[:, first : first + 64] = displacement(loads)[touching]
    load = np.zeros((stiffness.shape[0], 1))
    load[opposite] = 1.0
    centre = int(np.argmin((nodes[top, :2] ** 2).sum(axis=1)))
    return Compliance(
        places=nodes[top, :2],
        matrix=0.5 * (matrix + matrix.T),
        from_the_other_side=-float(displacement(load)[touching[centre], 0]),
        unknowns=stiffness.shape[0],
    )


class WholePair:
    """Two bodies that touch at the origin with the common normal along z. y = 0 must be a plane of symmetry of both."""

    def __init__(self, pair: Pair, poisson: float, half_widths: Tuple[float, float], grid: Grid, quarters: bool = True) -> None:
        """`quarters`: mesh no more than these where x = 0 is a plane of symmetry too."""
        quarter = quarters and pair.i.is_central() and pair.j.is_central()
        self._parts = 4 if quarter else 2
        lower = compliance(pair.i, poisson, half_widths, grid, quarter)
        x, y = lower.places.T
        shapes = pair.i.matrix(), pair.j.matrix()
        # The upper body is the lower one or has a mesh of its own, upside down: inverted at the origin.
        upper, place = lower, -lower.places
        if quarter:
            place[:, 0] *= -1
        if quarter and half_widths[0] == half_widths[1] and np.allclose(shapes[1], shapes[0][np.ix_([1, 0, 2], [1, 0, 2])]):
            # The lower one, mirrored at x = y.
            place = -lower.places[:, ::-1]
        elif not np.allclose(*shapes):
            upper = compliance(pair.j, poisson, half_widths, grid, quarter)
        place[:, 1] = np.abs(place[:, 1])
        apart = np.abs(upper.places[None, :] - place[:, None]).max(axis=2)
        order = apart.argmin(axis=1)
        if apart.min(axis=1).max() > 1e-6 * max(half_widths):
            raise ValueError("the nodes of the two bodies do not lie on one another")
        self._compliance = lower.matrix + upper.matrix[np.ix_(order, order)]
        self._from_the_other_sides = lower.from_the_other_side + upper.from_the_other_side
        self._gap = pair.gap(x, y)
        self._edge = (np.abs(x) > np.abs(x).max() * (1 - 1e-9)) | (y > y.max() * (1 - 1e-9))
        self.unknowns = lower.unknowns + (0 if upper is lower else upper.unknowns)

    def force(self, penetration: float, held: bool = False) -> float:
        """Contact force of the two bodies that have come together by `penetration` since first touch."""
        forces = pressed(self._compliance + (self._from_the_other_sides if held else 0.0), penetration - self._gap)
        if forces[self._edge].any():
            raise RuntimeError("the contact is wider than the nodes that may touch")
        return self._parts * float(forces.sum())
