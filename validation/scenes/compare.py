# SPDX-License-Identifier: MIT OR Apache-2.0
"""Whole scenes to their end: a drum and a hopper of 5 000 ellipsoids. Does the balance of energies close, on one rank and four and over a
restart in the middle, of both; does the hopper discharge at the same rate in LAMMPS and LIGGGHTS?"""
from __future__ import annotations

import argparse
import os
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Dict, List, Sequence

import numpy as np

from stored import write_csv, write_origin

HERE = Path(__file__).resolve().parent
STEP = 2e-5
#: One turn of the drum.
TURN = round(1.57 / STEP)
#: Columns of drum.lmp and hopper.lmp.
DRUM = ("step", "grains", "kinetic", "rotation", "elastic", "gravitation", "viscosity", "friction", "work", "left_over", "torque", "aside")
HOPPER = ("step", "grains", "above", "kinetic", "viscosity", "friction", "left_over")


def hopper_mesh(path: Path, corners: int = 48) -> None:
    """A cylinder of radius 0.05 m and height 0.3 m on a cone of 45 degrees that ends in an outlet of radius 0.02 m, as ASCII STL."""
    angles = 2 * np.pi * np.arange(corners + 1) / corners
    rings = [np.array([(r * np.cos(a), r * np.sin(a), z) for a in angles]) for r, z in ((0.05, 0.3), (0.05, 0.0), (0.02, -0.03))]
    lines = ["solid hopper"]
    for upper, lower in zip(rings, rings[1:]):
        for k in range(corners):
            for triangle in ((upper[k], lower[k], lower[k + 1]), (upper[k], lower[k + 1], upper[k + 1])):
                normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
                normal /= np.linalg.norm(normal)
                lines += ["facet normal {:.9g} {:.9g} {:.9g}".format(*normal), "outer loop"]
                lines += ["vertex {:.9g} {:.9g} {:.9g}".format(*vertex) for vertex in triangle]
                lines += ["endloop", "endfacet"]
    lines.append("endsolid hopper")
    path.write_text("\n".join(lines) + "\n")


def run(program: str, deck: str, values: Dict[str, Any], columns: Sequence[str], ranks: int = 1) -> List[Dict[str, float]]:
    """The rows that the deck prints; a step that two runs print is there once."""
    words = [str(word) for name, value in values.items() for word in ("-var", name, value)]
    command = [program, *(["-nocite"] if deck.endswith(".lmp") else []), "-log", "none", "-in", str(HERE / deck), *words]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks), *command]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    rows: Dict[float, Dict[str, float]] = {}
    inside = False
    for line in done.stdout.splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            inside = True
        elif line.startswith("Loop time"):
            inside = False
        elif inside and len(words) == len(columns):
            numbers = [float(word) for word in words]
            rows[numbers[0]] = dict(zip(columns, numbers))
    return list(rows.values())


def named(name: str, rows: List[Dict[str, float]]) -> List[Dict[str, Any]]:
    return [{"run": name, **row} for row in rows]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--grains", type=int, default=5000, help="of the drum; the hopper has as many, to a layer")
    parser.add_argument("--turns", type=float, default=0.5, help="of the drum")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time")
    options = parser.parse_args()
    started = time.monotonic()
    lammps, liggghts = os.environ["ELLGRAN_LAMMPS"], os.environ["ELLGRAN_LIGGGHTS"]
    plugin = os.environ["ELLGRAN_LAMMPS_PLUGIN"]
    with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(options.jobs) as pool:
        steps = round(options.turns * TURN / 500) * 500
        # As full a drum at any number of grains.
        drum = {"plugin": plugin, "grains": options.grains, "radius": f"{0.08 * (options.grains / 5000) ** 0.5:.6g}"}
        stl = Path(scratch) / "hopper.stl"
        hopper_mesh(stl)
        # 177 grains a layer of the lattice.
        layers = max(1, round(options.grains / 177))
        hopper = {"stl": stl, "top": f"{0.0055 + 0.006 * layers:.6g}", "fill": 15000}
        flow = round(10 * options.grains)

        def whole(scene: str, values: Dict[str, Any], last: int, columns: Sequence[str], ranks: int) -> List[Dict[str, float]]:
            return run(lammps, f"{scene}.lmp", {**values, "steps": last, "restart": f"{scratch}/{scene}.{ranks}"}, columns, ranks)

        def restarted(scene: str, values: Dict[str, Any], half: int, last: int, columns: Sequence[str]) -> List[Dict[str, float]]:
            first = run(lammps, f"{scene}.lmp", {**values, "steps": half, "restart": f"{scratch}/{scene}.half"}, columns)
            again = {"continued": "yes", "from": f"{scratch}/{scene}.half", "restart": f"{scratch}/{scene}.end"}
            return first[:-1] + run(lammps, f"{scene}.lmp", {**values, **again, "steps": last}, columns)

        scenes = {}
        for scene, values, half, last, columns in (
            ("drum", drum, steps // 1000 * 500, steps, DRUM),
            ("hopper", {"plugin": plugin, **hopper}, 15000 + flow // 2, 15000 + flow, HOPPER),
        ):
            scenes[scene] = {
                "one rank": pool.submit(whole, scene, values, last, columns, 1),
                "four ranks": pool.submit(whole, scene, values, last, columns, 4),
                "restarted": pool.submit(restarted, scene, values, half, last, columns),
            }
        in_liggghts = pool.submit(run, liggghts, "hopper.lig", {**hopper, "flow": flow}, HOPPER[:3])
        for scene, runs in scenes.items():
            write_csv(HERE / f"{scene}.csv", [row for name, rows in runs.items() for row in named(name, rows.result())])
        write_csv(HERE / "hopper_liggghts.csv", in_liggghts.result())
    words = "" if options.grains == 5000 and options.turns == 0.5 else f" -- --grains {options.grains} --turns {options.turns}"
    write_origin(HERE, started, command=f"cargo xtask validate scenes{words}", LAMMPS=os.environ["ELLGRAN_LAMMPS_VERSION"])


if __name__ == "__main__":
    main()
