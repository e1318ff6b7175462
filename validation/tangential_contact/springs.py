# SPDX-License-Identifier: MIT OR Apache-2.0
"""The bed of independent springs with Coulomb's limit of `displacement hysteretic` against the stored curves, written a second time.

Popov and Hess 2015 (doi:10.1007/978-3-642-53876-6), Jaeger 1995 (Arch. Appl. Mech. 65, 478-487): the spring that comes to carry at overlap z
has normal stiffness N''(z) dz, tangential stiffness proportional to it, and slides at mu times its own normal force. Here the springs
between two edges are one element. Edges go with the power 4/3 of their number up to a reference overlap, which grows by 2^(4/3) (elements
merged in pairs) when the overlap outgrows it. Units: overlap and normal force 1 and mu N = 1 at the largest overlap, displacement 1 at its sliding as a whole.

Run it to print the errors; it reads cycles.csv and curves.csv and writes nothing.
"""
from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np

from stored import read_csv

# The edge 2 k of a grid is the edge k of one that is so much larger.
GROWTH = 2.0 ** (4.0 / 3.0)
HERE = Path(__file__).resolve().parent
# The largest displacement along a path where it is not 0.6.
LARGEST = {"reversed at 0.4": 0.4, "reversed at 0.8": 0.8, "sliding, reversed at 1.5": 1.5, "loaded shallow, unloaded deep": 0.2}


class Springs:
    """Elements of one contact: their forces, shape (count, 2), between updates."""

    def __init__(self, count: int, stiffness: np.ndarray, reference: float) -> None:
        self._count = count
        self._direction = stiffness
        self.reference = reference
        self.forces = np.zeros((count, 2))
        self._stiffness = np.zeros(count)

    def elements(self, overlap: float) -> Tuple[np.ndarray, np.ndarray]:
        """Stiffness N' and normal force of each element; their sums are those of Hertz."""
        edges = np.minimum(self.reference * np.linspace(0.0, 1.0, self._count + 1) ** (4.0 / 3.0), overlap)
        slope = np.diff(1.5 * np.sqrt(edges))
        # The integral of N''(z) (overlap - z), N = z^(3/2).
        carried = np.diff(1.5 * np.sqrt(edges) * overlap - 0.5 * edges**1.5)
        return slope, carried

    def advance(self, overlap: float, moved: np.ndarray) -> np.ndarray:
        while overlap > self.reference:
            self.reference *= GROWTH
            for of in ("forces", "_stiffness"):
                old = getattr(self, of)
                merged = np.zeros_like(old)
                merged[: self._count // 2] = old[0::2] + old[1::2]
                setattr(self, of, merged)
        slope, carried = self.elements(overlap)
        # What leaves the contact takes its share of the force with it; what enters is not stretched.
        kept = np.minimum(1.0, slope / np.maximum(self._stiffness, 1e-300))
        forces = self.forces * kept[:, None] + slope[:, None] * self._direction * moved
        length = np.hypot(*forces.T)
        self.forces = forces * np.minimum(1.0, carried / np.maximum(length, 1e-300))[:, None]
        self._stiffness = slope
        return self.forces.sum(axis=0)

    def energy(self) -> float:
        """Elastic energy of the elements, each that of its own spring."""
        carrying = self._stiffness > 0
        return float(np.sum(0.5 * self.forces[carrying] ** 2 / (self._stiffness[carrying, None] * self._direction)))


def along(path: np.ndarray, count: int, stiffness: np.ndarray, reference: float, finer: int = 8) -> np.ndarray:
    """Forces at the points (overlap, x, y) of a path, with so many steps of the law between two of them."""
    springs, last, forces = Springs(count, stiffness, reference), path[0], []
    springs.advance(float(last[0]), np.zeros(2))
    for point in path:
        for part in range(1, finer + 1):
            force = springs.advance(float((last + (point - last) * part / finer)[0]), (point - last)[1:] / finer)
        forces.append(force)
        last = point
    return np.array(forces)


def least_gain(count: int, histories: int, steps: int) -> float:
    """The least of (work done on the contact minus elastic energy) over random histories, in units of mu N times the displacement of
    sliding; negative if energy was created. An overlap changes at steady displacement, so that all tangential work is counted."""
    random = np.random.default_rng(1)
    least = np.inf
    for _ in range(histories):
        springs, work, overlap = Springs(count, random.uniform(0.5, 1.5, 2), 0.05), 0.0, 0.5
        for _ in range(steps):
            overlap = float(np.clip(overlap + 0.2 * random.normal(), 0.0, 1.5))
            springs.advance(overlap, np.zeros(2))
            moved = 0.2 * random.normal(size=2)
            before = springs.forces.sum(axis=0)
            after = springs.advance(overlap, moved)
            work += float(0.5 * (before + after) @ moved)
            least = min(least, work - springs.energy())
    return float(least)


def first_loading(count: int, reference: float) -> float:
    """Largest difference from Cattaneo's and Mindlin's 1 - (1 - s)^(3/2), over displacements from 0 to 1."""
    places = np.linspace(0.0, 1.0, 401)
    path = np.stack([np.ones_like(places), places, 0 * places], axis=1)
    forces = along(path, count, np.ones(2), reference, 1)[:, 0]
    return float(np.abs(forces - (1.0 - (1.0 - places) ** 1.5)).max())


def of_path(rows: List[Dict[str, Any]], count: int, reference: float) -> Tuple[float, float, float]:
    """Error of the force, energy dissipated, and that of the full problem again from its stored curve (a check of the units), of one stored path."""
    path = np.array([[row["overlap"], row["x"], row["y"]] for row in rows])
    full, rescaled = (-np.array([[row[f"{of}_x"], row[f"{of}_y"]] for row in rows]) for of in ("full", "rescaled"))
    largest = float(np.hypot(*path[:, 1:].T).max())
    relative = LARGEST.get(rows[0]["path"], 0.6)
    path[:, 1:] *= relative / largest
    # The direction of the force of first loading is that of the stiffness times the displacement.
    at = next(k for k in range(len(rows)) if np.hypot(*path[k, 1:]) > 1e-9 and np.hypot(*rescaled[k]) > 1e-9)
    stiffness = rescaled[at] / path[at, 1:]
    stiffness = stiffness / np.hypot(*(stiffness / np.sqrt(2.0)))
    forces = along(path, count, stiffness, reference)
    # Where compare.py has the path closed, at 16 steps a line.
    first = 16 * (1 if "reversed" in rows[0]["path"] else 4 if rows[0]["path"].startswith("normal") else 5)

    def lost(of: np.ndarray) -> float:
        return float(np.sum(0.5 * (of[first + 1 :] + of[first:-1]) * np.diff(path[first:, 1:], axis=0))) / (0.5 * relative)

    return float(np.hypot(*(forces - full).T).max()), lost(forces), lost(full)


def led_in_a_circle(count: int, reference: float) -> float:
    """Energy dissipated in the second half of two rounds of radius 0.6 by a circular contact, as stored."""
    turn = np.linspace(0.0, 4.0 * np.pi, 129)
    round_it = np.stack([1 + 0 * turn, 0.6 * np.cos(turn), 0.6 * np.sin(turn)], axis=1)
    begun = np.stack([np.ones(16), 0.6 * np.arange(16) / 16, np.zeros(16)], axis=1)
    path = np.concatenate([begun, round_it])
    forces = along(path, count, np.ones(2), reference)[80:]
    return float(np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(path[80:, 1:], axis=0))) / 0.3


