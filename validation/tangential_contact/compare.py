# SPDX-License-Identifier: MIT OR Apache-2.0
"""The tangential laws held against boundary elements with friction; see validation/README.md."""
from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any, Callable, Dict, List, Tuple

import numpy as np

import twisting
from friction import Friction, along
from grains import COEFFICIENT, FORMS, OVERLAP, Grains, Grid, Scene, through
from stored import write_csv, write_origin

HERE = Path(__file__).resolve().parent
FIRST_LOADING = "first loading"

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
# The picture's.
SHOWN = SCENES[2]
# A twist strains the rim most, and needs finer rectangles.
TWIST_COARSE, TWIST_FINE = Grid(26, 12), Grid(50, 24)


def paths(steps: int) -> Dict[str, Tuple[np.ndarray, int]]:
    """Overlap in units of OVERLAP, displacement along and across the scene's direction in units of that at which a contact of
    OVERLAP slides as a whole; and the point from which on the path is closed, so that an energy can be taken over it. Twice as
    many steps pass through the same points."""
    turn = np.linspace(0.0, 2.0 * np.pi, 4 * steps + 1)
    begun = through([(1, 0, 0), (1, 0.6, 0)], steps)[:-1]
    pulsing = np.stack([0.6 + 0.4 * np.cos(turn), 0.6 * np.sin(turn), 0 * turn], axis=1)
    deep = [(1, 0.6, 0), (0.4, 0.6, 0), (0.4, 0, 0), (1, 0, 0), (1, 0.6, 0)]
    shallow = [(0.4, 0.2, 0), (1, 0.2, 0), (1, 0, 0), (0.4, 0, 0), (0.4, 0.2, 0)]
    circle = np.stack([1 + 0 * turn, 0.6 * np.cos(turn), 0.6 * np.sin(turn)], axis=1)
    return {
        "reversed at 0.4": (through([(1, 0, 0), (1, 0.4, 0), (1, -0.4, 0), (1, 0.4, 0)], steps), steps),
        "reversed at 0.8": (through([(1, 0, 0), (1, 0.8, 0), (1, -0.8, 0), (1, 0.8, 0)], steps), steps),
        "sliding, reversed at 1.5": (through([(1, 0, 0), (1, 1.5, 0), (1, -1.5, 0), (1, 1.5, 0)], steps), steps),
        "loaded deep, unloaded shallow": (through([(1, 0, 0), *deep, *deep[1:]], steps), 5 * steps),
        "loaded shallow, unloaded deep": (through([(0.4, 0, 0), *shallow, *shallow[1:]], steps), 5 * steps),
        "normal force rising and falling": (np.concatenate([pulsing, pulsing[1:]]), 4 * steps),
        "led in a circle": (np.concatenate([begun, circle, circle[1:]]), 5 * steps),
    }


def dissipated(path: np.ndarray, forces: np.ndarray, first: int) -> float:
    """Work done against the force over the closed part of a path."""
    places, forces = path[first:, 1:], forces[first:]
    return -float(np.sum(0.5 * (forces[1:] + forces[:-1]) * (places[1:] - places[:-1])))


