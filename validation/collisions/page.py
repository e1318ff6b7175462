# SPDX-License-Identifier: MIT OR Apache-2.0
"""docs/report/collisions.md and its picture, from the stored results."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Sequence

from compare import FRICTION, GRIDS, RELAXATION, STEPS, VIBRATIONS
from free_body import WIDTH
from report_page import COLOURS, plt, save, table, write
from stored import read_csv

HERE = Path(__file__).resolve().parent
Row = Dict[str, Any]
#: Elements across the contact.
COARSE, MEDIUM, FINE = (grid.across for grid in GRIDS.values())
#: What is left from the medium grid on, over the change from the coarse to the medium one, where the error falls as the square of the element.
EXTRAPOLATED = 1 / ((MEDIUM / COARSE) ** 2 - 1)
SPEED_AND_SPIN = ("restitution", "velocity_x", "velocity_z", "spin_lower", "spin_upper")


def chosen(rows: Sequence[Row], **wanted: Any) -> List[Row]:
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def span(values: Sequence[float], form: str = ".1f", factor: float = 100.0) -> str:
    low, high = (f"{factor * value:{form}}".replace("-", "−") for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def number(value: float, digits: int = 3) -> str:
    return f"{value:.{digits}f}".replace("-", "−")


def signed(value: float, digits: int = 1) -> str:
    """Per cent."""
    return f"{100 * value:+.{digits}f}".replace("-", "−")


class Results:
    """The stored rows. The reference is the medium grid; its error bar is the distance to what follows from the coarse one by extrapolation
    at second order, or to the fine one where it is larger."""

    def __init__(self) -> None:
        self.rows = read_csv(HERE / "collisions.csv")
        self.laws = read_csv(HERE / "laws.csv")
        self.forces = read_csv(HERE / "forces.csv")
        self.full = chosen(self.rows, grid="medium")
        self.poses = list(dict.fromkeys(row["pose"] for row in self.full))
        self.speeds = sorted({row["speed"] for row in self.full})

    def on(self, grid: str, row: Row) -> List[Row]:
        return chosen(self.rows, grid=grid, pose=row["pose"], speed=row["speed"], impact=row["impact"])

    def bar(self, row: Row, name: str) -> float:
        change = abs(self.on("coarse", row)[0][name] - row[name])
        return max(EXTRAPOLATED * change, *(abs(other[name] - row[name]) for other in self.on("fine", row)), 0.0)

    def by(self, law: str, row: Row) -> Row:
        return chosen(self.laws, law=law, pose=row["pose"], speed=row["speed"], impact=row["impact"])[0]

    def with_bar(self, row: Row, name: str, digits: int = 3) -> str:
        # A duration is a whole number of steps.
        bar = max(self.bar(row, name), 1 / STEPS if name == "duration" else 0.0)
        return f"{number(row[name], digits)} ± {bar:.0e}"


def pick(results: Results, impact: str) -> List[Row]:
    return chosen(results.full, impact=impact)


def normal_table(results: Results) -> str:
    head = ["pose", "v/c", "largest force: law", "duration: elements", "law", "restitution: elements", "law", "in vibration, %"]
    rows = []
    for row in pick(results, "normal"):
        law = results.by("NFD+TFD", row)
        rows.append(
            [
                row["pose"],
                f"{row['speed']:g}",
                f"{signed(law['peak_force'] / row['peak_force'] - 1)} ± {100 * results.bar(row, 'peak_force') / row['peak_force']:.1f} %",
                results.with_bar(row, "duration"),
                number(law["duration"]),
                results.with_bar(row, "restitution", 4),
                number(law["restitution"], 4),
                f"{100 * row['vibration']:.2f} ± {100 * results.bar(row, 'vibration'):.2f}",
            ]
        )
    return table(head, rows)


def viscous_table(results: Results) -> str:
    head = ["pose", "v/c", "restitution: elements", "NFD", "LSD", "spheres", "largest force: NFD", "LSD", "spheres", "duration: elements", "NFD", "LSD"]
    rows = []
    for row in pick(results, "normal, viscous"):
        nfd, lsd, spheres = (results.by(law, row) for law in ("NFD+TFD", "LSD", "spheres"))
        rows.append(
            [
                row["pose"],
                f"{row['speed']:g}",
                results.with_bar(row, "restitution"),
                *(number(law["restitution"]) for law in (nfd, lsd, spheres)),
                *(f"{signed(law['peak_force'] / row['peak_force'] - 1)} %" for law in (nfd, lsd, spheres)),
                results.with_bar(row, "duration"),
                number(nfd["duration"]),
                number(lsd["duration"]),
            ]
        )
    return table(head, rows)


def oblique_table(results: Results, impacts: Sequence[str]) -> str:
    head = ["pose", "v/c", "impact", "along: elements", "law", "apart: elements", "law", "spins: elements", "law", "lost to friction, %", "force differs by, %"]
    rows = []
    for row in results.full:
        if row["impact"] not in impacts:
            continue
        law = results.by("NFD+TFD", row)
        same = row["pose"] != "crossed"
        spins = [results.with_bar(row, "spin_lower"), number(law["spin_lower"])]
        if not same:
            spins = [f"{old}, {new}" for old, new in zip(spins, (results.with_bar(row, "spin_upper"), number(law["spin_upper"])))]
        rows.append(
            [
                row["pose"],
                f"{row['speed']:g}",
                row["impact"],
                results.with_bar(row, "velocity_x"),
                number(law["velocity_x"]),
                results.with_bar(row, "velocity_z"),
                number(law["velocity_z"]),
                *spins,
                f"{100 * row['friction']:.1f}",
                f"{100 * law['force_difference']:.1f}",
            ]
        )
    return table(head, rows)


def spring_table(results: Results) -> str:
    head = ["pose", "v/c", "along: elements", "NFD+TFD", "LSD", "spheres", "apart: elements", "NFD+TFD", "LSD", "spheres", "spin: elements", "NFD+TFD", "LSD", "spheres"]
    rows = []
    for row in pick(results, "45 degrees, viscous"):
        laws = [results.by(law, row) for law in ("NFD+TFD", "LSD", "spheres")]
        cells = [row["pose"], f"{row['speed']:g}"]
        for name in ("velocity_x", "velocity_z", "spin_lower"):
            cells += [results.with_bar(row, name), *(number(law[name]) for law in laws)]
        rows.append(cells)
    return table(head, rows)


def picture(results: Results, title: str) -> None:
    figure, grid = plt.subplots(2, 3, figsize=(13.5, 8.0))
    plots = grid.ravel()
    shown = [("elements", "finite elements", "-"), ("NFD+TFD", "NFD+TFD", "--"), ("LSD", "LSD", ":")]

    def curve(plot: Any, pose: str, impact: str, speed: float, component: str, colour: str, scale: float) -> None:
        for label, law, style in shown:
            of = chosen(results.forces, pose=pose, impact=impact, speed=speed, law=law)
            if of:
                plot.plot([0.0] + [r["time"] for r in of], [0.0] + [r[component] / scale for r in of], style, color=colour, linewidth=1.4, label=f"{pose}, {label}")

    slow, fast = results.speeds[0], results.speeds[-1]
    for plot, speed in ((plots[0], slow), (plots[1], fast)):
        for colour, pose in zip(COLOURS, ("side by side", "oblique", "tip to tip")):
            scale = chosen(results.full, pose=pose, speed=speed, impact="normal, viscous")[0]["peak_force"]
            curve(plot, pose, "normal, viscous", speed, "force_z", colour, scale)
        plot.set(xlabel="time, semi-axis / c", ylabel="force / largest by finite elements", title=f"normal, viscous, v/c = {speed:g}")
    plots[0].legend()
    middle = results.speeds[1]
    for colour, pose in zip(COLOURS, results.poses):
        curve(plots[2], pose, "45 degrees", middle, "force_x", colour, chosen(results.full, pose=pose, speed=middle, impact="45 degrees")[0]["peak_force"])
    plots[2].set(xlabel="time, semi-axis / c", ylabel="force along x / largest normal force", title=f"45 degrees, v/c = {middle:g}")
    plots[2].legend()
    for colour, pose in zip(COLOURS, results.poses):
        of = chosen(results.full, pose=pose, impact="normal")
        plots[3].plot([r["speed"] for r in of], [r["vibration"] for r in of], "o-", color=colour, markersize=4, linewidth=1, label=pose)
        of = chosen(results.full, pose=pose, impact="normal, viscous")
        plots[4].plot([r["speed"] for r in of], [r["restitution"] for r in of], "o", color=colour, markersize=4, label=pose)
        for law, style in (("NFD+TFD", "-"), ("LSD", ":")):
            plots[4].plot([r["speed"] for r in of], [results.by(law, r)["restitution"] for r in of], style, color=colour, linewidth=1)
    plots[3].set(xscale="log", yscale="log", xlabel="v/c", ylabel="share of the energy left in vibration", title="normal, elastic: what no contact law has")
    plots[3].legend()
    plots[4].set(xscale="log", xlabel="v/c", ylabel="restitution at the contact", title="normal, viscous: elements (points), NFD (lines), LSD (dots)")
    plots[4].legend()
    for colour, pose in zip(COLOURS, results.poses):
        of = [r for r in results.full if r["pose"] == pose and "degrees" in r["impact"]]
        plots[5].plot([r["velocity_x"] for r in of], [results.by("NFD+TFD", r)["velocity_x"] for r in of], "o", color=colour, markersize=4, label=f"{pose}: along")
        plots[5].plot([r["spin_lower"] for r in of], [results.by("NFD+TFD", r)["spin_lower"] for r in of], "+", color=colour, markersize=6, label=f"{pose}: spin")
    ends = plots[5].get_xlim()
    plots[5].plot(ends, ends, color="#333333", linewidth=0.8)
    plots[5].set(xlabel="finite elements, over the speed of approach", ylabel="NFD+TFD", title="oblique: rebound along x, and spin")
    plots[5].legend()
    save(figure, HERE, title)


def grid_table(results: Results) -> str:
    """Where there are three grids."""
    head = ["pose, impact", "quantity", "coarse", "medium", "fine", "extrapolated from coarse and medium"]
    lines = []
    for row in results.full:
        finer = results.on("fine", row)
        if not finer or row["impact"] not in ("normal", "45 degrees, viscous"):
            continue
        quantities = [("largest force, 1e-3", "peak_force", 1e3), ("restitution", "restitution", 1.0)]
        quantities += [("along", "velocity_x", 1.0), ("spin", "spin_lower", 1.0)] if "degrees" in row["impact"] else [("in vibration", "vibration", 1.0)]
        for label, name, scale in quantities:
            coarse, medium, fine = (scale * r[name] for r in (results.on("coarse", row)[0], row, finer[0]))
            cells = (coarse, medium, fine, medium + EXTRAPOLATED * (medium - coarse))
            lines.append([f"{row['pose']}, {row['impact']}", label, *(number(value, 4) for value in cells)])
    return table(head, lines)


def main() -> None:
    results = Results()
    slow, middle, fast = results.speeds
    normal, viscous = pick(results, "normal"), pick(results, "normal, viscous")
    oblique = [row for row in results.full if "degrees" in row["impact"]]
    checks, whole, pressed = (read_csv(HERE / f"{name}.csv") for name in ("checks", "whole_mesh", "pressed"))
    periods = read_csv(HERE / "vibrations.csv")

    def of_force(row: Row, law: str = "NFD+TFD") -> float:
        return results.by(law, row)["peak_force"] / row["peak_force"] - 1

    def of(name: str, row: Row, law: str = "NFD+TFD") -> float:
        return results.by(law, row)[name] - row[name]

    def back(row: Row, law: str) -> float:
        force = [r["force_x"] for r in chosen(results.forces, pose=row["pose"], speed=row["speed"], impact=row["impact"], law=law)]
        return max(0.0, *force) / row["peak_force"]

    def at(rows: Sequence[Row], speed: float, *poses: str) -> List[Row]:
        return [row for row in rows if row["speed"] == speed and (not poses or row["pose"] in poses)]

    short_ones = [pose for pose in results.poses if pose != "side by side"]
    long_fast, long_slow = at(normal, fast, "side by side")[0], at(normal, slow, "side by side")[0]
    long_viscous = at(viscous, fast, "side by side")[0]
    rest = [row for row in viscous if row["pose"] in short_ones]
    friction_bars = [results.bar(row, "velocity_x") for row in oblique]
    turns = {row["pose"]: row["duration"] / row["period"] for row in periods if row["speed"] == fast}
    slow_turns = {row["pose"]: row["duration"] / row["period"] for row in periods if row["speed"] == slow}
    worst_along = max(oblique, key=lambda row: abs(of("velocity_x", row)))
    sliding = [row for row in oblique if row["impact"] == "63 degrees" and row["pose"] in short_ones]
    sticking = [row for row in oblique if row["impact"] == "45 degrees" and row["pose"] in short_ones]
    conclusion = (
        f"Restitution by NFD is right to {100 * max(abs(of('restitution', r)) for r in rest):.1f} % of the speed of approach in three poses of aspect ratios 1.5 to 3 and speeds up to "
        f"{fast:g} of sound; its largest force errs by {span([of_force(r) for r in rest if r['speed'] == slow])} % at {slow:g} and {span([of_force(r) for r in rest if r['speed'] == fast])} % at {fast:g}, because grains are no half-spaces. "
        f"Grains of 3:1 side by side bend: {100 * long_slow['vibration']:.1f} % of the energy stays in vibration at {slow:g} and {100 * long_fast['vibration']:.0f} % at {fast:g}, where the restitution of elastic grains is "
        f"{long_fast['restitution']:.2f} and the law has {results.by('NFD+TFD', long_fast)['restitution']:.2f}. "
        f"With friction, the velocity along x after a collision that sticks is off by {span([of('velocity_x', r) for r in sticking], '+.3f', 1)} of the speed of approach in the other poses, and after one that slides by "
        f"{span([of('velocity_x', r) for r in sliding], '+.3f', 1)}. "
        f"LSD fitted at {middle:g} errs in the largest force by {span([of_force(r, 'LSD') for r in at(viscous, slow)])} % at {slow:g} and {span([of_force(r, 'LSD') for r in at(viscous, fast)])} % at {fast:g}."
    )
    picture(results, "Hertz, NFD and TFD hold for compact grains; long ones side by side keep energy in bending, which no contact law has")

    stored_rest = max(abs(row["rest"]) for row in results.rows)
    twice = {changed: max(abs(row[name] - chosen(results.rows, grid="coarse", pose=row["pose"], speed=row["speed"], impact=row["impact"])[0][name]) for row in checks if row["twice as many"] == changed for name in SPEED_AND_SPIN) for changed in ("vibrations", "steps")}
    reduced = max(abs(row["restitution"] - row["restitution_reduced"]) for row in whole)
    at_rest = max(abs(row["error"] - row["axisymmetric"]) for row in pressed)
    finer = sorted({row["pose"] for row in results.rows if row["grid"] == "fine"})
    third = f"; {FINE} elements ({FINE / WIDTH:.1f} nodes) for {', '.join(finer)} at v/c = {fast:g} (*fine*)" if finer else ""
    three = f"Three grids at v/c = {fast:g}:\n\n{grid_table(results)}" if finer else ""
    swing_back = "; ".join(
        f"{row['pose']} {back(row, 'finite elements'):.2f} by finite elements, {back(row, 'NFD+TFD'):.2f} by the law" for row in at(pick(results, "45 degrees"), middle)
    )
    parts = [
        f"""Equal prolate grains, smallest semi-axis 1, density 1, Young's modulus 1, Poisson's ratio 0.3: a speed of 1 is that of sound in a thin rod, c. The speed v is that of approach along the normal:
{', '.join(f'{speed:g}' for speed in results.speeds)} of c. For a modulus of 70 GPa and 2700 kg/m^3 the lowest is {slow * (70e9 / 2700) ** 0.5:.0f} m/s. The poses:

