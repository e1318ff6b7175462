# SPDX-License-Identifier: MIT OR Apache-2.0
"""The tangential laws held against boundary elements with friction; see README.md here."""
from __future__ import annotations

import time
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np

import ellgran
from friction import Ellipse, Friction, along
from stored import write_csv, write_origin

HERE = Path(__file__).resolve().parent
COEFFICIENT = 0.5
# So small that the contact is Hertz' and the motion does not turn the normal.
OVERLAP = 1e-4
FORMS = {
    "total": "tfd 0.5 displacement total",
    "incremental": "tfd 0.5 displacement incremental",
    "rescaled": "tfd 0.5 displacement rescaled",
    "mindlin": "mindlin 0.5 displacement rescaled",
}

FIRST_LOADING = "first loading"


class Scene(NamedTuple):
    """Equal grains side by side, of aspect ratio `aspect`, displaced along `direction` (degrees from the major semi-axis)."""

    aspect: float
    poisson: float
    direction: float


SCENES = (
    Scene(1.0, 0.0, 0.0),
    Scene(1.0, 0.3, 0.0),
    Scene(2.0, 0.3, 45.0),
    Scene(5.0, 0.3, 0.0),
    Scene(5.0, 0.3, 45.0),
    Scene(5.0, 0.3, 90.0),
)
# Paths that close in their second round only take longest, and are followed in these scenes alone.
CLOSED_LATE = (SCENES[0], SCENES[2], SCENES[4])


def _through(points: Sequence[Tuple[float, float, float]], steps: int) -> np.ndarray:
    """Straight lines between points, `steps` each."""
    corners = np.array(points, dtype=float)
    lines = [np.linspace(a, b, steps, endpoint=False) for a, b in zip(corners[:-1], corners[1:])]
    return np.concatenate(lines + [corners[-1:]])


def paths(steps: int) -> Dict[str, Tuple[np.ndarray, int]]:
    """Overlap in units of OVERLAP, displacement along and across the scene's direction in units of that at which a contact of
    OVERLAP slides as a whole; and the point from which on the path is closed, so that an energy can be taken over it. Twice as
    many steps pass through the same points."""
    turn = np.linspace(0.0, 2.0 * np.pi, 4 * steps + 1)
    begun = _through([(1, 0, 0), (1, 0.6, 0)], steps)[:-1]
    pulsing = np.stack([0.6 + 0.4 * np.cos(turn), 0.6 * np.sin(turn), 0 * turn], axis=1)
    deep = [(1, 0.6, 0), (0.4, 0.6, 0), (0.4, 0, 0), (1, 0, 0), (1, 0.6, 0)]
    shallow = [(0.4, 0.2, 0), (1, 0.2, 0), (1, 0, 0), (0.4, 0, 0), (0.4, 0.2, 0)]
    circle = np.stack([1 + 0 * turn, 0.6 * np.cos(turn), 0.6 * np.sin(turn)], axis=1)
    return {
        "reversed at 0.4": (_through([(1, 0, 0), (1, 0.4, 0), (1, -0.4, 0), (1, 0.4, 0)], steps), steps),
        "reversed at 0.8": (_through([(1, 0, 0), (1, 0.8, 0), (1, -0.8, 0), (1, 0.8, 0)], steps), steps),
        "sliding, reversed at 1.5": (_through([(1, 0, 0), (1, 1.5, 0), (1, -1.5, 0), (1, 1.5, 0)], steps), steps),
        "loaded deep, unloaded shallow": (_through([(1, 0, 0), *deep, *deep[1:]], steps), 5 * steps),
        "loaded shallow, unloaded deep": (_through([(0.4, 0, 0), *shallow, *shallow[1:]], steps), 5 * steps),
        "normal force rising and falling": (np.concatenate([pulsing, pulsing[1:]]), 4 * steps),
        "led in a circle": (np.concatenate([begun, circle, circle[1:]]), 5 * steps),
    }


