# SPDX-License-Identifier: MIT OR Apache-2.0
"""Finite elements: a free elastic ellipsoid that is touched at its top, reduced to what its contact can move.

Quadratic hexahedra of 27 nodes, small strain. The body's plane of symmetry y = 0 is used: half of it is meshed. In the contact the mesh is
a grid that is graded to the contact ellipse; from there shells grow to the far side.

The motion of the contact's nodes is the sum of

- the rigid motion,
- the lowest vibrations, with their inertia,
- the flexibility of all other vibrations, without inertia: they follow the force at once.

The last is what makes the contact well posed: its nodes have no mass of their own, and no force that a single node would need to be stopped
with. How many vibrations keep their inertia is a number to converge in, as the mesh is.
"""
from __future__ import annotations

from typing import Callable, NamedTuple, Tuple

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg

_GAUSS = (np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]), np.array([5.0, 8.0, 5.0]) / 9.0)
#: Where the far shells begin, as a distance from the touching point of the unit ball, and where the rim of the last one lies.
_FAR, _LAST_RIM = 1.15, 1.55
#: The contact's grid is as wide as this part of the contact's semi-axes.
WIDTH = 1.2


class Grid(NamedTuple):
    """Elements across the contact's grid (even), in its depth, and how shells grow; two nodes an element."""

    across: int
    deep: int
    growth: float


def _smooth_step(x: np.ndarray) -> np.ndarray:
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


