# SPDX-License-Identifier: MIT OR Apache-2.0
"""Finite elements: a whole spheroid, pressed at its tip against its mirror image, small strain, by the package scikit-fem.

The mirror image of an equal spheroid is a rigid frictionless plane, so one body in axial symmetry (r, z) is enough. The mesh is in
circles about the touching tip, so that elements shrink towards it as a geometric series. The compliance of the nodes near the tip is
computed once; which of them touch, and with what force, then follows from the inequalities alone.

Far from the contact the body is held in one of two ways:

- ``free``: nothing holds it. Its inertia balances the contact force, and where it is is where its centre of mass is. It is the
  grain of a collision.
- ``held``: an equal force acts on the other tip, and it is where its middle plane is. It is a grain of a chain at rest.
"""
from __future__ import annotations

from typing import Tuple

import numpy as np
import scipy.sparse.linalg
import skfem
from scipy.optimize import nnls
from skfem.helpers import sym_grad, trace

MODULUS, POISSON = 1.0, 0.3


def _mesh(contact: float, elements: int, aspect: float) -> skfem.MeshTri:
    """The half section r >= 0 of a spheroid of semi-axes (1, aspect), the touching tip at the top; `elements` along the contact
    radius and as many around the tip. Circles about the tip must meet the surface once: aspect^2 > 1/2."""
    step = contact / elements
    radii = [step * k for k in range(1, int(1.6 * elements) + 1)]
    growth = 0.5 * np.pi / elements
    while radii[-1] < 1.9 * aspect:
        radii.append(radii[-1] + growth * min(radii[-1], 1.0))
    if radii[-1] > 1.97 * aspect:
        radii.pop()
    points = [np.array([[0.0], [aspect]])]
    for radius in radii:
        # Where the circle meets the surface (sin t, aspect cos t): 1 - cos t solves 2 u + (aspect^2 - 1) u^2 = radius^2.
        u = radius**2 / (1.0 + np.sqrt(1.0 + (aspect**2 - 1.0) * radius**2))
        angles = np.linspace(0.0, np.arctan2(np.sqrt(u * (2.0 - u)), aspect * u), elements + 1)
        points.append(np.stack([radius * np.sin(angles), aspect - radius * np.cos(angles)]))
    points.append(np.array([[0.0], [-aspect]]))
    triangles = [(0, 1 + k, 2 + k) for k in range(elements)]
    for ring in range(len(radii) - 1):
        first = 1 + ring * (elements + 1)
        for k in range(first, first + elements):
            other = k + elements + 1
            triangles += [(k, other, other + 1), (k, other + 1, k + 1)]
    first = 1 + (len(radii) - 1) * (elements + 1)
    last = first + elements + 1
    triangles += [(k, last, k + 1) for k in range(first, last - 1)]
    nodes = np.concatenate(points, axis=1)
    nodes[0, np.abs(nodes[0]) < 1e-14] = 0.0
    return skfem.MeshTri(nodes, np.ascontiguousarray(np.array(triangles).T))


def pressed(compliance: np.ndarray, overlap: np.ndarray) -> np.ndarray:
    """Forces on nodes, none of which pulls: they undo the `overlap` of the undeformed surfaces where they act, and no overlap is left elsewhere."""
    factor = np.linalg.cholesky(compliance).T
    forces, _ = nnls(factor, np.linalg.solve(factor.T, overlap), maxiter=10_000)
    return forces


class FiniteBody:
    """A spheroid of semi-axes (1, aspect), the second along the axis of symmetry, E = 1, nu = 0.3; meshed for a contact radius."""

    def __init__(self, aspect: float, contact: float, elements: int) -> None:
        mesh = _mesh(contact, elements, aspect)
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP2()), intorder=4)
        shear = MODULUS / (2 * (1 + POISSON))
        lame = MODULUS * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))

        @skfem.BilinearForm
        def stiffness(u, v, w):
            r = w.x[0]
            e, d = sym_grad(u), sym_grad(v)
            hoop, other = u[0] / r, v[0] / r
            volume = (trace(e) + hoop) * (trace(d) + other)
            inner = e[0, 0] * d[0, 0] + e[1, 1] * d[1, 1] + 2 * e[0, 1] * d[0, 1] + hoop * other
            return 2 * np.pi * r * (lame * volume + 2 * shear * inner)

        @skfem.LinearForm
        def along_the_axis(v, w):
            return 2 * np.pi * w.x[0] * v[1]

        matrix = stiffness.assemble(basis)
        inertia = along_the_axis.assemble(basis)
        self._mean = inertia / inertia.sum()
        place = basis.doflocs
        vertical = np.zeros(matrix.shape[0], dtype=bool)
        vertical[np.concatenate([basis.nodal_dofs[1], basis.facet_dofs[1]])] = True
        on_axis = (np.abs(place[0]) < 1e-12) & ~vertical
        pin = np.flatnonzero(vertical & (np.abs(place[0]) < 1e-12))
        pin = pin[np.argmin(np.abs(place[1, pin]))]
        free = np.ones(matrix.shape[0], dtype=bool)
        free[on_axis] = False
        free[pin] = False
        solve = scipy.sparse.linalg.splu(matrix[free][:, free].tocsc()).solve
        surface = np.unique(np.concatenate([basis.get_dofs(mesh.boundary_facets()).all()]))
        near = [k for k in surface if vertical[k] and place[1, k] > 0 and 1e-12 < place[0, k] < 1.5 * contact]
        near = np.array(sorted(near, key=lambda k: place[0, k]))
        self.radii = place[0, near]

        def displacement(load: np.ndarray) -> np.ndarray:
            """Of the centre of mass' frame, under forces that inertia balances."""
            found = np.zeros(matrix.shape[0])
            found[free] = solve((load - load.sum() * self._mean)[free])
            return found - self._mean @ found * vertical

        self.compliance = np.empty((len(near), len(near)))
        for column, k in enumerate(near):
            load = np.zeros(matrix.shape[0])
            load[k] = -1.0
            self.compliance[:, column] = -displacement(load)[near]
        self.compliance = 0.5 * (self.compliance + self.compliance.T)
        load = np.zeros(matrix.shape[0])
        opposite = np.flatnonzero(vertical & (place[1] < -aspect * (1 - 1e-12)))
        load[opposite] = 1.0
        #: How far a unit force on the other tip moves this tip towards the centre of mass.
        self.from_the_other_tip = float(-displacement(load)[near[0]])
        self.gap = aspect * (1.0 - np.sqrt(1.0 - self.radii**2))

    def force(self, penetration: float, held: bool) -> float:
        """Contact force of two such bodies that have come together by `penetration` since first touch."""
        compliance = self.compliance + (self.from_the_other_tip if held else 0.0)
        forces = pressed(compliance, 0.5 * penetration - self.gap)
        if forces[-1] > 0:
            raise RuntimeError("the contact is wider than the nodes that may touch")
        return float(forces.sum())
