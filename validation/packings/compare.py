# SPDX-License-Identifier: MIT OR Apache-2.0
"""Random packings of ellipsoids, made by LAMMPS with the decks here: solid fraction and coordination against shape."""
from __future__ import annotations

import argparse
import os
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np

import ellgran
from packing_measures import Measures, measures
from stored import read_csv, write_csv, write_origin

HERE = Path(__file__).resolve().parent
#: Length of the axis of revolution over that of the others.
ASPECT_RATIOS = (1.0, 1.5, 0.6, 4.0, 0.25, 1.8, 0.7, 1.2, 0.85, 2.5, 0.4)
#: The ellipsoids of Man et al. (2005).
THREE_AXES = (1.25, 1.0, 0.8)
FRICTION = (0.0, 0.5)
PROTOCOLS = ("compressed", "settled")
#: The law of the decks, without what it does in motion.
LAW = "hertz 1 0.3"
#: Grains with fewer contacts bear no load: a force and three coordinates to balance without friction, a line of two contacts with it.
LEAST_CONTACTS = {False: 4, True: 2}


@dataclass(frozen=True)
class Case:
    """One packing. Axes have the product 1: lengths are in diameters of the sphere of the same volume."""

    protocol: str
    friction: float
    shape: str
    axes: Tuple[float, float, float]
    realisation: int

    @property
    def seed(self) -> int:
        return 1000 * self.realisation + 11


def shapes() -> Dict[str, Tuple[float, float, float]]:
    """Axes by name. The first is the unequal one, which the measure of orientation takes."""
    named = {f"{ratio:g}:1:1": (ratio ** (2 / 3), ratio ** (-1 / 3), ratio ** (-1 / 3)) for ratio in ASPECT_RATIOS}
    named["1.25:1:0.8"] = THREE_AXES
    return named


def cases(realisations: int) -> List[Case]:
    """All shapes once before any of them twice."""
    return [
        Case(protocol, friction, name, axes, realisation)
        for realisation in range(1, realisations + 1)
        for name, axes in shapes().items()
        for protocol in PROTOCOLS
        for friction in FRICTION
    ]


def touching(packing: ellgran.Packing) -> np.ndarray:
    """Pairs in contact, by the law itself."""
    return packing.contacts(LAW, quantities=[]).pairs


def measured(case: Case, packing: ellgran.Packing) -> Measures:
    layer = None
    if case.protocol == "settled":
        # The middle half by height: walls order what is within a few grains of them, and the top is loose.
        packing.box.periodic[2] = False
        top = 2 * float(packing.bodies.positions[:, 2].mean())
        layer = (0.25 * top, 0.75 * top)
    return measures(packing, touching(packing), LEAST_CONTACTS[case.friction > 0], layer)


def made(case: Case, grains: int) -> Dict[str, Any]:
    """Runs LAMMPS; a row of the table."""
    started = time.monotonic()
    deck = {"compressed": "compress.lmp", "settled": "settle.lmp"}[case.protocol]
    with tempfile.TemporaryDirectory() as directory:
        values = {
            "plugin": os.environ["ELLGRAN_LAMMPS_PLUGIN"],
            "dump": "packing.dump",
            "grains": grains,
            "friction": case.friction,
            "seed": case.seed,
            **dict(zip(("dx", "dy", "dz"), (f"{axis:.15g}" for axis in case.axes))),
        }
        words = [str(word) for name, value in values.items() for word in ("-var", name, value)]
        run = subprocess.run(
            [os.environ["ELLGRAN_LAMMPS"], "-nocite", "-log", "none", "-in", str(HERE / deck), *words],
            cwd=directory,
            capture_output=True,
            text=True,
        )
        if run.returncode != 0:
            raise RuntimeError(f"LAMMPS stopped at {case}:\n{run.stdout[-2000:]}{run.stderr[-2000:]}")
        packing = ellgran.last_frame(Path(directory) / "packing.dump").packing()
        found = measured(case, packing)
    return {
        "protocol": case.protocol,
        "friction": case.friction,
        "shape": case.shape,
        "realisation": case.realisation,
        "seed": case.seed,
        "grains": grains,
        "solid_fraction": found.solid_fraction,
        "coordination": found.coordination,
        "rattlers": found.rattlers,
        "order": found.order,
        "seconds": round(time.monotonic() - started, 1),
    }


def main() -> None:
    options = argparse.ArgumentParser()
    options.add_argument("--grains", type=int, default=1000)
    options.add_argument("--realisations", type=int, default=3)
    options.add_argument("--go-on", action="store_true", help="keep the packings that packings.csv has, and make the others")
    given = options.parse_args()
    started = time.monotonic()
    order = cases(given.realisations)
    position = {case: number for number, case in enumerate(order)}
    rows: Dict[int, Dict[str, Any]] = {}
    stored = HERE / "packings.csv"
    if given.go_on and stored.is_file():
        by_name = {(c.protocol, c.friction, c.shape, c.realisation): number for c, number in position.items()}
        for row in read_csv(stored):
            number = by_name.get((row["protocol"], row["friction"], row["shape"], int(row["realisation"])))
            if number is not None and row["grains"] == given.grains:
                rows[number] = {**row, **{key: int(row[key]) for key in ("realisation", "seed", "grains")}}
    cores = len(os.sched_getaffinity(0))
    missing = [case for case in order if position[case] not in rows]
    with ThreadPoolExecutor(cores) as workers:
        running = {workers.submit(made, case, given.grains): case for case in missing}
        for done in as_completed(running):
            case, row = running[done], done.result()
            rows[position[case]] = row
            print(
                f"{len(rows)} of {len(order)}: {case.protocol}, friction {case.friction:g}, {row['shape']}: "
                f"solid fraction {row['solid_fraction']:.4f}, coordination {row['coordination']:.2f}, {row['seconds']} s",
                flush=True,
            )
            write_csv(stored, [rows[number] for number in sorted(rows)])
    # Of one core: the packings are made side by side, each on its own.
    seconds = round(sum(float(row["seconds"]) for row in rows.values()))
    write_origin(HERE, started, seconds=seconds, LAMMPS=os.environ["ELLGRAN_LAMMPS_VERSION"])


if __name__ == "__main__":
    main()