| pose | axes | how they meet | contact by Hertz over the period of the lowest vibration that it moves, at v/c = {slow:g} | at {fast:g} |
|---|---|---|---:|---:|
| crossed | 1.5:1:1 | long sides at right angles | {slow_turns['crossed']:.1f} | {turns['crossed']:.1f} |
| oblique | 2:1:1 | parallel, the normal at 45° to the long axes, off the centres | {slow_turns['oblique']:.1f} | {turns['oblique']:.1f} |
| tip to tip | 3:1:1 | long axes along the normal | {slow_turns['tip to tip']:.1f} | {turns['tip to tip']:.1f} |
| side by side | 3:1:1 | parallel, side on side | {slow_turns['side by side']:.1f} | {turns['side by side']:.1f} |

The impacts: *normal*, without relative velocity along the contact; at 45 and 63 degrees, with once and twice v along x and mu = {FRICTION:g}; *other side*: along -x, which only the oblique pose tells apart. *Viscous*: both viscosities are {RELAXATION:g} times their
moduli (in units of semi-axis over c). 63 degrees is left out where tips would slide past one another (tip to tip at {fast:g}). Each case is of two whole bodies; none is against a plane. Velocities are of the upper body relative to the lower one, over v; spins are about y, times the smallest semi-axis over v.
Restitution is of the velocity along the normal at the point of first touch.""",
        f"""## The reference

