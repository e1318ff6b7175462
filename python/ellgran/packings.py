# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies in a box: who is near whom, all contacts, and a packing made by the law itself."""
from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any, Iterable, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import in_place
from .bodies import Bodies, Floats
from .contact_arrays import Contacts, contacts
from .law import Law, Laws, as_laws

Integers = NDArray[np.int32]


class Box:
    """A parallelepiped, periodic or not along each of its edges.

    Parameters
    ----------
    origin : array_like, shape (3,)
        Its lowest corner, length.
    edges : array_like, shape (3, 3) or (3,)
        Its edges a, b, c as rows, length; three numbers are the edges of an upright box.
    periodic : bool or sequence of 3 bool
        Along which edges the box repeats.
    """

    def __init__(self, origin: ArrayLike, edges: ArrayLike, periodic: Union[bool, ArrayLike] = True) -> None:
        rows = np.asarray(edges, dtype=np.float64)
        if rows.ndim == 1:
            rows = np.diag(rows)
        self.origin: Floats = in_place(origin, (3,), "origin")
        self.edges: Floats = in_place(rows, (3, 3), "edges")
        self.periodic: NDArray[np.bool_] = np.broadcast_to(np.asarray(periodic, dtype=bool), (3,)).copy()
        if not self.volume > 0.0:
            raise ValueError(f"edges {rows.tolist()} span no volume, or are left-handed")

    @classmethod
    def around(cls, bodies: Bodies) -> Box:
        """The smallest upright box that holds the bounding spheres of all bodies; not periodic."""
        radius = bodies.semi_axes.max(axis=1, keepdims=True)
        low, high = (bodies.positions - radius).min(axis=0), (bodies.positions + radius).max(axis=0)
        return cls(low, high - low, periodic=False)

    @property
    def volume(self) -> float:
        """Its volume, length^3."""
        return float(np.linalg.det(self.edges))

    def wrapped(self, positions: ArrayLike) -> Floats:
        """The images of these positions, shape (n, 3), that lie in the box along its periodic edges."""
        fractions = (np.asarray(positions) - self.origin) @ np.linalg.inv(self.edges)
        turns = np.where(self.periodic, np.floor(fractions), 0.0)
        return np.asarray(np.asarray(positions) - turns @ self.edges)

    def __repr__(self) -> str:
        return f"Box({self.origin.tolist()}, {self.edges.tolist()}, {self.periodic.tolist()})"


class PackingContacts(Contacts):
    """The touching pairs of a packing; beside the arrays of `Contacts`:

    Attributes
    ----------
    pairs : numpy.ndarray of int32, shape (m, 2)
        Indices of the bodies, i < j but for a body that touches its own image.
    images : numpy.ndarray of int32, shape (m, 3)
        Which periodic image of j it is that i touches, in edges of the box.
    branch : numpy.ndarray, shape (m, 3)
        Vector from the centre of i to that of this image of j, length.
    """

    pairs: Integers
    images: Integers
    branch: Floats