def main() -> None:
    curves, cycles = read_csv(HERE / "curves.csv"), read_csv(HERE / "cycles.csv")
    scene = [row for row in cycles if (row["aspect"], row["direction"]) == (2.0, 45.0) and row["form"] == "rescaled"]
    of_circle = next(row for row in cycles if row["aspect"] == 1 and row["poisson"] == 0 and row["path"] == "led in a circle")
    for count in (4, 8, 16, 32):
        print(f"{count} elements: gains at least {least_gain(count, 50, 200):.1e}; first loading "
              f"{first_loading(count, 1.0):.4f} at the best reference overlap, {first_loading(count, 2.5):.4f} at the worst")
        by_law, full = led_in_a_circle(count, 1.0), of_circle["dissipated"]
        print(f"  circular contact led in a circle: dissipated {by_law:.3f} of {full:.3f} +- {of_circle['dissipated_bar']:.3f}")
        for stored in scene:
            rows = [row for row in curves if row["path"] == stored["path"]]
            best, worst = (of_path(rows, count, reference) for reference in (1.0, 2.5))
            print(f"  {stored['path']}: force {best[0]:.3f} to {worst[0]:.3f} (rescaled {stored['force_error']:.3f}, bar {stored['force_bar']:.3f}); "
                  f"dissipated {best[1]:.3f} to {worst[1]:.3f} of {stored['dissipated']:.3f} (again {best[2]:.3f}), rescaled {stored['dissipated_by_law']:.3f}")


if __name__ == "__main__":
    main()