class Grains:
    """The law of one scene."""

    def __init__(self, scene: Scene, form: str) -> None:
        self._semi_axes = (scene.aspect, 1.0, 1.0)
        self._laws = ellgran.Laws(f"hertz 1.0 {scene.poisson} tangential {FORMS[form]} conservative no")
        self.shear_modulus = 0.5 / (1.0 + scene.poisson)

    def _bodies(self, overlap: float, velocity: Sequence[float] = (0.0, 0.0, 0.0)) -> ellgran.Bodies:
        return ellgran.Bodies([[0, 0, 0], [0, 0, 2.0 - overlap]], self._semi_axes, velocities=[[0, 0, 0], velocity])

    def ellipse(self, overlap: float) -> Ellipse:
        found = ellgran.contacts(self._laws, self._bodies(overlap), [[0, 1]])
        major, minor = (float(axis) for axis in found.contact_semi_axes[0])
        return Ellipse((major, minor), float(found.normal_force[0]))

    def sliding_displacement(self, direction: np.ndarray) -> float:
        """Where the law has the contact of OVERLAP slide as a whole: |C^-1 xi| = (3/2) mu F_n."""
        springs = ellgran.stiffnesses(self._laws, self._bodies(OVERLAP), [[0, 1]]).tangential_stiffness[0]
        return 1.5 * COEFFICIENT * self.ellipse(OVERLAP).force / float(np.hypot(*(springs * direction)))

    def along(self, path: np.ndarray, finer: int) -> np.ndarray:
        """Tangential forces at the points of a path (overlap, x, y), with so many steps of the law between two of them."""
        memory = ellgran.ContactMemory(self._laws, 1)
        forces, last = [], np.array([path[0, 0], 0.0, 0.0])
        self._step(memory, last, np.zeros(3))
        for point in path:
            for part in range(1, finer + 1):
                force = self._step(memory, last + (point - last) * part / finer, (point - last) / finer)
            forces.append(force)
            last = point
        return np.array(forces)

    def _step(self, memory: ellgran.ContactMemory, point: np.ndarray, moved: np.ndarray) -> np.ndarray:
        bodies = self._bodies(point[0], (moved[1], moved[2], -moved[0]))
        found = ellgran.contacts(self._laws, bodies, [[0, 1]], time_step=1.0, memory=memory, quantities=["tangential_force"])
        return found.tangential_force[0, :2].copy()


def dissipated(path: np.ndarray, forces: np.ndarray, first: int) -> float:
    """Work done against the force over the closed part of a path."""
    places, forces = path[first:, 1:], forces[first:]
    return -float(np.sum(0.5 * (forces[1:] + forces[:-1]) * (places[1:] - places[:-1])))


class Grid(NamedTuple):
    """Rectangles along each side, steps along each line of a path."""

    count: int
    steps: int


class Path:
    """A path of a scene in its own units, (overlap, x, y), and its contact ellipses."""

    def __init__(self, scene: Scene, name: str, steps: int) -> None:
        self.grains = Grains(scene, "rescaled")
        angle = np.radians(scene.direction)
        along_it = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along_it[1], along_it[0]])
        relative, self.closed_from = (
            (_through([(1, 0, 0), (1, 1.2, 0)], steps), 0) if name == FIRST_LOADING else paths(steps)[name]
        )
        scale = self.grains.sliding_displacement(along_it)
        places = scale * (relative[:, 1:2] * along_it + relative[:, 2:] * across)
        self.points = np.concatenate([OVERLAP * relative[:, :1], places], axis=1)
        self.ellipses = {overlap: self.grains.ellipse(overlap) for overlap in set(self.points[:, 0])}
        self.widest = self.ellipses[self.points[:, 0].max()]

    def full_problem(self, poisson: float, count: int) -> np.ndarray:
        """Forces by boundary elements; the largest ellipse ends between the same two rectangles on each grid."""
        half_widths = tuple(axis * count / (count - 2) for axis in self.widest.semi_axes)
        friction = Friction(half_widths, count, self.grains.shear_modulus, poisson, COEFFICIENT)
        return along(((self.ellipses[point[0]], point[1:]) for point in self.points), friction)


