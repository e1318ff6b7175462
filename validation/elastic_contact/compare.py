# SPDX-License-Identifier: MIT OR Apache-2.0
"""The elastic normal law held against boundary elements and finite elements."""
from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np

import ellgran
from collisions.free_body import WIDTH, Grid
from ellipsoid_pair import PLANE_RADIUS, Pair, Shape
from finite_bodies import FiniteBody
from half_space import Pressed, press
from stored import read_csv, write_csv, write_origin
from whole_bodies import WholePair

HERE = Path(__file__).resolve().parent
POISSON = 0.3
LAW = ellgran.Law(f"hertz 1.0 {POISSON} conservative no")
MODULUS = 1.0 / (2.0 * (1.0 - POISSON**2))
RATIOS = (1, 2, 4, 10, 30, 100)
OVERLAPS = (0.003, 0.01, 0.03, 0.1, 0.2, 0.4)
TURNED_HALF = (float(np.cos(np.pi / 8)), 0.0, float(np.sin(np.pi / 8)), 0.0)
TURNED_QUARTER = (float(np.sqrt(0.5)), 0.0, 0.0, float(np.sqrt(0.5)))
PLANE = Shape((PLANE_RADIUS,) * 3)
PAIRS = (
    Pair("spheres", Shape((1, 1, 1)), Shape((1, 1, 1))),
    Pair("sphere on a plane", Shape((1, 1, 1)), PLANE),
    Pair("2:1:1 side by side", Shape((2, 1, 1)), Shape((2, 1, 1))),
    Pair("5:1:1 side by side", Shape((5, 1, 1)), Shape((5, 1, 1))),
    Pair("2:1:1 on its side on a plane", Shape((2, 1, 1)), PLANE),
    Pair("2:1:1 crossed", Shape((2, 1, 1)), Shape((2, 1, 1), TURNED_QUARTER)),
    Pair("2:1:1 oblique", Shape((2, 1, 1), TURNED_HALF), Shape((2, 1, 1), TURNED_HALF)),
    Pair("2:1:1 tip to tip", Shape((1, 1, 2)), Shape((1, 1, 2))),
    Pair("5:1:1 tip to tip", Shape((1, 1, 5)), Shape((1, 1, 5))),
)

# Whole bodies in three dimensions.
TURNED_UPRIGHT = (float(np.sqrt(0.5)), 0.0, float(np.sqrt(0.5)), 0.0)
TURNED_ASIDE = (float(np.sqrt(0.5)), float(np.sqrt(0.5)), 0.0, 0.0)
WHOLE_PAIRS = (
    Pair("1:1:1 tip to tip", Shape((1, 1, 1)), Shape((1, 1, 1))),
    Pair("2:1:1 tip to tip", Shape((1, 1, 2)), Shape((1, 1, 2))),
    Pair("5:1:1 tip to tip", Shape((1, 1, 5)), Shape((1, 1, 5))),
    Pair("2:1:1 side by side", Shape((2, 1, 1)), Shape((2, 1, 1))),
    Pair("5:1:1 side by side", Shape((5, 1, 1)), Shape((5, 1, 1))),
    Pair("2:1:1 crossed", Shape((2, 1, 1)), Shape((2, 1, 1), TURNED_QUARTER)),
    Pair("5:1:1 crossed", Shape((5, 1, 1)), Shape((5, 1, 1), TURNED_QUARTER)),
    Pair("2:1:1 oblique", Shape((2, 1, 1), TURNED_HALF), Shape((2, 1, 1), TURNED_HALF)),
    Pair("3:1:1 oblique", Shape((3, 1, 1), TURNED_HALF), Shape((3, 1, 1), TURNED_HALF)),
    Pair("1:1:0.5 rim to rim", Shape((1, 1, 0.5), TURNED_ASIDE), Shape((1, 1, 0.5), TURNED_ASIDE)),
    Pair("1:1:0.5 face to face", Shape((1, 1, 0.5)), Shape((1, 1, 0.5))),
    Pair("1:1:0.5 rims crossed", Shape((1, 1, 0.5), TURNED_UPRIGHT), Shape((1, 1, 0.5), TURNED_ASIDE)),
)
WHOLE_GRIDS = {"coarse": Grid(8, 3, 2.4), "fine": Grid(12, 4, 2.0)}
# Where the normal misses the centre, half of a body must be meshed instead of a quarter, and the mesh is askew: bending converges with the growth
# of its shells. At 5:1:1 it does not within these sizes: the far side of a coarse body moves little more than half as much as that of tetrahedra.
HALF_GRIDS = {"coarse": Grid(6, 2, 2.4), "fine": Grid(8, 3, 1.7)}
WHOLE_OVERLAPS = (1e-5, 1e-4, 1e-3, 1e-2)
# At this overlap bodies are half-spaces to a thousandth of what they are not at 1e-4, and what is left is the grid's.
HALF_SPACE_OVERLAP = 1e-10