Quadratic hexahedra of 27 nodes, small strain, graded to the contact ellipse; the plane of motion is one of symmetry, so half of each body is meshed. The rigid motion is exact, rotation and sliding of the surfaces over one another included.
The {VIBRATIONS} lowest vibrations of each body have their inertia; all others follow the force at once, with the flexibility that the mesh gives them. In each step the inequalities are solved: no penetration, no tension, Coulomb's friction at each node, no penalty.

Grids of {COARSE} (*coarse*) and {MEDIUM} elements (*medium*) across the contact, which are {COARSE / WIDTH:.1f} and {MEDIUM / WIDTH:.1f} nodes along its semi-axis at the greatest compression by Hertz, in all collisions{third}.
The values are of the medium grid. The error bar is what extrapolation at second order adds to it, {EXTRAPOLATED:.1f} times the change from the coarse grid, or the change to a finer one where that is larger. The medium half bodies have {span([row['unknowns'] / 2 for row in results.full], '.0f', 1)} unknowns.

What it was held to:

- Energy: rigid motion, vibration, friction and viscosity add up to the energy before, to {stored_rest:.1e} of it at worst on any grid; to {max(abs(r['rest']) for r in results.full if r['impact'].startswith('normal')):.0e} without friction on the medium one. What does not add up is the small-strain model where surfaces slide far (tip to tip), and the steps.
- At rest, tip to tip without friction, the force agrees with the axisymmetric elements of [elastic contact](elastic-contact.md) to {100 * at_rest:.1f} % (aspect ratios 1 and 2, overlaps of 1e-4 to 1e-2 of the tip's radius).
- Implicit steps of the whole mesh, with the inertia of every node, in place of vibrations and flexibility: the restitution of normal impacts changes by at most {reduced:.4f} (side by side and tip to tip, three speeds, coarse grid).
- Twice as many vibrations change velocities and spins by at most {twice['vibrations']:.4f} of v, twice as many steps by {twice['steps']:.4f} (side by side at {fast:g}, coarse grid).
- A body turns by at most {max(r['rotation'] for r in results.full if r['speed'] == slow):.3f} rad during contact at {slow:g} and {max(r['rotation'] for r in results.full):.3f} at {fast:g}: so much is neglected where vibrations are taken about the orientation at first touch.

{three}""",
        f"""## Normal impacts, elastic

*Largest force: law* is its relative error. Duration is over that by Hertz (for the oblique pose with the mass that the contact feels).

{normal_table(results)}
Blunt grains are stiffer than half-spaces and collide harder and shorter than by Hertz; slender ones are softer, as [elastic contact](elastic-contact.md) has it at rest. Vibration takes little where the contact lasts several periods of the
lowest vibration, and much where it lasts about one: side by side at 3:1 bending has a period of {periods[-1]['period']:.1f}, the contact at {fast:g} a duration of {periods[-1]['duration']:.1f}.""",
        f"""## Normal impacts, viscous

Viscosities in proportion to the moduli, where NFD is exact for half-spaces ([viscoelastic contact](viscoelastic-contact.md)). *LSD* is fitted to duration and restitution of the finite elements in each pose at v/c = {middle:g}; forces are relative errors. *Spheres* are spheres of the same
volume with the same law, which is what an engine's own granular law of spheres takes (LAMMPS' `granular` with Hertz); the durations of spheres are not shown.

