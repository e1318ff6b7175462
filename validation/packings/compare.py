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
#: What is made with the usual and with this many times the time, without friction: compressed and left to rest, or left to rest after it settled.
SLOWNESS = 10
SLOW_GRAINS = 300
MADE_SLOWLY = (("compressed", "1.25:1:0.8"), ("settled", "1.25:1:0.8"))
#: The law of the decks, without what it does in motion.
LAW = "hertz 1 0.3"
#: Grains with fewer contacts bear no load: a force and three coordinates to balance without friction, a line of two contacts with it.
LEAST_CONTACTS = {False: 4, True: 2}


@dataclass(frozen=True)
class Case:
    """One packing. Axes have the product 1: lengths are in diameters of the sphere of the same volume.

    The protocol is one of `PROTOCOLS`, or one of them and `, slowly`.
    """

    protocol: str
    friction: float
    shape: str
    axes: Tuple[float, float, float]
    realisation: int

    @property
    def seed(self) -> int:
        return 1000 * self.realisation + 11

    @property
    def slowly(self) -> bool:
        return self.protocol.endswith(", slowly")


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


def small_cases() -> List[Case]:
    """Those made slowly, and the same grains as usual."""
    return [Case(f"{protocol}{slowly}", 0.0, name, shapes()[name], 1) for protocol, name in MADE_SLOWLY for slowly in ("", ", slowly")]


def touching(packing: ellgran.Packing) -> np.ndarray:
    """Pairs in contact, by the law itself."""
    return packing.contacts(LAW, quantities=[]).pairs


def measured(case: Case, packing: ellgran.Packing) -> Measures:
    layer = None
    if case.protocol.startswith("settled"):
        # The middle half by height: walls order what is within a few grains of them, and the top is loose.
        packing.box.periodic[2] = False
        top = 2 * float(packing.bodies.positions[:, 2].mean())
        layer = (0.25 * top, 0.75 * top)
    return measures(packing, touching(packing), LEAST_CONTACTS[case.friction > 0], layer)


def made(case: Case, grains: int) -> Dict[str, Any]:
    """Runs LAMMPS; a row of the table."""
    deck = {"compressed": "compress.lmp", "settled": "settle.lmp"}[case.protocol.split(", ")[0]]
    with tempfile.TemporaryDirectory() as directory:
        values = {
            "plugin": os.environ["ELLGRAN_LAMMPS_PLUGIN"],
            "dump": "packing.dump",
            "grains": grains,
            "friction": case.friction,
            "seed": case.seed,
            "slowness": SLOWNESS if case.slowly else 1,
            **dict(zip(("dx", "dy", "dz"), (f"{axis:.15g}" for axis in case.axes))),
        }
        words = [str(word) for name, value in values.items() for word in ("-var", name, value)]
        said = Path(directory) / "said"
        with open(said, "w") as file:
            run = subprocess.Popen(
                [os.environ["ELLGRAN_LAMMPS"], "-nocite", "-log", "none", "-in", str(HERE / deck), *words],
                cwd=directory,
                stdout=file,
                stderr=subprocess.STDOUT,
            )
            # wait4 alone tells the processor time of this one child; others run beside it.
            _, status, used = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
        if run.returncode != 0:
            raise RuntimeError(f"LAMMPS stopped at {case}:\n{said.read_text()[-4000:]}")
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
        "seconds": round(used.ru_utime + used.ru_stime, 1),
    }


def main() -> None:
    options = argparse.ArgumentParser()
    options.add_argument("--grains", type=int, default=2000)
    options.add_argument("--realisations", type=int, default=1)
    options.add_argument("--go-on", action="store_true", help="keep the packings that packings.csv has, of any size, and make the others")
    given = options.parse_args()
    started = time.monotonic()
    stored = HERE / "packings.csv"
    kept: List[Dict[str, Any]] = []
    if given.go_on and stored.is_file():
        kept = [{**row, **{key: int(row[key]) for key in ("realisation", "seed", "grains")}} for row in read_csv(stored)]
    there = {(row["protocol"], row["friction"], row["shape"], row["realisation"], row["grains"]) for row in kept}
    wanted = [(case, given.grains) for case in cases(given.realisations)] + [(case, SLOW_GRAINS) for case in small_cases()]
    order = list(dict.fromkeys(wanted))
    missing = [
        (number, case, grains)
        for number, (case, grains) in enumerate(order)
        if (case.protocol, case.friction, case.shape, case.realisation, grains) not in there
    ]
    rows: Dict[int, Dict[str, Any]] = {}
    cores = len(os.sched_getaffinity(0))
    with ThreadPoolExecutor(cores) as workers:
        running = {workers.submit(made, case, grains): (number, case) for number, case, grains in missing}
        for done in as_completed(running):
            (number, case), row = running[done], done.result()
            rows[number] = row
            print(
                f"{len(rows)} of {len(missing)}: {case.protocol}, friction {case.friction:g}, {row['shape']}: "
                f"solid fraction {row['solid_fraction']:.4f}, coordination {row['coordination']:.2f}, {row['seconds']} s",
                flush=True,
            )
            write_csv(stored, kept + [rows[number] for number in sorted(rows)])
    # Processor time: the packings are made side by side, each on its own core.
    seconds = round(sum(float(row["seconds"]) for row in [*kept, *rows.values()]))
    write_origin(HERE, started, seconds=seconds, LAMMPS=os.environ["ELLGRAN_LAMMPS_VERSION"])


if __name__ == "__main__":
    main()