class Law:
    """What the law says of a pair at an overlap."""

    def __init__(self, pair: Pair, overlap: float) -> None:
        found = ellgran.contacts(LAW, pair.bodies(overlap), [[0, 1]])
        self.overlap = float(found.penetration[0])
        self.force = float(found.normal_force[0])
        self.curvatures = found.curvatures[0]
        self.major, self.minor = found.contact_semi_axes[0]
        self.direction = found.major_direction[0]
        self.peak = 1.5 * self.force / (np.pi * self.major * self.minor)

    def along_x(self) -> bool:
        return self.curvatures[1] < self.curvatures[0] * 1.0000001 or abs(self.direction[0]) > 0.5

    def half_widths(self, wider: float) -> Tuple[float, float]:
        axes = (self.major, self.minor) if self.along_x() else (self.minor, self.major)
        return (wider * axes[0], wider * axes[1])

    def paraboloid(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        of_x, of_y = self.curvatures if self.along_x() else self.curvatures[::-1]
        return of_x * x**2 + of_y * y**2

    def differences(self, pressed: Pressed) -> Dict[str, float]:
        """The law less the full problem, relative: force at equal overlap; the rest at equal force."""
        major, minor = pressed.semi_axes if self.along_x() else pressed.semi_axes[::-1]
        return {
            "force": float((pressed.penetration / self.overlap) ** 1.5 - 1),
            "major": float(self.major / major - 1),
            "minor": float(self.minor / minor - 1),
            "peak": float(self.peak / pressed.peak - 1),
        }


def extrapolated(values: Sequence[float]) -> Tuple[float, float]:
    """Limit of a sequence on grids each twice as fine: Aitken's, or, where the differences do not shrink as a power of the grid
    does, the finest value. The error bar is the last difference."""
    coarse, middle, fine = values[-3:]
    first, second = middle - coarse, fine - middle
    ratio = second / first if first else 0.0
    if 0.05 < ratio < 0.7:
        return fine + second * ratio / (1 - ratio), abs(second)
    return fine, abs(second)


def paraboloids(counts: Sequence[int]) -> List[Dict[str, Any]]:
    """Hertz' own problem: equal prolate grains side by side, B/A the square of their aspect ratio."""
    rows = []
    for ratio in RATIOS:
        shape = Shape((float(np.sqrt(ratio)), 1.0, 1.0))
        law = Law(Pair("", shape, shape), 1e-3)
        grids = [law.differences(press(law.paraboloid, law.force, MODULUS, law.half_widths(1.25), n)) for n in counts]
        row: Dict[str, Any] = {"ratio": float(ratio), "b_over_a": float(law.minor / law.major)}
        for name in grids[0]:
            values = [grid[name] for grid in grids]
            for count, value in zip(counts, values):
                row[f"{name}_{count}"] = value
            row[name], row[f"{name}_bar"] = extrapolated(values)
        rows.append(row)
        print(f"B/A = {ratio}: force {row['force']:.1e} +- {row['force_bar']:.0e}", flush=True)
    return rows


def exact_shapes(counts: Sequence[int], pairs: Sequence[Pair] = PAIRS, overlaps: Sequence[float] = OVERLAPS) -> List[Dict[str, Any]]:
    """The gap of the bodies themselves. Each number is its difference from that of the paraboloids on the same grid, so that what
    the grid does to both is gone; the bar is the change from the grid before."""
    rows = []
    for pair in pairs:
        for overlap in overlaps:
            law = Law(pair, overlap)
            found = []
            for count in counts:
                widths = law.half_widths(1.3)
                exact, parabola = (
                    law.differences(press(gap, law.force, MODULUS, widths, count)) for gap in (pair.gap, law.paraboloid)
                )
                found.append({name: (1 + exact[name]) / (1 + parabola[name]) - 1 for name in exact})
            row: Dict[str, Any] = {"pair": pair.name, "overlap": overlap}
            for name in found[-1]:
                row[name] = found[-1][name]
                row[f"{name}_bar"] = abs(found[-1][name] - found[-2][name])
            rows.append(row)
            print(f"{pair.name}, overlap {overlap}: force {row['force']:.1e} +- {row['force_bar']:.0e}", flush=True)
    return rows


def finite_bodies(elements: Sequence[int], aspects: Sequence[float], overlaps: Sequence[float]) -> List[Dict[str, Any]]:
    """Whole spheroids tip to tip; overlaps in units of the radius of curvature at the tip."""
    rows = []
    for aspect in aspects:
        radius = 1.0 / aspect
        shape = Shape((1.0, 1.0, aspect))
        for overlap in overlaps:
            law = Law(Pair("", shape, shape), overlap * radius)
            found: Dict[str, List[float]] = {"free": [], "held": []}
            for count in elements:
                body = FiniteBody(aspect, law.major, count)
                for support, forces in found.items():
                    forces.append(law.force / body.force(law.overlap, support == "held") - 1)
            row: Dict[str, Any] = {"aspect": aspect, "overlap": overlap}
            for support, forces in found.items():
                row[support], row[f"{support}_bar"] = forces[-1], abs(forces[-1] - forces[-2])
            rows.append(row)
            print(f"aspect {aspect}, overlap {overlap}: force {row['free']:.1e} free, {row['held']:.1e} held", flush=True)
    return rows


def whole_bodies(pair: Pair, overlaps: Sequence[float] = WHOLE_OVERLAPS) -> List[Dict[str, Any]]:
    """Whole ellipsoids in three dimensions; overlaps in units of the smaller radius of curvature of a body where it is touched. Each number is its
    difference from that at an overlap at which the bodies are half-spaces, on the same grid, so that what the grid does to both is gone; the bar
    is the change from the coarse grid to the fine one."""
    unit = min(pair.i.sharpest(), pair.j.sharpest())
    central = pair.i.is_central() and pair.j.is_central()
    # No force on the other side holds bodies whose centres the normal misses.
    supports = {"free": False, "held": True} if central else {"free": False}

    def ratios(overlap: float) -> Dict[str, Dict[str, float]]:
        law = Law(pair, overlap * unit)
        found = {}
        for name, grid in (WHOLE_GRIDS if central else HALF_GRIDS).items():
            bodies = WholePair(pair, POISSON, law.half_widths(WIDTH), grid)
            found[name] = {support: law.force / bodies.force(law.overlap, held) for support, held in supports.items()}
        return found

    of_the_grid = ratios(HALF_SPACE_OVERLAP)
    rows = []
    for overlap in overlaps:
        row: Dict[str, Any] = {"pair": pair.name, "overlap": overlap}
        found = ratios(overlap)
        for support in ("free", "held"):
            coarse, fine = (
                found[name][support] / of_the_grid[name][support] - 1 if support in supports else float("nan") for name in WHOLE_GRIDS
            )
            row.update({support: fine, f"{support}_bar": abs(fine - coarse), f"{support}_coarse": coarse})
        row.update({f"grid_{name}": value["free"] - 1 for name, value in of_the_grid.items()})
        rows.append(row)
        print(f"{pair.name}, overlap {overlap}: force {row['free']:.1e} free, {row['held']:.1e} held", flush=True)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--go-on", action="store_true", help="keep the files there are, and the pairs that whole_bodies.csv has")
    options = parser.parse_args()
    started = time.monotonic()
    earlier = json.loads((HERE / "origin.json").read_text())["seconds"] if options.go_on else 0

    def written(name: str, rows: List[Dict[str, Any]]) -> None:
        write_csv(HERE / name, rows)
        write_origin(HERE, started, seconds=round(earlier + time.monotonic() - started))

    for name, make in {
        "paraboloids.csv": lambda: paraboloids((32, 64, 128)),
        "exact_shapes.csv": lambda: exact_shapes((32, 64)),
        "finite_bodies.csv": lambda: finite_bodies((8, 16), (0.75, 1.0, 2.0, 5.0), (1e-5, 1e-4, 1e-3, 1e-2)),
    }.items():
        if not (options.go_on and (HERE / name).exists()):
            written(name, make())
    rows = read_csv(HERE / "whole_bodies.csv") if options.go_on and (HERE / "whole_bodies.csv").exists() else []
    for pair in WHOLE_PAIRS:
        if not any(row["pair"] == pair.name for row in rows):
            rows.extend(whole_bodies(pair))
            names = [one.name for one in WHOLE_PAIRS]
            rows.sort(key=lambda row: names.index(row["pair"]))
            written("whole_bodies.csv", rows)


if __name__ == "__main__":
    main()
