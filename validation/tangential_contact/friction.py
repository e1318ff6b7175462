# SPDX-License-Identifier: MIT OR Apache-2.0
"""Boundary elements with Coulomb friction: partial slip between two equal elastic bodies, along a path of overlap, displacement and twist.

The bodies are equal, so shear does not change the pressure, which is Hertz' own in every step. In each step the shear tractions q solve

    minimise  q.(C q)/2 - q.(xi - s)   under   |q| <= mu p  at each rectangle,

with C the compliance of the half-spaces, xi the displacement of the bodies, which with a twist about the normal is xi_0 + theta (-y, x), and s
the slip so far. Its solution is Coulomb's law in the
backward Euler form: where |q| < mu p nothing slips, elsewhere the slip of the step is along q. Cattaneo's and Mindlin's assumption, that
slip is along the displacement, is not made; neither is an assumption on where the body sticks.
"""
from __future__ import annotations

from typing import Iterable, NamedTuple, Tuple

import numpy as np

from half_space_kernels import Rectangles, Shear


class Ellipse(NamedTuple):
    """A contact of Hertz: semi-axes along x and y, and the force."""

    semi_axes: Tuple[float, float]
    force: float


class Friction:
    """Shear tractions and slip of one contact, from step to step; the contact ellipses must lie within `half_widths`."""

    def __init__(
        self, half_widths: Tuple[float, float], count: int, shear_modulus: float, poisson: float, coefficient: float
    ) -> None:
        self._rectangles = Rectangles(half_widths, count)
        self._shear = Shear(self._rectangles, shear_modulus, poisson)
        self._coefficient = coefficient
        self._traction = np.zeros((2, count, count))
        self._slip = np.zeros((2, count, count))
        self._largest = self._largest_eigenvalue()

    def _largest_eigenvalue(self) -> float:
        field = np.ones_like(self._traction)
        for _ in range(30):
            field = self._shear(field / np.linalg.norm(field))
        return 1.02 * float(np.linalg.norm(field))

    def _pressure(self, contact: Ellipse) -> np.ndarray:
        a, b = contact.semi_axes
        profile = self._rectangles.averaged(lambda x, y: np.sqrt(np.maximum(0.0, 1.0 - (x / a) ** 2 - (y / b) ** 2)))
        return profile * (contact.force / (profile.sum() * self._rectangles.area))

    def _moved(self, displacement: np.ndarray, twist: float) -> np.ndarray:
        """What a displacement and a twist about the middle of the contact move each rectangle by."""
        x, y = np.broadcast_arrays(self._rectangles.x, self._rectangles.y)
        return np.stack([displacement[0] - twist * y, displacement[1] + twist * x])

    def advance(self, contact: Ellipse, displacement: np.ndarray, twist: float = 0.0) -> np.ndarray:
        """The force on the body that was displaced by this much since first touch, (x, y), and twisted by this angle, once the contact is
        this ellipse."""
        limit = self._coefficient * self._pressure(contact)
        moved = self._moved(displacement, twist)
        wanted = moved - self._slip

        def onto_the_cone(traction: np.ndarray) -> np.ndarray:
            length = np.hypot(*traction)
            return traction * np.minimum(1.0, limit / np.maximum(length, 1e-300))

        # Projected gradients with Nesterov's momentum, begun anew where it points uphill (O'Donoghue and Candes 2015).
        now = onto_the_cone(self._traction)
        ahead, momentum = now, 1.0
        scale = max(float(np.abs(limit).max()), 1e-300)
        for _ in range(5000):
            following = onto_the_cone(ahead - (self._shear(ahead) - wanted) / self._largest)
            change = following - now
            if np.sum((ahead - following) * change) > 0:
                momentum = 1.0
            largest = float(np.abs(following - ahead).max())
            later = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
            ahead = following + (momentum - 1.0) / later * change
            now, momentum = following, later
            if largest < 1e-5 * scale:
                break
        else:
            raise RuntimeError("the boundary elements with friction did not converge")
        self._traction = now
        # Outside the contact the surfaces move freely: what they would have slipped when they meet is what they are apart now.
        self._slip = moved - self._shear(now)
        return -now.sum(axis=(1, 2)) * self._rectangles.area

    def torque(self) -> float:
        """About the normal, on the same body."""
        x, y = self._rectangles.x, self._rectangles.y
        return -float(np.sum(x * self._traction[1] - y * self._traction[0])) * self._rectangles.area


def along(path: Iterable[Tuple[Ellipse, np.ndarray]], friction: Friction) -> np.ndarray:
    """Forces along a path, shape (steps, 2)."""
    return np.array([friction.advance(contact, displacement) for contact, displacement in path])


def loads_along(path: Iterable[Tuple[Ellipse, np.ndarray, float]], friction: Friction) -> np.ndarray:
    """Forces and the torque about the normal along a path with a twist, shape (steps, 3)."""
    return np.array([[*friction.advance(*point), friction.torque()] for point in path])
