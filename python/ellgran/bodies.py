# SPDX-License-Identifier: MIT OR Apache-2.0
"""Ellipsoids as arrays: shapes, poses, motions, masses."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _interface
from ._arrays import in_place, pointer
from ._library import call, sized

Floats = NDArray[np.float64]

_COLUMNS: Dict[str, Tuple[Tuple[int, ...], Any]] = {
    "positions": ((3,), np.float64),
    "semi_axes": ((3,), np.float64),
    "quaternions": ((4,), np.float64),
    "velocities": ((3,), np.float64),
    "angular_velocities": ((3,), np.float64),
    "masses": ((), np.float64),
    "types": ((), np.int32),
    "identifiers": ((), np.int64),
}


class Bodies:
    """Ellipsoids. Arrays of the right type that are C-contiguous are kept as they are, not copied; world frame.

    Parameters
    ----------
    positions : array_like, shape (n, 3)
        Centres, length.
    semi_axes : array_like, shape (n, 3), (3,) or ()
        Semi-axes along the body axes, length; one row serves all bodies, one number is the radius of spheres.
    quaternions : array_like, shape (n, 4), optional
        Rotation from body to world, ``w x y z``, of any length but zero; default: none. OVITO has ``x y z w``.
    velocities, angular_velocities : array_like, shape (n, 3), optional
        Length/time and 1/time, world frame; default: at rest.
    masses : array_like, shape (n,) or (), optional
        Mass; ``inf`` for a body that nothing moves.
    density : array_like, shape (n,) or (), optional
        Mass/volume, in place of `masses`; default: 1.
    types : array_like of int, shape (n,) or (), optional
        Types in the laws, counted from 1; default: 1.
    identifiers : array_like of int, shape (n,), optional
        What an error calls a body; default: its index, from 0.

    Attributes
    ----------
    positions, semi_axes, quaternions, velocities, angular_velocities, masses, types, identifiers : numpy.ndarray
        They can be changed in place and exchanged for others of the same length.
    """

    positions: Floats
    semi_axes: Floats
    quaternions: Floats
    velocities: Floats
    angular_velocities: Floats
    masses: Floats
    types: NDArray[np.int32]
    identifiers: NDArray[np.int64]

    def __init__(
        self,
        positions: ArrayLike,
        semi_axes: ArrayLike,
        quaternions: Optional[ArrayLike] = None,
        *,
        velocities: Optional[ArrayLike] = None,
        angular_velocities: Optional[ArrayLike] = None,
        masses: Optional[ArrayLike] = None,
        density: Optional[ArrayLike] = None,
        types: ArrayLike = 1,
        identifiers: Optional[ArrayLike] = None,
    ) -> None:
        first = in_place(positions, (None, 3), "positions")
        object.__setattr__(self, "positions", first)
        if np.ndim(semi_axes) == 0:
            semi_axes = np.full(3, semi_axes, dtype=np.float64)
        self.semi_axes = semi_axes  # type: ignore[assignment]
        self.quaternions = [1.0, 0.0, 0.0, 0.0] if quaternions is None else quaternions  # type: ignore[assignment]
        self.velocities = np.zeros(3) if velocities is None else velocities  # type: ignore[assignment]
        self.angular_velocities = (
            np.zeros(3) if angular_velocities is None else angular_velocities  # type: ignore[assignment]
        )
        if masses is not None and density is not None:
            raise ValueError("masses and density are both given: leave one out")
        if masses is None:
            masses = self.volumes * (1.0 if density is None else np.asarray(density, dtype=np.float64))
        self.masses = masses  # type: ignore[assignment]
        self.types = types  # type: ignore[assignment]
        self.identifiers = np.arange(len(first)) if identifiers is None else identifiers  # type: ignore[assignment]

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in _COLUMNS:
            raise AttributeError(f"Bodies has no '{name}'")
        shape, kind = _COLUMNS[name]
        object.__setattr__(self, name, in_place(value, (len(self.positions),) + shape, name, kind))

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, index: Any) -> Bodies:
        """The bodies of this slice, mask or array of indices. A slice of step 1 shares the memory."""
        if np.ndim(index) == 0 and not isinstance(index, slice):
            index = [index]
        return Bodies(**{name: getattr(self, name)[index] for name in _COLUMNS})

    def __repr__(self) -> str:
        return f"Bodies({len(self)})"

    def copy(self) -> Bodies:
        """The same bodies in memory of their own."""
        return Bodies(**{name: getattr(self, name).copy() for name in _COLUMNS})

    @staticmethod
    def joined(*parts: Bodies) -> Bodies:
        """One after the other, in new memory."""
        return Bodies(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS})

    @property
    def volumes(self) -> Floats:
        """Volumes of the ellipsoids, shape (n,), length^3."""
        volumes = np.empty(len(self))
        call("ellgran_volumes", len(self), pointer(self.semi_axes), pointer(volumes))
        return volumes

    @property
    def rotations(self) -> Floats:
        """Rotation matrices from body to world, shape (n, 3, 3): the body axes are the columns."""
        q = self.quaternions / np.linalg.norm(self.quaternions, axis=1, keepdims=True)
        w, x, y, z = q.T
        rows = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
        return np.ascontiguousarray(np.array(rows).transpose(2, 0, 1))

    @property
    def inertia(self) -> Floats:
        """Principal moments of inertia of solid ellipsoids, shape (n, 3), mass x length^2."""
        moments = np.empty((len(self), 3))
        call(
            "ellgran_moments_of_inertia", len(self), pointer(self.semi_axes), pointer(self.masses), pointer(moments)
        )
        return moments

    @property
    def quaternions_xyzw(self) -> Floats:
        """The quaternions as OVITO and scipy have them, ``x y z w``, shape (n, 4)."""
        return np.ascontiguousarray(self.quaternions[:, [1, 2, 3, 0]])

    @property
    def shape_tensors(self) -> Floats:
        """``R diag(a) R^T``, shape (n, 3, 3), length: what a unit sphere's points are multiplied by to be an ellipsoid's.

        It is the tensor of tensor glyphs (``vtkTensorGlyph`` with a sphere of radius 1).
        """
        rotations = self.rotations
        return np.asarray((rotations * self.semi_axes[:, None, :]) @ rotations.transpose(0, 2, 1))

    def surfaces(self, latitudes: int = 13, longitudes: int = 24) -> Tuple[Floats, NDArray[np.int64]]:
        """Triangulated surfaces of all bodies, as pyvista (``PolyData.from_regular_faces``) and matplotlib take them.

        Parameters
        ----------
        latitudes, longitudes : int
            Rings from pole to pole along the third body axis, both poles included, and points on a ring.

        Returns
        -------
        points : numpy.ndarray, shape (n * k, 3)
            All of them on the ellipsoids; the k points of a body follow one another.
        triangles : numpy.ndarray of int64, shape (m, 3)
            Indices into `points`, counter-clockwise from outside.
        """
        if latitudes < 3 or longitudes < 3:
            raise ValueError(f"latitudes = {latitudes} and longitudes = {longitudes} must be 3 or more")
        polar = np.linspace(0.0, np.pi, latitudes)[1:-1]
        around = np.arange(longitudes) * (2.0 * np.pi / longitudes)
        ring = np.stack(
            [
                np.outer(np.sin(polar), np.cos(around)),
                np.outer(np.sin(polar), np.sin(around)),
                np.outer(np.cos(polar), np.ones(longitudes)),
            ],
            axis=-1,
        ).reshape(-1, 3)
        unit = np.concatenate([ring, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
        here = np.arange(longitudes)
        beside = (here + 1) % longitudes
        top, bottom = len(ring), len(ring) + 1
        last = (latitudes - 3) * longitudes
        parts = [
            np.stack([np.full(longitudes, top), here, beside], axis=1),
            np.stack([np.full(longitudes, bottom), last + beside, last + here], axis=1),
        ]
        for row in range(latitudes - 3):
            upper, lower = row * longitudes, (row + 1) * longitudes
            parts.append(np.stack([upper + here, lower + here, lower + beside], axis=1))
            parts.append(np.stack([upper + here, lower + beside, upper + beside], axis=1))
        one = np.concatenate(parts)
        points = (unit[None] * self.semi_axes[:, None, :]) @ self.rotations.transpose(0, 2, 1)
        points += self.positions[:, None, :]
        triangles = one[None] + len(unit) * np.arange(len(self))[:, None, None]
        return points.reshape(-1, 3), triangles.reshape(-1, 3).astype(np.int64)

    def _particles(self) -> Any:
        """The struct of pointers; valid while the arrays live."""
        return sized(
            _interface.EllgranParticles,
            owned_count=len(self),
            count=len(self),
            positions=pointer(self.positions),
            velocities=pointer(self.velocities),
            angular_velocities=pointer(self.angular_velocities),
            masses=pointer(self.masses),
            types=pointer(self.types),
            semi_axes=pointer(self.semi_axes),
            semi_axes_stride=3 * ctypes.sizeof(ctypes.c_double),
            quaternions=pointer(self.quaternions),
            quaternions_stride=4 * ctypes.sizeof(ctypes.c_double),
            identifiers=pointer(self.identifiers),
            identifier_bytes=8,
        )
