# SPDX-License-Identifier: MIT OR Apache-2.0
"""Equal grains side by side, and what the laws of the library make of a path on which one of them is displaced and twisted."""
from __future__ import annotations

from typing import NamedTuple, Sequence, Tuple

import numpy as np

import ellgran
from friction import Ellipse

COEFFICIENT = 0.5
# So small that the contact is Hertz' and the motion does not turn the normal.
OVERLAP = 1e-4
FORMS = {
    "total": "tfd 0.5 displacement total",
    "incremental": "tfd 0.5 displacement incremental",
    "rescaled": "tfd 0.5 displacement rescaled",
    "mindlin": "mindlin 0.5 displacement rescaled",
}
_FORCES = {**FORMS, "hysteretic": "tfd 0.5 displacement hysteretic"}

_PAIR = np.array([[0, 1]], dtype=np.int32)


class Scene(NamedTuple):
    """Equal grains side by side, of aspect ratio `aspect`, displaced along `direction` (degrees from the major semi-axis)."""

    aspect: float
    poisson: float
    direction: float


class Grid(NamedTuple):
    """Rectangles along each side, steps along each line of a path."""

    count: int
    steps: int


def through(points: Sequence[Tuple[float, ...]], steps: int) -> np.ndarray:
    """Straight lines between points, `steps` each."""
    corners = np.array(points, dtype=float)
    lines = [np.linspace(a, b, steps, endpoint=False) for a, b in zip(corners[:-1], corners[1:])]
    return np.concatenate(lines + [corners[-1:]])


class Grains:
    """The laws of one scene: of the force one of FORMS or "hysteretic", and of the torque about the normal."""

    def __init__(self, scene: Scene, form: str, twisting: str = "marshall") -> None:
        self._semi_axes = (scene.aspect, 1.0, 1.0)
        self._laws = ellgran.Laws(f"hertz 1.0 {scene.poisson} tangential {_FORCES[form]} twisting {twisting} conservative no")
        self.shear_modulus = 0.5 / (1.0 + scene.poisson)

    def _bodies(self, overlap: float) -> ellgran.Bodies:
        still = np.zeros((2, 3))
        return ellgran.Bodies([[0, 0, 0], [0, 0, 2.0 - overlap]], self._semi_axes, velocities=still, angular_velocities=still.copy())

    def ellipse(self, overlap: float) -> Ellipse:
        found = ellgran.contacts(self._laws, self._bodies(overlap), _PAIR)
        major, minor = (float(axis) for axis in found.contact_semi_axes[0])
        return Ellipse((major, minor), float(found.normal_force[0]))

    def sliding_displacement(self, direction: np.ndarray) -> float:
        """Where the law has the contact of OVERLAP slide as a whole: |C^-1 xi| = (3/2) mu F_n."""
        springs = ellgran.stiffnesses(self._laws, self._bodies(OVERLAP), _PAIR).tangential_stiffness[0]
        return 1.5 * COEFFICIENT * self.ellipse(OVERLAP).force / float(np.hypot(*(springs * direction)))

    def along(self, path: np.ndarray, finer: int) -> np.ndarray:
        """Tangential forces at the points of a path (overlap, x, y), with so many steps of the law between two of them."""
        return self.loads_along(np.pad(path, ((0, 0), (0, 1))), finer)[:, :2]

    def loads_along(self, path: np.ndarray, finer: int, touched: float = 1.0) -> np.ndarray:
        """Tangential forces and the torque about the normal at the points of a path (overlap, x, y, angle). The bodies are given the angle
        as an angular velocity and stay where they are, as in the full problem: it is small. They touched first at a part `touched` of the overlap of
        the first point."""
        memory = ellgran.ContactMemory(self._laws, 1)
        # Made once, and changed in place from step to step.
        bodies = self._bodies(path[0, 0])
        found = ellgran.contacts(self._laws, bodies, _PAIR, quantities=["tangential_force", "frictional_couple"])

        def step(point: np.ndarray, moved: np.ndarray) -> np.ndarray:
            bodies.positions[1, 2] = 2.0 - point[0]
            bodies.velocities[1] = (moved[1], moved[2], -moved[0])
            bodies.angular_velocities[1, 2] = moved[3]
            ellgran.contacts(self._laws, bodies, _PAIR, time_step=1.0, memory=memory, out=found)
            # The couple is that on the first body.
            return np.array([*found.tangential_force[0, :2], -found.frictional_couple[0, 2]])

        loads, last = [], np.array([path[0, 0], 0.0, 0.0, 0.0])
        for part in (touched, 1.0):
            step(part * last, np.zeros(4))
        for point in path:
            for part in range(1, finer + 1):
                load = step(last + (point - last) * part / finer, (point - last) / finer)
            loads.append(load)
            last = point
        return np.array(loads)
