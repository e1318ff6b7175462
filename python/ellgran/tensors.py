# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a packing's contacts and grains say as a whole: coordination, fabric, orientation, stress."""
from __future__ import annotations

from typing import Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .bodies import Bodies, Floats
from .packings import Packing, PackingContacts


def coordination_numbers(contacts: PackingContacts, count: int) -> NDArray[np.int64]:
    """Contacts of each body, shape (count,); their mean is twice the number of contacts over `count`.

    Parameters
    ----------
    contacts : PackingContacts
    count : int
        Number of bodies.

    Raises
    ------
    ValueError
        A contact names a body that is not one of `count`.
    """
    numbers = np.bincount(contacts.pairs.ravel(), minlength=count)
    if len(numbers) > count:
        raise ValueError(f"contacts name body {len(numbers) - 1}, which is not one of {count}")
    return numbers


def fabric_tensor(normals: ArrayLike, weights: Optional[ArrayLike] = None) -> Floats:
    """Mean of ``n n^T`` over contacts, shape (3, 3): trace 1, a third of the unit matrix where normals have no direction.

    Parameters
    ----------
    normals : array_like, shape (m, 3)
        Unit vectors; their sign does not matter.
    weights : array_like, shape (m,), optional
        Such as normal forces; default: all alike.
    """
    n = np.asarray(normals, dtype=np.float64)
    w = np.ones(len(n)) if weights is None else np.asarray(weights, dtype=np.float64)
    if not w.sum() > 0.0:
        raise ValueError("a fabric tensor needs at least one contact, and weights of positive sum")
    return np.asarray(np.einsum("k,ki,kj->ij", w, n, n) / w.sum())


def body_axes(bodies: Bodies, which: Union[str, int] = "longest") -> Floats:
    """Unit vectors along one body axis of each body, world frame, shape (n, 3).

    Parameters
    ----------
    which : "longest", "shortest", 0, 1 or 2
        Of equal semi-axes the first is taken.
    """
    if which == "longest":
        index = bodies.semi_axes.argmax(axis=1)
    elif which == "shortest":
        index = bodies.semi_axes.argmin(axis=1)
    elif which in (0, 1, 2):
        index = np.full(len(bodies), which)
    else:
        raise ValueError(f"which = {which!r} is none of 'longest', 'shortest', 0, 1, 2")
    return np.asarray(bodies.rotations[np.arange(len(bodies)), :, index])


def orientation_tensor(bodies: Bodies, which: Union[str, int] = "longest") -> Floats:
    """Mean of ``u u^T`` over the axes of the bodies, shape (3, 3): trace 1, a third of the unit matrix without order."""
    return fabric_tensor(body_axes(bodies, which))


def nematic_order(bodies: Bodies, which: Union[str, int] = "longest") -> Tuple[float, Floats]:
    """Order of the axes and the direction that they prefer.

    Returns
    -------
    order : float
        The largest eigenvalue of ``(3 Q - 1)/2`` with the orientation tensor ``Q``: 1 where all axes are parallel, 0 without
        order.
    director : numpy.ndarray, shape (3,)
        Its unit eigenvector, of either sign.
    """
    values, vectors = np.linalg.eigh(orientation_tensor(bodies, which))
    return float(1.5 * values[-1] - 0.5), np.asarray(vectors[:, -1])


def stress_tensor(contacts: PackingContacts, packing: Packing, *, kinetic: bool = False) -> Floats:
    """Stress of a packing, shape (3, 3), pressure: ``sum d f^T / V``, positive in compression.

    ``d`` is the vector from the centre of i to that of j, ``f`` the force on j, ``V`` the volume of the box.

    Parameters
    ----------
    contacts : PackingContacts
        All contacts of the packing; with walls, those with the walls are missing in the sum.
    packing : Packing
    kinetic : bool
        Adds ``sum m v v^T / V`` of velocities relative to their mean.
    """
    total = np.einsum("ki,kj->ij", contacts.branch, contacts.force)
    if kinetic:
        m, v = packing.bodies.masses, packing.bodies.velocities
        relative = v - np.average(v, axis=0, weights=m)
        total = total + np.einsum("k,ki,kj->ij", m, relative, relative)
    return np.asarray(total / packing.box.volume)
