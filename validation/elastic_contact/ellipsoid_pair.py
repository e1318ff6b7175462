# SPDX-License-Identifier: MIT OR Apache-2.0
"""Two ellipsoids that touch with the common normal along z: where their centres are, and the gap between their surfaces."""
from __future__ import annotations

from typing import NamedTuple, Tuple

import numpy as np

import ellgran

# A sphere of this radius stands for a plane: the curvature that it adds is 1e-6 of that of a body of radius 1.
PLANE_RADIUS = 1e6

_NORMAL = np.array([0.0, 0.0, 1.0])


class Shape(NamedTuple):
    """Semi-axes (length) and the rotation from body to world, a quaternion w x y z of length 1."""

    semi_axes: Tuple[float, float, float]
    quaternion: Tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    def matrix(self) -> np.ndarray:
        """S = R diag(a^2) R^T."""
        w, x, y, z = self.quaternion
        rotation = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        return rotation @ np.diag(np.square(self.semi_axes)) @ rotation.T

    def witness(self) -> np.ndarray:
        """The surface point whose outward normal is z, from the centre."""
        column = self.matrix() @ _NORMAL
        return column / np.sqrt(column @ _NORMAL)

    def is_central(self) -> bool:
        """Does the normal at the witness pass through the centre?"""
        return bool(np.abs(self.matrix()[:2, 2]).max() < 1e-12)

    def sharpest(self) -> float:
        """The smaller radius of curvature at the witness."""
        form = np.linalg.inv(self.matrix())[:2, :2] * np.sqrt(self.matrix()[2, 2])
        return float(1.0 / np.linalg.eigvalsh(form)[-1])

    def depth(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """How far the surface lies below its tangent plane at the witness, at the offset (x, y). Beyond the body,
        where nothing can touch, three times its largest semi-axis.

        With Q = S^-1, h the support function and rho the offset it is the smaller root of
        Q_zz t^2 - 2 (1/h + (Q rho)_z) t + rho.Q rho = 0.
        """
        form = np.linalg.inv(self.matrix())
        support = np.sqrt(self.matrix()[2, 2])
        quadratic = form[0, 0] * x * x + 2 * form[0, 1] * x * y + form[1, 1] * y * y
        half = 1.0 / support + form[2, 0] * x + form[2, 1] * y
        root = half * half - form[2, 2] * quadratic
        inside = (root > 0) & (half > 0)
        return np.where(inside, quadratic / (half + np.sqrt(np.where(inside, root, 1.0))), 3.0 * max(self.semi_axes))


class Pair(NamedTuple):
    """Body j above body i; `name` says how they lie."""

    name: str
    i: Shape
    j: Shape

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Between the surfaces at first touch."""
        return self.i.depth(x, y) + self.j.depth(-x, -y)

    def bodies(self, penetration: float, **rest: object) -> ellgran.Bodies:
        """With this overlap along z."""
        centre = self.i.witness() + self.j.witness() - penetration * _NORMAL
        return ellgran.Bodies(
            [[0.0, 0.0, 0.0], centre], [self.i.semi_axes, self.j.semi_axes], [self.i.quaternion, self.j.quaternion], **rest
        )