class Path:
    """A path of a scene in its own units, (overlap, x, y), and its contact ellipses."""

    def __init__(self, scene: Scene, name: str, steps: int) -> None:
        self.grains = Grains(scene, "rescaled")
        angle = np.radians(scene.direction)
        along_it = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along_it[1], along_it[0]])
        relative, self.closed_from = (
            (through([(1, 0, 0), (1, 1.2, 0)], steps), 0) if name == FIRST_LOADING else paths(steps)[name]
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


def errors(forces: np.ndarray, reference: np.ndarray) -> Dict[str, float]:
    """The largest and the root mean square along a path."""
    difference = np.hypot(*(forces - reference).T)
    return {"force_error": float(difference.max()), "force_error_rms": float(np.sqrt(np.mean(difference**2)))}


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
        by_law = dissipated(path.points, forces, path.closed_from) / held
        rows.append(
            dict(
                common,
                form=form,
                **errors(forces / limit, reference / limit),
                **bars,
                dissipated_by_law=by_law,
            )
        )
        for letter, column in zip("xy", forces.T):
            for row, value in zip(curves, column):
                row[f"{form}_{letter}"] = float(value / limit)
    return rows, curves


Rows = List[Dict[str, Any]]


def first_loading(coarse: Grid, fine: Grid, finer: int) -> Tuple[Rows, Rows]:
    """Errors of `tfd` on the way from nothing to sliding at steady normal force, where its forms are one; and the forces."""
    found, curves = [], []
    for scene in SCENES:
        rows, forces = compare(scene, FIRST_LOADING, coarse, fine, finer)
        row = rows[list(FORMS).index("rescaled")]
        found.append(dict(scene._asdict(), **{key: row[key] for key in ("force_error", "force_error_rms", "force_bar")}))
        curves += forces
    return found, curves


def cycles(coarse: Grid, fine: Grid, finer: int) -> Tuple[Rows, Rows]:
    """Errors of each form on each path, and the forces."""
    found, curves = [], []
    for scene in SCENES:
        for name in paths(1):
            if name.startswith("loaded") and scene not in CLOSED_LATE:
                continue
            errors, forces = compare(scene, name, coarse, fine, finer)
            found += errors
            curves += forces
            last = errors[2]
            print(
                f"{scene} {name}: rescaled {last['force_error']:.3f} +- {last['force_bar']:.3f}, dissipates "
                f"{last['dissipated_by_law']:.3f} of {last['dissipated']:.3f} +- {last['dissipated_bar']:.3f}",
                flush=True,
            )
    return found, curves


def without_law(curves: Rows) -> Rows:
    """Of the forces those of the full problem."""
    return [{key: row[key] for key in (*Scene._fields, "path", "point", "full_x", "full_y")} for row in curves]


def make_tangential() -> None:
    begun, begun_curves = first_loading(Grid(14, 12), Grid(26, 24), 8)
    rows, curves = cycles(Grid(14, 8), Grid(26, 16), 8)
    write_csv(HERE / "first_loading.csv", begun)
    write_csv(HERE / "cycles.csv", rows)
    write_csv(HERE / "curves.csv", [row for row in curves if tuple(row[key] for key in Scene._fields) == SHOWN])
    write_csv(HERE / "full_problem.csv", without_law(begun_curves + curves))


def make_twisting() -> None:
    coarse, fine = TWIST_COARSE, TWIST_FINE
    write_csv(HERE / "twisting_constants.csv", [twisting.constants(scene) for scene in twisting.TWISTED])
    curves: Rows = []
    for file, scenes, of in (("twisting", twisting.TWISTED, twisting.twists), ("twisting_and_sliding", twisting.BOTH, twisting.both)):
        rows = []
        for scene in scenes:
            for name in of(1):
                row, loads = twisting.compare(scene, name, {grid.steps: of(grid.steps)[name] for grid in (coarse, fine)}, coarse, fine, 8)
                rows.append(row)
                curves += loads
                print(
                    f"{scene} {name}: torque of marshall {row['torque_error_of_marshall']:.3f}, of lubkin {row['worst_torque_error_of_lubkin']:.3f} at worst "
                    f"+- {row['torque_bar']:.3f}",
                    flush=True,
                )
        write_csv(HERE / f"{file}.csv", rows)
    write_csv(HERE / "twisting_curves.csv", curves)


PARTS: Dict[str, Callable[[], None]] = {"tangential": make_tangential, "twisting": make_twisting}


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--only", choices=list(PARTS), help="make this part alone, and keep what is stored of the other")
    only = options.parse_args().only
    started = time.monotonic()
    origin: Dict[str, Any] = {}
    seconds: Dict[str, int] = {}
    if only:
        seconds = json.loads((HERE / "origin.json").read_text()).get("seconds_of_parts", {})
        origin["note"] = f"made in runs of parts of the same program, the last by `cargo xtask validate tangential-contact -- --only {only}`"
    for part in [only] if only else PARTS:
        begun = time.monotonic()
        PARTS[part]()
        seconds[part] = round(time.monotonic() - begun)
    write_origin(HERE, started, seconds=sum(seconds.values()), seconds_of_parts=seconds, **origin)


if __name__ == "__main__":
    main()
