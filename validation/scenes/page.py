# SPDX-License-Identifier: MIT OR Apache-2.0
"""docs/report/scenes.md and its picture, from the stored results."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np

from report_page import COLOURS, plt, save, table, write
from stored import read_csv

HERE = Path(__file__).resolve().parent
STEP = 2e-5
GRAIN = 2500 * np.pi / 6 * 0.005 * 0.0035**2

Row = Dict[str, Any]


def dissipated(row: Row) -> float:
    return row["viscosity"] + row["friction"]


def column(rows: List[Row], name: str) -> np.ndarray:
    return np.array([row[name] for row in rows])


def discharge(rows: List[Row]) -> Tuple[np.ndarray, np.ndarray, float]:
    """Time since the gate went, share that has passed, and the mean rate in grains a second between a tenth and a half of them."""
    above = column(rows, "above")
    opened = int(np.flatnonzero(above < above[0])[0]) - 1
    time = (column(rows, "step")[opened:] - rows[opened]["step"]) * STEP
    passed = 1 - above[opened:] / above[0]
    first, last = np.interp([0.1, 0.5], passed, time)
    return time, passed, float(0.4 * above[0] / (last - first))


def main() -> None:
    drums = read_csv(HERE / "drum.csv")
    names = list(dict.fromkeys(row["run"] for row in drums))
    runs = {name: [row for row in drums if row["run"] == name] for name in names}
    of_hopper = read_csv(HERE / "hopper.csv")
    hopper_runs = {name: [row for row in of_hopper if row["run"] == name] for name in names}
    hopper = hopper_runs[names[0]]
    hoppers = {"LAMMPS": hopper, "LIGGGHTS": read_csv(HERE / "hopper_liggghts.csv")}

    figure, plots = plt.subplots(1, 3, figsize=(14, 4.2))
    one = runs[names[0]]
    time = column(one, "step") * STEP
    for colour, (label, values) in zip(
        COLOURS,
        {
            "kinetic": column(one, "kinetic"),
            "gravitation": column(one, "gravitation") - one[0]["gravitation"],
            "dissipated by viscosity": column(one, "viscosity"),
            "dissipated by friction": column(one, "friction"),
            "work of the drum": column(one, "work"),
        }.items(),
    ):
        plots[0].plot(time, values, color=colour, linewidth=1.2, label=label)
    plots[0].set(xlabel="time, s", ylabel="energy, J", title="drum")
    plots[0].legend()
    for colour, name in zip(COLOURS, names):
        rows = [row for row in runs[name] if dissipated(row) > 0.01 * dissipated(runs[name][-1])]
        plots[1].plot(column(rows, "step") * STEP, np.abs([row["left_over"] / dissipated(row) for row in rows]), color=colour, linewidth=1.2, label=f"drum, {name}")
    for colour, name in zip(COLOURS, names):
        rows = [row for row in hopper_runs[name] if dissipated(row) > 0.01 * dissipated(hopper_runs[name][-1])]
        plots[1].plot(column(rows, "step") * STEP, np.abs([row["left_over"] / dissipated(row) for row in rows]), color=colour, linewidth=1.2, linestyle=":", label=f"hopper, {name}")
    plots[1].axhline(1e-3, color="#333333", linewidth=0.8, linestyle="--")
    plots[1].set(yscale="log", xlabel="time, s", ylabel="left over / dissipated", title="balance of energies")
    plots[1].legend()
    rates = {}
    for colour, (engine, rows) in zip(COLOURS, hoppers.items()):
        since, passed, rates[engine] = discharge(rows)
        plots[2].plot(since, passed, color=colour, linewidth=1.2, label=f"{engine}: {rates[engine]:.0f} grains a second")
    plots[2].set(xlabel="time since the gate was taken away, s", ylabel="share that has left", title="hopper")
    plots[2].legend(loc="lower right")
    worst = max(abs(rows[-1]["left_over"]) / dissipated(rows[-1]) for rows in [*runs.values(), *hopper_runs.values()])
    # Two independent draws of about as many grains, which arrive in no order.
    apart = abs(rates["LAMMPS"] / rates["LIGGGHTS"] - 1)
    save(figure, HERE, f"The energies of whole scenes add up to {worst:.1e} of what is dissipated")

    grains = int(one[0]["grains"])
    turns = one[-1]["step"] * STEP / 1.57
    conclusion = (
        f"After {turns:.2g} turns of the drum, and when the hopper has run out, the balance of energies leaves over at most {worst:.1e} of what was dissipated, on one rank, on four and over a "
        f"restart in the middle. The hopper discharges at {rates['LAMMPS']:.0f} grains a second in LAMMPS and {rates['LIGGGHTS']:.0f} in LIGGGHTS, {100 * apart:.1f} % apart."
    )

    def cells(name: str, rows: List[Row]) -> List[str]:
        last = rows[-1]
        return [
            name,
            f"{last['grains']:.0f}",
            f"{last['step']:.0f}",
            f"{last['viscosity']:.5f}",
            f"{last['friction']:.5f}",
            f"{last.get('work', 0.0):.5f}",
            f"{last['left_over']:+.1e}",
            f"{last['left_over'] / dissipated(last):+.1e}",
        ]

    head = ["scene", "grains", "steps", "viscosity, J", "friction, J", "work of the drum, J", "left over, J", "of the dissipated"]
    same = max(abs(a["work"] - b["work"]) for a, b in zip(runs["one rank"], runs["restarted"]) if a["step"] <= one[-1]["step"] / 2)
    half = [row for row in runs["restarted"] if row["step"] > one[-1]["step"] / 2]
    mean = {name: float(np.mean([row["torque"] for row in rows if row["step"] > one[-1]["step"] / 2])) for name, rows in runs.items()}
    spread = {name: float(np.std([row["torque"] for row in rows if row["step"] > one[-1]["step"] / 2]) / np.sqrt(len(half))) for name, rows in runs.items()}
    parts = [
        f"The drum (`drum.lmp`): {grains} ellipsoids of aspect ratio 2.5, 8 mm long, in a cylinder that turns once in 1.57 s. The hopper (`hopper.lmp`, `hopper.lig`): {hopper[0]['grains']:.0f} "
        "ellipsoids of aspect ratio 1.43, 5 mm long, in a cylinder of radius 50 mm on a cone of 45° with an outlet of radius 20 mm, a mesh of 192 triangles. NFD and TFD, `fix nve/ellipsoid`, steps of 2e-5 s.",
        "## Energies\n\n" + table(head, [*[cells(f"drum, {name}", rows) for name, rows in runs.items()], *[cells(f"hopper, {name}", rows) for name, rows in hopper_runs.items()]]) + "\n"
        "What is left over is the error of the time step. Grains collide in a disordered way, so that after a while runs on another number of ranks differ in each grain and agree in the mean: "
        + "; ".join(f"{name}: mean torque of the second half {mean[name]:.5f} ± {spread[name]:.5f} N m" for name in names)
        + (" (the restarted run's first half is the whole run's to the last digit)." if same == 0 else f" (first halves apart by {same:.1e} J of work)."),
        "## Discharge\n\n"
        + "; ".join(
            f"{engine}: {rates[engine]:.1f} grains a second ({rates[engine] * GRAIN:.4f} kg/s) between a tenth and a half of the {rows[0]['above']:.0f} grains, {rows[-1]['above']:.0f} left above the outlet"
            for engine, rows in hoppers.items()
        )
        + ". In LAMMPS on other ranks: "
        + "; ".join(f"{name} {discharge(rows)[2]:.1f} a second" for name, rows in hopper_runs.items() if name != names[0])
        + ". Positions at the start are the same in both engines, orientations are drawn by each.",
    ]
    write(HERE, "Whole scenes", conclusion, parts, ["drum.csv", "hopper.csv", "hopper_liggghts.csv"])


if __name__ == "__main__":
    main()