{viscous_table(results)}""",
        f"""## Oblique impacts, elastic and viscous

By NFD and TFD; *along* and *apart* are the velocities along x and z. Two spins where the bodies differ. *Force differs by*: root mean square of the difference of the force vector over time, over that of the force.

{oblique_table(results, ('45 degrees', '45 degrees, viscous', '45 degrees, other side', '63 degrees'))}
The largest error along x, {number(of('velocity_x', worst_along))} of v, is of *{worst_along['pose']}, {worst_along['impact']}* at {worst_along['speed']:g} (error bar {results.bar(worst_along, 'velocity_x'):.3f}). TFD has no hysteresis below sliding ([tangential contact](tangential-contact.md)), so its spring gives back what partial slip loses. In collisions that stick, the force turns its sign before the end. This swing back, over the largest normal force, at 45 degrees and v/c = {middle:g}: {swing_back}.""",
        f"""## LSD and spheres at 45 degrees, viscous

{spring_table(results)}
LSD has 2/7 of its normal stiffness and half of its normal damping along the contact, as LAMMPS' `gran/hooke` has by default. Spheres spin as spheres: neither their moment of inertia nor the arm of the force is that of the grain.""",
        """## What follows

- For grains up to 2:1, and longer ones that meet with their tips, the laws are as good as their assumption of half-spaces: the error of the largest force is the one of [elastic contact](elastic-contact.md) at rest, and grows as the root of the overlap.
- Long grains that meet side by side lose energy to bending. No contact law of two rigid bodies has it. A lower restitution for such grains, in place of a larger viscosity in the material, is the way to take it into account where it matters: it grows with the speed.
- A spring and dashpot fitted at one speed is right at that speed and in that pose.""",
        """## What is left out

Large strain and plasticity, which real grains have at the higher speeds. Viscosities that are not in proportion (the reduced bodies need it). Bodies that leave their plane of
symmetry. Other laws of the engines for ellipsoids were not run here; LAMMPS' `granular` knows spheres alone.""",
    ]
    write(HERE, "Collisions of two ellipsoids against finite elements with inertia", conclusion, parts, ["collisions.csv", "laws.csv", "forces.csv", "checks.csv", "whole_mesh.csv", "pressed.csv", "vibrations.csv"])


if __name__ == "__main__":
    main()