@dataclass
class Packing:
    """Bodies in a box.

    Attributes
    ----------
    bodies : Bodies
    box : Box
    """

    bodies: Bodies
    box: Box

    @property
    def solid_fraction(self) -> float:
        """Volume of the bodies over that of the box, overlaps counted twice."""
        return float(self.bodies.volumes.sum() / self.box.volume)

    def neighbours(self, distance: float = 0.0) -> Tuple[Integers, Integers]:
        """Pairs whose bounding spheres are closer than this, each once.

        Parameters
        ----------
        distance : float
            Largest gap between the bounding spheres, length, >= 0.

        Returns
        -------
        pairs, images : numpy.ndarray of int32, shapes (m, 2) and (m, 3)
            As in `PackingContacts`. A small periodic box can bring a pair several times, with other images.
        """
        return _neighbours(self.bodies, self.box, distance)

    def indices(self, identifiers: ArrayLike) -> Integers:
        """Where the bodies with these identifiers stand, in the shape of `identifiers`.

        Raises
        ------
        ValueError
            No body has one of them.
        """
        wanted = np.asarray(identifiers, dtype=np.int64)
        order = np.argsort(self.bodies.identifiers, kind="stable")
        known = self.bodies.identifiers[order]
        places = np.minimum(np.searchsorted(known, wanted), max(len(known) - 1, 0))
        missing = wanted[known[places] != wanted] if len(known) else wanted.ravel()
        if len(missing):
            raise ValueError(f"no body has the identifier {missing[0]}")
        return order[places].astype(np.int32)

    def network(self, pairs: ArrayLike, images: Optional[ArrayLike] = None) -> Tuple[Floats, Integers]:
        """Pairs as straight lines from centre to centre, for programs that draw points and lines.

        Parameters
        ----------
        pairs : array_like of int, shape (m, 2)
            Indices of the bodies; of a dump's identifiers, `indices` gives them.
        images : array_like of int, shape (m, 3), optional
            Which periodic image of the second body is meant, in edges of the box, as in `PackingContacts`; default: the nearest, by
            the difference in parts of the edges.

        Returns
        -------
        points : numpy.ndarray, shape (2 m, 3)
            Length. Those of one line are next to each other, so that a line over a periodic boundary ends beyond it.
        lines : numpy.ndarray of int32, shape (m, 2)
            Indices of the points.
        """
        ends = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
        first, second = self.bodies.positions[ends[:, 0]], self.bodies.positions[ends[:, 1]]
        if images is None:
            fractions = (second - first) @ np.linalg.inv(self.box.edges)
            images = np.where(self.box.periodic, -np.round(fractions), 0.0)
        second = second + np.asarray(images).reshape(-1, 3) @ self.box.edges
        points = np.stack([first, second], axis=1).reshape(-1, 3)
        return points, np.arange(len(points), dtype=np.int32).reshape(-1, 2)

    def contacts(
        self, laws: Union[Laws, Law, str], *, quantities: Optional[Iterable[str]] = None
    ) -> PackingContacts:
        """All touching pairs with their geometry and forces at this instant, as contacts that begin now.

        Parameters
        ----------
        laws : Laws, Law or str
            The laws between the types of the bodies.
        quantities : iterable of str, optional
            As in `contacts`.

        Returns
        -------
        PackingContacts
            Without what friction remembers; forces of friction are of an engine's dump, see `read_dump`.
        """
        return self.contacts_of(laws, *self.neighbours(), quantities=quantities)

    def contacts_of(
        self,
        laws: Union[Laws, Law, str],
        pairs: Integers,
        images: Integers,
        *,
        quantities: Optional[Iterable[str]] = None,
    ) -> PackingContacts:
        """The same for given neighbours, which serve as long as no body has moved by half of their `distance`."""
        bodies = self.bodies
        crosses = np.flatnonzero(images.any(axis=1))
        shifts = images[crosses] @ self.box.edges
        which = pairs
        if len(crosses):
            ghosts = bodies[pairs[crosses, 1]]
            ghosts.positions += shifts
            which = pairs.copy()
            which[crosses, 1] = len(bodies) + np.arange(len(crosses))
            bodies = Bodies.joined(bodies, ghosts)
        found = contacts(laws, bodies, which, quantities=quantities)
        kept = found.touching
        result = PackingContacts(int(kept.sum()), [])
        for name in found._names:
            setattr(result, name, getattr(found, name)[kept])
        result._names = found._names
        result.touching = found.touching[kept]
        result.pairs, result.images = pairs[kept], images[kept]
        ends = which[kept]
        result.branch = bodies.positions[ends[:, 1]] - bodies.positions[ends[:, 0]]
        return result