class Mesh:
    """Half of an ellipsoid of shape matrix `shape`, which touches the plane z = 0 from below at the origin.

    `half_widths` are those of the contact's grid along x and y. The mesh follows the contact's shape and its normal within `reach` of the touching
    point of the unit ball.
    """

    def __init__(self, shape: np.ndarray, half_widths: Tuple[float, float], grid: Grid, reach: float = 0.95) -> None:
        n, m = grid.across, grid.deep
        support = np.sqrt(shape[2, 2])
        #: Of the centre; the touching point is the origin.
        self.centre = -shape[:, 2] / support
        # Unit ball to ellipsoid: the pole of the ball goes to the touching point.
        affine = np.zeros((3, 3))
        affine[2, 2] = support
        affine[0, 2] = shape[0, 2] / support
        affine[0, 0] = np.sqrt(shape[0, 0] - affine[0, 2] ** 2)
        affine[1, 1] = np.sqrt(shape[1, 1])
        widths = np.array([half_widths[0] / affine[0, 0], half_widths[1] / affine[1, 1]])
        core = float(np.sqrt(widths[0] * widths[1]))
        stretch = float(np.sqrt(widths[0] / widths[1]))
        radii = [core]
        while radii[-1] * np.sqrt(grid.growth) < _FAR:
            radii.append(radii[-1] * grid.growth)
        radii = core * (_FAR / core) ** (np.arange(len(radii)) / (len(radii) - 1.0))
        between = len(radii) - 1
        far = max(2, int(round(0.8 / (radii[-1] - radii[-2]))))
        layers = between + far

        # Integer places of nodes: (i, j, k) in the box of the core, and the layer, 0 in the core.
        def key(i, j, k, layer):
            return ((layer * (2 * m + 1) + k) * (n + 1) + j) * (2 * n + 1) + i

        step = np.arange(3)
        cells = []
        corner = [np.ravel(x) for x in np.meshgrid(np.arange(0, 2 * n, 2), np.arange(0, n, 2), np.arange(0, 2 * m, 2), indexing="ij")]
        local = [np.ravel(x) for x in np.meshgrid(step, step, step, indexing="ij")]
        cells.append(key(corner[0][:, None] + local[0], corner[1][:, None] + local[1], corner[2][:, None] + local[2], 0))

        def extruded(i: Callable, j: Callable, k: Callable, first: int, second: int) -> None:
            """Over a face of the box, two coordinates of which run to `first` and `second`."""
            a, b, c = (np.ravel(x) for x in np.meshgrid(np.arange(0, first, 2), np.arange(0, second, 2), np.arange(0, 2 * layers, 2), indexing="ij"))
            a, b, c = a[:, None] + local[0], b[:, None] + local[1], c[:, None] + local[2]
            cells.append(key(i(a, b), j(a, b), k(a, b), c))

        extruded(lambda a, b: a, lambda a, b: b, lambda a, b: 0 * a + 2 * m, 2 * n, n)
        extruded(lambda a, b: 0 * a, lambda a, b: a, lambda a, b: b, n, 2 * m)
        extruded(lambda a, b: 0 * a + 2 * n, lambda a, b: a, lambda a, b: b, n, 2 * m)
        extruded(lambda a, b: a, lambda a, b: 0 * a + n, lambda a, b: b, 2 * n, 2 * m)
        keys, cells = np.unique(np.concatenate(cells), return_inverse=True)
        #: Nodes of each element, in the order of a lattice.
        self.cells = cells.reshape(-1, 27)
        i, j = keys % (2 * n + 1), keys // (2 * n + 1) % (n + 1)
        k, layer = keys // ((2 * n + 1) * (n + 1)) % (2 * m + 1), keys // ((2 * n + 1) * (n + 1) * (2 * m + 1))

        # The box of the core, rounded towards a half ball.
        box = np.stack([i / n - 1.0, j / n, -k / (2.0 * m)], axis=1)
        size = np.abs(box).max(axis=1)
        length = np.linalg.norm(box, axis=1)
        unit = box / np.where(length > 0, length, 1.0)[:, None]
        roundness = np.where(layer > 0, 0.55 + 0.45 * _smooth_step(layer / 6.0), 0.55 * size)
        rho = size * ((1 - roundness) * length / np.where(size > 0, size, 1.0) + roundness)
        from_axis = np.arctan2(np.hypot(unit[:, 0], unit[:, 1]), -unit[:, 2])
        azimuth = np.arctan2(unit[:, 1], unit[:, 0])
        part = from_axis / (0.5 * np.pi)

        def at(distance: np.ndarray, angle: np.ndarray) -> np.ndarray:
            """Seen from the pole of the unit ball, whose centre is the origin."""
            sideways = distance * np.sin(angle)
            return np.stack([sideways * np.cos(azimuth), sideways * np.sin(azimuth), 1.0 - distance * np.cos(angle)], axis=1)

        near = np.clip(layer / (2.0 * between), 0.0, 1.0)
        distance = rho * core * (radii[-1] / core) ** near
        distance = np.where(layer >= 2 * between, radii[-1], distance)
        ball = at(distance, part * np.arccos(0.5 * distance))
        last_angle = part * np.arccos(0.5 * _LAST_RIM)
        last = at(2.0 * np.cos(last_angle), last_angle)
        beyond = np.clip((layer - 2.0 * between) / (2.0 * far), 0.0, 1.0)[:, None]
        ball = (1 - beyond) * ball + beyond * last
        outwards = np.linalg.norm(ball, axis=1)
        ball *= (1.0 + part**6 * (1.0 / np.where(part == 1, outwards, 1.0) - 1.0) * (part == 1))[:, None]
        # Stretched to the contact ellipse, and moved so that the nodes of the contact lie at the same places beside the normal on both sides.
        weight = 1.0 - _smooth_step((np.linalg.norm(ball - [0, 0, 1], axis=1) - 1.2 * core) / (reach - 1.2 * core))
        depth = np.sqrt(np.maximum(1.0 - ball[:, 0] ** 2 - ball[:, 1] ** 2, 0.0)) - ball[:, 2]
        wanted = ball[:, :2] * np.stack([stretch**weight, stretch**-weight], axis=1)
        place = wanted.copy()
        for _ in range(100):
            sunk = np.sqrt(np.maximum(1.0 - (place**2).sum(axis=1), 0.0)) - 1.0
            place[:, 0] = wanted[:, 0] - weight * affine[0, 2] / affine[0, 0] * sunk
        moved = np.column_stack([place, np.sqrt(np.maximum(1.0 - (place**2).sum(axis=1), 0.0)) - depth])
        ball = np.where((weight > 0)[:, None], moved, ball)
        #: Places of the nodes.
        self.nodes = ball @ affine.T + self.centre
        self.on_symmetry_plane = j == 0
        self.nodes[self.on_symmetry_plane, 1] = 0.0
        top = np.flatnonzero((layer == 0) & (k == 0))
        #: Nodes that may touch, by rows along x.
        self.top = top[np.lexsort((i[top], j[top]))]
        self.row = 2 * n + 1

    def gradients(self) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values of the shape functions at the Gauss points, their gradients in each element, and the volumes of these points."""
        points, weights = _GAUSS
        one = np.stack([0.5 * points * (points - 1), 1 - points**2, 0.5 * points * (points + 1)])
        slope = np.stack([points - 0.5, -2 * points, points + 0.5])
        value = np.einsum("ax,by,cz->xyzabc", one, one, one).reshape(27, 27)
        local = np.stack(
            [
                np.einsum("ax,by,cz->xyzabc", *(slope if axis == which else one for axis in range(3))).reshape(27, 27)
                for which in range(3)
            ],
            axis=2,
        )
        weight = np.einsum("x,y,z->xyz", weights, weights, weights).ravel()
        jacobian = np.einsum("qad,eax->eqdx", local, self.nodes[self.cells])
        determinant = np.linalg.det(jacobian)
        if np.any(np.sign(determinant) != np.sign(determinant[:, :1])):
            raise RuntimeError("an element of the mesh is turned inside out")
        gradient = np.einsum("eqxd,qad->eqax", np.linalg.inv(jacobian), local)
        return value, gradient, np.abs(determinant) * weight

    def matrices(self, poisson: float) -> Tuple[sparse.csc_matrix, sparse.csc_matrix]:
        """Stiffness and mass at modulus and density 1; three unknowns a node."""
        value, gradient, volume = self.gradients()
        count = len(self.cells)
        flat = gradient.reshape(count, 27, 81)
        product = np.matmul((flat * volume[:, :, None]).transpose(0, 2, 1), flat).reshape(count, 27, 3, 27, 3)
        shear = 0.5 / (1 + poisson)
        lame = poisson / ((1 + poisson) * (1 - 2 * poisson))
        stiffness = lame * product + shear * product.transpose(0, 1, 4, 3, 2)
        inner = shear * np.einsum("eaibi->eab", product)
        mass = np.einsum("qa,qb,eq->eab", value, value, volume)
        for axis in range(3):
            stiffness[:, :, axis, :, axis] += inner
        unknowns = (3 * self.cells[:, :, None] + np.arange(3)).reshape(count, 81)
        rows, columns = np.repeat(unknowns, 81, axis=1).ravel(), np.tile(unknowns, (1, 81)).ravel()
        size = 3 * len(self.nodes)
        whole = sparse.coo_matrix((stiffness.ravel(), (rows, columns)), shape=(size, size)).tocsc()
        rows, columns = np.repeat(self.cells, 27, axis=1).ravel(), np.tile(self.cells, (1, 27)).ravel()
        scalar = sparse.coo_matrix((mass.ravel(), (rows, columns)), shape=(size // 3, size // 3))
        return whole, sparse.kron(scalar, sparse.identity(3)).tocsc()


class FreeBody(NamedTuple):
    """Half of the body, reduced. Forces are those on this half; `displacement = shapes @ amplitudes + flexibility @ force`, with
    unknowns in the order x of all nodes of the contact, y, z."""

    #: Of the contact's nodes in the plane z = 0, shape (nodes, 2).
    places: np.ndarray
    row: int
    #: From the touching point, at rest.
    centre: np.ndarray
    #: Of the half body as it is meshed; the moment is about the axis y.
    mass: float
    moment: float
    frequencies: np.ndarray
    shapes: np.ndarray
    flexibility: np.ndarray
    unknowns: int


def free_body(shape: np.ndarray, poisson: float, half_widths: Tuple[float, float], grid: Grid, vibrations: int) -> FreeBody:
    """Modulus and density 1."""
    mesh = Mesh(shape, half_widths, grid)
    stiffness, mass = mesh.matrices(poisson)
    kept = np.ones(stiffness.shape[0], dtype=bool)
    kept[1::3] = ~mesh.on_symmetry_plane
    stiffness, mass = stiffness[kept][:, kept], mass[kept][:, kept]
    arm = mesh.nodes - mesh.centre
    rigid = np.zeros((3, len(kept)))
    rigid[0, 0::3], rigid[1, 2::3] = 1.0, 1.0
    rigid[2, 0::3], rigid[2, 2::3] = arm[:, 2], -arm[:, 0]
    rigid = rigid[:, kept].T
    inertia = rigid.T @ (mass @ rigid)
    # The vibrations' frequencies are of the order of 1 over the body's size: this shift is small beside their squares.
    shift = 1e-3 / float(np.max(np.abs(arm))) ** 2
    solve = factorised((stiffness + shift * mass).tocsc())
    operator = scipy.sparse.linalg.LinearOperator(stiffness.shape, matvec=solve)
    squares, modes = scipy.sparse.linalg.eigsh(
        stiffness, k=vibrations + 3, M=mass, sigma=-shift, OPinv=operator, v0=np.random.default_rng(1).standard_normal(stiffness.shape[0])
    )
    order = np.argsort(squares)
    squares, modes = squares[order], modes[:, order]
    if squares[2] > 1e-3 * squares[3]:
        raise RuntimeError("the body has not three rigid motions in its plane")
    squares[:3] = 0.0
    number = np.cumsum(kept) - 1
    touching = np.concatenate([3 * mesh.top + axis for axis in range(3)])
    flexibility = np.zeros((len(touching), len(touching)))
    shapes = np.zeros((len(touching), vibrations))
    free = np.flatnonzero(kept[touching])
    rows = number[touching[free]]
    shapes[free] = modes[rows, 3:]
    for first in range(0, len(free), 64):
        columns = free[first : first + 64]
        load = np.zeros((stiffness.shape[0], len(columns)))
        load[number[touching[columns]], np.arange(len(columns))] = 1.0
        flexibility[np.ix_(free, columns)] = solve(load)[rows]
    flexibility[np.ix_(free, free)] -= (modes[rows] / (squares + shift)) @ modes[rows].T
    return FreeBody(
        places=mesh.nodes[mesh.top, :2],
        row=mesh.row,
        centre=mesh.centre,
        mass=float(inertia[0, 0]),
        moment=float(inertia[2, 2]),
        frequencies=np.sqrt(squares[3:]),
        shapes=shapes,
        flexibility=0.5 * (flexibility + flexibility.T),
        unknowns=stiffness.shape[0],
    )


def factorised(matrix: sparse.csc_matrix) -> Callable[[np.ndarray], np.ndarray]:
    """Solves with a symmetric matrix."""
    return scipy.sparse.linalg.splu(
        matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    ).solve