def compare(scene: Scene, name: str, coarse: Grid, fine: Grid, finer: int) -> Tuple[List[Dict[str, Any]], List[Dict[str, Any]]]:
    """One path of one scene: each form of the law against the boundary elements on the finer grid (which has twice the steps of
    the coarser). The errors, and the forces themselves. Forces are in units of mu times the largest normal force, energies in
    units of half of that times the largest displacement, which a linear spring would hold."""
    rough, path = Path(scene, name, coarse.steps), Path(scene, name, fine.steps)
    before = rough.full_problem(scene.poisson, coarse.count)
    reference = path.full_problem(scene.poisson, fine.count)
    limit = COEFFICIENT * path.widest.force
    held = 0.5 * limit * float(np.hypot(*path.points[:, 1:].T).max())
    loss = dissipated(path.points, reference, path.closed_from) / held
    common: Dict[str, Any] = dict(scene._asdict(), path=name)
    bars = {
        "force_bar": float(np.hypot(*(reference[::2] - before).T).max() / limit),
        "dissipated": loss,
        "dissipated_bar": abs(dissipated(rough.points, before, rough.closed_from) / held - loss),
    }
    rows = []
    curves = [
        dict(common, point=k, overlap=point[0] / OVERLAP, x=point[1] / OVERLAP, y=point[2] / OVERLAP)
        for k, point in enumerate(path.points)
    ]
    for letter, column in zip("xy", reference.T):
        for row, value in zip(curves, column):
            row[f"full_{letter}"] = float(value / limit)
    for form in FORMS:
        forces = Grains(scene, form).along(path.points, finer)
        difference = np.hypot(*(forces - reference).T) / limit
        by_law = dissipated(path.points, forces, path.closed_from) / held
        rows.append(
            dict(
                common,
                form=form,
                force_error=float(difference.max()),
                force_error_rms=float(np.sqrt(np.mean(difference**2))),
                **bars,
                dissipated_by_law=by_law,
            )
        )
        for letter, column in zip("xy", forces.T):
            for row, value in zip(curves, column):
                row[f"{form}_{letter}"] = float(value / limit)
    return rows, curves


def first_loading(scenes: Sequence[Scene], coarse: Grid, fine: Grid, finer: int) -> List[Dict[str, Any]]:
    """Errors of `tfd` on the way from nothing to sliding at steady normal force, where its forms are one."""
    found = []
    for scene in scenes:
        row = compare(scene, FIRST_LOADING, coarse, fine, finer)[0][list(FORMS).index("rescaled")]
        found.append(dict(scene._asdict(), **{key: row[key] for key in ("force_error", "force_error_rms", "force_bar")}))
    return found


def main() -> None:
    started = time.monotonic()
    rows, curves = [], []
    write_csv(HERE / "first_loading.csv", first_loading(SCENES, Grid(14, 12), Grid(26, 24), 8))
    for scene in SCENES:
        for name in paths(1):
            if name.startswith("loaded") and scene not in CLOSED_LATE:
                continue
            errors, forces = compare(scene, name, Grid(14, 8), Grid(26, 16), 8)
            rows += errors
            # The picture's scene.
            if scene == Scene(2.0, 0.3, 45.0):
                curves += forces
            last = errors[2]
            print(
                f"{scene} {name}: rescaled {last['force_error']:.3f} +- {last['force_bar']:.3f}, dissipates "
                f"{last['dissipated_by_law']:.3f} of {last['dissipated']:.3f} +- {last['dissipated_bar']:.3f}",
                flush=True,
            )
    write_csv(HERE / "cycles.csv", rows)
    write_csv(HERE / "curves.csv", curves)
    write_origin(HERE, started)


if __name__ == "__main__":
    main()