def _neighbours(bodies: Bodies, box: Box, distance: float) -> Tuple[Integers, Integers]:
    if not distance >= 0.0:
        raise ValueError(f"distance = {distance} must be 0 or greater")
    count = len(bodies)
    if count == 0:
        return np.zeros((0, 2), np.int32), np.zeros((0, 3), np.int32)
    if not np.isfinite(bodies.positions).all():
        wrong = int(np.flatnonzero(~np.isfinite(bodies.positions).all(axis=1))[0])
        raise ValueError(
            f"particle {bodies.identifiers[wrong]}: position {bodies.positions[wrong].tolist()} is not finite"
        )
    radius = bodies.semi_axes.max(axis=1)
    reach = 2.0 * float(radius.max()) + distance
    to_fractions = np.linalg.inv(box.edges)
    fractions = (bodies.positions - box.origin) @ to_fractions
    turns = np.where(box.periodic, np.floor(fractions), 0.0)
    fractions -= turns
    low = np.where(box.periodic, 0.0, fractions.min(axis=0))
    span = np.where(box.periodic, 1.0, np.maximum(fractions.max(axis=0) - low, 1e-300))
    # The distance between opposite faces is 1 over the length of a column of the inverse.
    width = span / np.linalg.norm(to_fractions, axis=0)
    most = 2 * int(np.ceil(count ** (1.0 / 3.0)))
    cells = np.clip(np.floor(width / reach), 1, most).astype(np.int64)
    beside = np.where(box.periodic, np.ceil(reach / (width / cells)), np.minimum(cells - 1, 1)).astype(np.int64)
    cell = np.clip(((fractions - low) / span * cells).astype(np.int64), 0, cells - 1)
    strides = np.array([cells[1] * cells[2], cells[2], 1])
    number = cell @ strides
    order = np.argsort(number, kind="stable")
    size = np.bincount(number, minlength=int(cells.prod()))
    start = np.cumsum(size) - size
    positions = fractions @ box.edges
    all_pairs, all_images = [], []
    for offset in product(*[range(-n, n + 1) for n in beside]):
        if offset < (0, 0, 0):
            continue
        target = cell + np.array(offset)
        image = np.where(box.periodic, target // cells, 0)
        target -= image * cells
        inside = ((target >= 0) & (target < cells)).all(axis=1)
        here = np.flatnonzero(inside)
        there = target[here] @ strides
        sizes = size[there]
        i = np.repeat(here, sizes)
        within = np.arange(len(i)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        j = order[np.repeat(start[there], sizes) + within]
        shift = image[i]
        if offset == (0, 0, 0):
            once = i < j
            i, j, shift = i[once], j[once], shift[once]
        d = positions[j] + shift @ box.edges - positions[i]
        near = np.einsum("ij,ij->i", d, d) < (radius[i] + radius[j] + distance) ** 2
        i, j, shift = i[near], j[near], shift[near]
        turned = (shift + turns[i] - turns[j]).astype(np.int32)
        backwards = i > j
        i, j = np.where(backwards, j, i), np.where(backwards, i, j)
        turned[backwards] *= -1
        all_pairs.append(np.stack([i, j], axis=1).astype(np.int32))
        all_images.append(turned)
    pairs, images = np.concatenate(all_pairs), np.concatenate(all_images)
    sorted_by = np.lexsort((images[:, 2], images[:, 1], images[:, 0], pairs[:, 1], pairs[:, 0]))
    return np.ascontiguousarray(pairs[sorted_by]), np.ascontiguousarray(images[sorted_by])


def random_rotations(count: int, generator: np.random.Generator) -> Floats:
    """Quaternions ``w x y z`` of uniformly distributed rotations, shape (count, 4)."""
    quaternions = generator.normal(size=(count, 4))
    return np.asarray(quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True))


def packing(
    law: Union[Laws, Law, str],
    semi_axes: ArrayLike,
    solid_fraction: float,
    *,
    count: int = 100,
    density: float = 1.0,
    types: ArrayLike = 1,
    seed: int = 0,
    tolerance: float = 1e-3,
    most_steps: int = 20_000,
) -> Packing:
    """A periodic cube of ellipsoids, compressed to a solid fraction and relaxed until forces and torques balance.

    Parameters
    ----------
    law : Laws, Law or str
        The law that pushes them apart; friction and viscosity play no part, since nothing moves in the end.
    semi_axes : array_like, shape (count, 3), (3,) or ()
        Length.
    solid_fraction : float
        Volume of the bodies over that of the box, > 0, below 0.9.
    count : int
        Number of bodies.
    density : float
        Mass/volume of the bodies.
    types : array_like of int, shape (count,) or ()
        Types in the laws.
    seed : int
        Of the random positions and rotations: the same seed gives the same packing.
    tolerance : float
        Largest sum of forces, and of torques over the radius, on a body, in mean normal forces.
    most_steps : int
        After so many steps of relaxation without balance it fails.

    Returns
    -------
    Packing
        Bodies at rest. Below the densest loose fraction of the shape (about 0.64 for spheres, to 0.7 for ellipsoids) nothing
        touches, or hardly.

    Raises
    ------
    RuntimeError
        No balance within `most_steps`.
    """
    if not 0.0 < solid_fraction < 0.9:
        raise ValueError(f"solid_fraction = {solid_fraction} must be above 0 and below 0.9")
    if count < 1:
        raise ValueError(f"count = {count} must be 1 or greater")
    laws = as_laws(law)
    generator = np.random.default_rng(seed)
    bodies = Bodies(
        generator.random((count, 3)), semi_axes, random_rotations(count, generator), density=density, types=types
    )
    volume = float(bodies.volumes.sum())
    fraction = min(solid_fraction, 0.25)
    edge = (volume / fraction) ** (1.0 / 3.0)
    bodies.positions *= edge
    result = Packing(bodies, Box(np.zeros(3), np.full(3, edge)))
    steps = 0
    while True:
        last = fraction >= solid_fraction
        steps += _relax(result, laws, *((tolerance, 1e-5) if last else (0.1, 1e-3)), most_steps - steps)
        if last:
            return result
        fraction = min(solid_fraction, 1.05 * fraction)
        shorter = (volume / fraction) ** (1.0 / 3.0)
        bodies.positions *= shorter / edge
        edge = shorter
        result.box = Box(np.zeros(3), np.full(3, edge))


def _relax(state: Packing, laws: Laws, tolerance: float, free: float, most_steps: int) -> int:
    """Moves and turns the bodies downhill until forces balance, by FIRE (Bitzek et al., Phys. Rev. Lett. 97 (2006) 170201);
    the number of steps that it took."""
    bodies = state.bodies
    count = len(bodies)
    radius = bodies.semi_axes.max(axis=1, keepdims=True)
    least = float(bodies.semi_axes.min())
    # Lengths in which nothing is far: turns count by the path of a grain's end.
    margin = 0.2 * float(radius.max())
    speeds = np.zeros((count, 6))
    step, mixing, downhill = 1.0, 0.1, 0
    pairs = images = built = None
    for taken in range(most_steps):
        if built is None or np.abs(bodies.positions - built).max() > 0.2 * margin:
            pairs, images = state.neighbours(margin)
            built = bodies.positions.copy()
        assert pairs is not None and images is not None
        found = state.contacts_of(
            laws, pairs, images, quantities=["force", "torque_i", "torque_j", "normal_force", "penetration"]
        )
        # Grains that are free to part do so ever more slowly.
        if len(found) == 0 or found.penetration.max() < free * least:
            return taken
        loads = np.zeros((count, 6))
        i, j = found.pairs.T
        for axis in range(3):
            loads[:, axis] = np.bincount(j, found.force[:, axis], count) - np.bincount(i, found.force[:, axis], count)
            loads[:, 3 + axis] = np.bincount(i, found.torque_i[:, axis], count) + np.bincount(
                j, found.torque_j[:, axis], count
            )
        loads[:, 3:] /= radius
        mean = float(found.normal_force.mean())
        if np.abs(loads).max() <= tolerance * mean:
            return taken
        # The stiffest contact sets the unit of force per length: a step of 1 is then a stable one.
        stiffness = float((1.5 * found.normal_force / found.penetration).max()) * 12.0
        acceleration = loads / stiffness
        power = float((acceleration * speeds).sum())
        if power > 0.0:
            downhill += 1
            ratio = np.linalg.norm(speeds) / max(float(np.linalg.norm(acceleration)), 1e-300)
            speeds = (1.0 - mixing) * speeds + mixing * ratio * acceleration
            if downhill > 5:
                step, mixing = min(1.1 * step, 1.5), 0.99 * mixing
        else:
            speeds[:] = 0.0
            step, mixing, downhill = 0.5 * step, 0.1, 0
            step = max(step, 0.1)
        speeds += step * acceleration
        moved = step * speeds
        largest = float(np.abs(moved).max())
        if largest > 0.1 * margin:
            moved *= 0.1 * margin / largest
        bodies.positions += moved[:, :3]
        turned(bodies.quaternions, moved[:, 3:] / radius, out=bodies.quaternions)
    raise RuntimeError(
        f"forces do not balance within {most_steps} steps: give a larger tolerance or more of most_steps"
    )


def turned(quaternions: Floats, rotation: Floats, out: Optional[Floats] = None) -> Floats:
    """Quaternions ``w x y z``, shape (n, 4), after a further rotation by vectors in the world frame, shape (n, 3), radian."""
    angle = np.linalg.norm(rotation, axis=1, keepdims=True)
    w = np.cos(0.5 * angle)
    v = rotation * (0.5 * np.sinc(0.5 * angle / np.pi))
    w0, v0 = quaternions[:, :1], quaternions[:, 1:]
    product_w = w * w0 - (v * v0).sum(axis=1, keepdims=True)
    product_v = w * v0 + w0 * v + np.cross(v, v0)
    result: Any = np.empty_like(quaternions) if out is None else out
    result[:, :1], result[:, 1:] = product_w, product_v
    result /= np.linalg.norm(result, axis=1, keepdims=True)
    return np.asarray(result)
