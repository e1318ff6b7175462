# SPDX-License-Identifier: MIT OR Apache-2.0
"""docs/report/collisions.md and its picture, from the stored results."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Sequence

from compare import FRICTION, GRIDS, RELAXATION, STEPS, VIBRATIONS
from engines import CONTROLS, IN_OUR_WORDS
from engines import STEPS as STEPS_OF_ENGINES
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
        self.engines = read_csv(HERE / "engines.csv")
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

    def through(self, law: str, row: Row) -> Row:
        return chosen(self.engines, law=law, pose=row["pose"], speed=row["speed"], impact=row["impact"])[0]

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


#: Laws of engines.csv, as the tables call them. The first is ours, as LAMMPS runs it.
OURS = CONTROLS[0]
SUPERELLIPSOID = "LAMMPS superellipsoid, mean curvature"
GAUSSIAN = "LAMMPS superellipsoid, Gaussian curvature"
BOXES = "LAMMPS superellipsoid, mean curvature, bounding boxes"
SUPERQUADRIC = "LIGGGHTS superquadric"
SUPERQUADRIC_MEAN = "LIGGGHTS superquadric, mean curvature"
SUPERQUADRIC_GAUSSIAN = "LIGGGHTS superquadric, Gaussian curvature"
SPHERES = "LAMMPS granular, spheres"
SHOWN = {
    OURS: "NFD+TFD",
    SUPERELLIPSOID: "LAMMPS mean",
    GAUSSIAN: "LAMMPS Gaussian",
    SUPERQUADRIC: "LIGGGHTS same volume",
    SUPERQUADRIC_MEAN: "LIGGGHTS mean",
    SUPERQUADRIC_GAUSSIAN: "LIGGGHTS Gaussian",
    SPHERES: "LAMMPS spheres",
}


def force_error(results: Results, law: str, row: Row) -> float:
    return results.through(law, row)["peak_force"] / row["peak_force"] - 1


def engines_elastic_table(results: Results) -> str:
    laws = (OURS, SUPERELLIPSOID, GAUSSIAN, SUPERQUADRIC, SPHERES)
    labels = ["NFD", "mean", "Gaussian", "same volume", "spheres"]
    head = ["pose", "v/c", *(f"{'largest force: ' if k == 0 else ''}{label}" for k, label in enumerate(labels)), "duration: elements", *labels]
    rows = []
    for row in pick(results, "normal"):
        errors = [f"{signed(force_error(results, law, row))} %" for law in laws]
        durations = [number(results.through(law, row)["duration"]) for law in laws]
        rows.append([row["pose"], f"{row['speed']:g}", *errors, results.with_bar(row, "duration"), *durations])
    return table(head, rows)


def engines_viscous_table(results: Results) -> str:
    laws = (OURS, SUPERELLIPSOID, GAUSSIAN, SUPERQUADRIC_MEAN, SUPERQUADRIC, SPHERES)
    labels = ["NFD", *(SHOWN[law] for law in laws[1:])]
    head = ["pose", "v/c", "restitution: elements", *labels, *(f"{'largest force: ' if k == 0 else ''}{label}" for k, label in enumerate(labels))]
    rows = []
    for row in pick(results, "normal, viscous"):
        ends = [number(results.through(law, row)["restitution"]) for law in laws]
        errors = [f"{signed(force_error(results, law, row))} %" for law in laws]
        rows.append([row["pose"], f"{row['speed']:g}", results.with_bar(row, "restitution"), *ends, *errors])
    return table(head, rows)


def engines_oblique_table(results: Results) -> str:
    laws = (OURS, SUPERELLIPSOID, SUPERQUADRIC, SPHERES)
    labels = [SHOWN[law] for law in laws]
    head = ["pose", "v/c", "along: elements", *labels, "apart: elements", *labels, "spin: elements", *labels]
    rows = []
    for row in pick(results, "45 degrees, viscous"):
        cells = [row["pose"], f"{row['speed']:g}"]
        for name in ("velocity_x", "velocity_z", "spin_lower"):
            cells += [results.with_bar(row, name), *(number(results.through(law, row)[name]) for law in laws)]
        rows.append(cells)
    return table(head, rows)


def engines_largest(results: Results, law: str, poses: Sequence[str]) -> Dict[str, float]:
    """Largest errors over speeds and impacts: of force, duration and restitution in normal impacts, of the rest in oblique ones."""
    rows = [(row, results.through(law, row)) for row in results.full if row["pose"] in poses]
    normal = [(row, found) for row, found in rows if "degrees" not in row["impact"]]
    oblique = [(row, found) for row, found in rows if "degrees" in row["impact"]]
    errors = {"peak_force": max(abs(found["peak_force"] / row["peak_force"] - 1) for row, found in normal)}
    for name in ("duration", "restitution"):
        errors[name] = max(abs(found[name] - row[name]) for row, found in normal)
    for name in ("velocity_x", "velocity_z"):
        errors[name] = max(abs(found[name] - row[name]) for row, found in oblique)
    errors["spin"] = max(abs(found[name] - row[name]) for row, found in oblique for name in ("spin_lower", "spin_upper"))
    errors["force_difference"] = (sum(found["force_difference"] ** 2 for _, found in rows) / len(rows)) ** 0.5
    return errors


def engines_largest_table(results: Results) -> str:
    head = ["pose", "law", "largest force, %", "duration", "restitution", "along", "apart", "spin", "force differs by, %"]
    rows = []
    for pose in results.poses:
        for law, label in SHOWN.items():
            errors = engines_largest(results, law, [pose])
            cells = [number(errors[name]) for name in ("duration", "restitution", "velocity_x", "velocity_z", "spin")]
            rows.append([pose, label, f"{100 * errors['peak_force']:.1f}", *cells, f"{100 * errors['force_difference']:.1f}"])
    return table(head, rows)


def apart(rows: Sequence[Row], others: Sequence[Row], names: Sequence[str]) -> float:
    """Largest difference of the same collisions."""
    of = {(row["pose"], row["speed"], row["impact"]): row for row in others}
    pairs = [(row, of[row["pose"], row["speed"], row["impact"]]) for row in rows if (row["pose"], row["speed"], row["impact"]) in of]
    return max(abs(row[name] - other[name]) for row, other in pairs for name in names)


def engines_part(results: Results) -> str:
    def law(name: str, **wanted: Any) -> List[Row]:
        return chosen(results.engines, law=name, **wanted)

    middle = results.speeds[1]
    ours = chosen(results.laws, law="NFD+TFD")
    motion = (*SPEED_AND_SPIN, "kept")
    in_lammps, in_liggghts = (apart(law(control), ours, motion) for control in CONTROLS)
    not_viscous = [row for row in results.engines if "viscous" not in row["impact"]]
    twins = max(
        apart(chosen(not_viscous, law=one), chosen(not_viscous, law=other), SPEED_AND_SPIN)
        for one, other in ((SUPERELLIPSOID, SUPERQUADRIC_MEAN), (GAUSSIAN, SUPERQUADRIC_GAUSSIAN))
    )
    steps = {row["law"]: max(row[name] for name in SPEED_AND_SPIN) for row in read_csv(HERE / "engine_steps.csv")}
    finest = max(value for name, value in steps.items() if name != BOXES)
    lost = [row for row in law(BOXES) if row["lost"] > 0]
    whole = [results.through(SUPERELLIPSOID, row) for row in lost]
    worst = max(zip(lost, whole), key=lambda pair: abs(pair[0]["velocity_x"] - pair[1]["velocity_x"]))
    energy = {name: 1 - min(row["kept"] for row in law(name, pose="oblique", impact="normal")) for name in (SUPERELLIPSOID, GAUSSIAN, SUPERQUADRIC)}
    of_ours = max(abs(row["kept"] - 1) for row in law(OURS, impact="normal"))
    fitted = {row["pose"]: row["given_restitution"] for row in law(SUPERQUADRIC, impact="normal, viscous")}
    oblique_end = chosen(results.full, pose="oblique", speed=middle, impact="normal, viscous")[0]["restitution"]
    spheres, by_ours, in_our_words = law(SPHERES), chosen(results.laws, law="spheres"), law(IN_OUR_WORDS)
    head_on = [row for row in spheres if "degrees" not in row["impact"]]
    sliding = [row for row in law(SUPERELLIPSOID, impact="63 degrees") if row["pose"] in ("crossed", "oblique")]
    slides_alike = apart(sliding, ours, ["velocity_x", "velocity_z"])

    def off_hertz(pose: str) -> List[float]:
        """The largest force by the mean curvature against that of NFD."""
        rows = [row for row in results.full if row["pose"] == pose and row["impact"] == "normal"]
        return [results.through(SUPERELLIPSOID, row)["peak_force"] / results.through(OURS, row)["peak_force"] - 1 for row in rows]

    def sticking(name: str, pose: str) -> str:
        rows = [row for row in results.full if row["pose"] == pose and row["impact"] in ("45 degrees", "45 degrees, viscous")]
        return span([results.through(name, row)["velocity_x"] - row["velocity_x"] for row in rows], "+.3f", 1)

    return f"""## The engines' own laws

All {len(results.full)} collisions through LAMMPS and LIGGGHTS, two grains in a box, {STEPS_OF_ENGINES} steps in the duration by Hertz (`pair.lmp`, `pair.lig`, `engines.py`):

| called here | what is run |
|---|---|
| NFD+TFD | `pair_style gran/ellipsoid` in LAMMPS; in LIGGGHTS `surface ellipsoid` |
| LAMMPS mean, Gaussian | `pair_style granular/superellipsoid no_bounding_box`, with `curvature_gaussian` for the second: `hertz` with 4/3 E\*, `tangential classic` with 8 G\*, `damping viscoelastic limit_damping`. Damping as of the viscous material, nothing is fitted |
| LIGGGHTS same volume, mean, Gaussian | `model hertz tangential history surface superquadric`, blockiness 2; `meanCurvature yes` or `gaussianCurvature yes` with `curvatureLimitFactor 1000` for the last two. Its damping is a coefficient of restitution: 1 for elastic grains; for viscous ones fitted in each pose, so that the normal impact at v/c = {middle:g} ends as by finite elements |
| LAMMPS spheres | `pair_style granular`: `hertz/material`, `tangential mindlin NULL`, `damping viscoelastic limit_damping`, spheres of the same volume |

*Control*: ours in LAMMPS ends as the stored results of `ellgran.collide` do to {in_lammps:.0e} in velocities, spins and energy, ours in LIGGGHTS to {in_liggghts:.0e}. With the same radius LAMMPS' superellipsoids and LIGGGHTS' superquadrics agree to {twins:.0e} where grains are elastic, so that one of them stands for both in some tables.
Four times as many steps change velocities and spins by at most {finest:.0e} at v/c = {middle:g}. Durations here are from first touch to the last force, as of the finite elements; those of NFD in the tables above are until the overlap has gone, which is later where grains are viscous.
With friction the bodies turn and the normal with them, so that largest forces are of normal impacts alone.

Normal, elastic. *Spheres* have the radius of *same volume*; in the oblique pose they lack the arm of the force.

{engines_elastic_table(results)}
Normal, viscous:

{engines_viscous_table(results)}
45 degrees, viscous:

{engines_oblique_table(results)}
The largest errors over speeds and impacts, against finite elements; of force, duration and restitution in normal impacts, of *along*, *apart* and *spin* in oblique ones. *Force differs by* is the root mean square over all.

{engines_largest_table(results)}
What is to be seen:

- **One radius in place of the contact ellipse.** Where the contact is a circle (crossed, tip to tip) the mean curvature is NFD, and in the oblique pose its largest force differs from that of NFD by up to {100 * max(abs(row) for row in off_hertz('oblique')):.1f} %. Side by side, where the ellipse is long, it is {-100 * max(off_hertz('side by side')):.0f} % below Hertz; the grains are softer than half-spaces too, so that the two errors cancel in the largest force. The force over time is then further off than by NFD.
  So in these collisions the ellipse is no better than one radius for the largest force, and better for the force over time where it is long. Longer ellipses are in [error against run time](README.md). The radius of the same volume, which LIGGGHTS takes unless told otherwise, errs by {span([force_error(results, SUPERQUADRIC, r) for r in results.full if r['pose'] == 'tip to tip' and 'degrees' not in r['impact']], '+.0f')} % tip to tip.
- **Friction.** All of them have Mindlin's spring up to Coulomb's limit, without partial slip. Where contacts stick, at 45 degrees, the velocity along x of LAMMPS mean is off by {sticking(SUPERELLIPSOID, 'tip to tip')} tip to tip (TFD {sticking(OURS, 'tip to tip')}), {sticking(SUPERELLIPSOID, 'crossed')} crossed (TFD {sticking(OURS, 'crossed')}) and {sticking(SUPERELLIPSOID, 'oblique')} in the oblique pose (TFD {sticking(OURS, 'oblique')}).
  At 63 degrees, where crossed and oblique contacts slide, TFD and LAMMPS mean are {slides_alike:.3f} apart there at most.
- **Viscosity.** LAMMPS' damping with the constant of the material gives the restitution that NFD gives, to {100 * max(apart(law(SUPERELLIPSOID, impact='normal, viscous', pose=pose), ours, ['restitution']) for pose in ('crossed', 'oblique', 'tip to tip')):.1f} % of the speed of approach (side by side left out). A coefficient of restitution, as LIGGGHTS has it, is right at the speed of the fit alone, as LSD is; unlike by LSD, force and duration follow the speed. Off the centres it is not the ratio of the speeds at the contact: for {number(oblique_end)} in the oblique pose LIGGGHTS has to be given {number(fitted['oblique'])}.
- **Energy.** An elastic impact without friction in the oblique pose loses up to {100 * energy[SUPERELLIPSOID]:.1f} % by the mean curvature, {100 * energy[GAUSSIAN]:.1f} % by the Gaussian one and {100 * energy[SUPERQUADRIC]:.1f} % by the same volume, at v/c = {results.speeds[-1]:g}; ours keeps it to {of_ours:.0e}.
- **Spheres** by our law in the tables above are not quite those of LAMMPS. In normal impacts the restitution differs by up to {apart(head_on, by_ours, ['restitution']):.4f} where they are viscous, because NFD has a smaller area on the way back (`unloading ting`); with friction by up to {apart(spheres, by_ours, ['velocity_x']):.3f} along x, because TFD slips partially. With `mindlin` and `unloading first_order` ours end as LAMMPS' do, to {apart(head_on, in_our_words, ['restitution']):.0e} in normal impacts and to {apart([r for r in spheres if r['speed'] == results.speeds[0]], in_our_words, ['velocity_x', 'spin_lower']):.3f} with friction at {results.speeds[0]:g}, {apart(spheres, in_our_words, ['velocity_x', 'spin_lower']):.3f} at {results.speeds[-1]:g}: LAMMPS takes the velocity at the contact with whole radii, and the torque with radii less half the overlap.

What to know of `granular/superellipsoid` in LAMMPS 4 Jul 2026, beside that:

- Its test of bounding boxes, on by default, takes grains in contact for separate in up to {100 * max(row['lost'] for row in lost):.0f} % of the steps when an axis of one stays along an axis of the other, as in the crossed pose with friction: the test of the edges compares rounding with rounding. Friction forgets its history each time. {worst[0]['pose'].capitalize()}, {worst[0]['impact']}, at {worst[0]['speed']:g}, the velocity along x is {number(worst[0]['velocity_x'])}, with `no_bounding_box` {number(worst[1]['velocity_x'])}. Seen in {len(lost)} of the {len(results.full)} collisions. In a line: `lmp -in pair.lmp -var style granular/superellipsoid -var law "hertz 0.7326 0 tangential classic 0.905 0 0.3 damping viscoelastic limit_damping" -var axes "3 2 2" -var mass 6.283185307 -var turned2 "0 0 1 90" -var along 0.003 -var approach 0.003 -var step 0.04 -var steps 700`, without and with `-var words no_bounding_box`: the force is the third column.
- `set density` gives a superellipsoid the mass of the sphere around it; a density in a data file gives the right one. `set mass` after `set shape` and `set block` leaves the moments of inertia as they were. So `pair.lmp` sets the mass first.
- Where the search finds contact with a negative overlap, as it can for two grains that touch to rounding, the force is not a number: `lmp -in pair.lmp -var style granular/superellipsoid -var words geometric -var law "hertz 0.7326 0 tangential classic 0.905 0 0 damping viscoelastic limit_damping" -var place "-0.9486832980505137 0 -1.58113883008419" -var place2 "0.9486832980505137 0 1.58113883008419" -var turned "0 -1 0 45" -var turned2 "0 -1 0 45" -var steps 2`. None of the stored collisions met it.

Not run: `geometric`, which for two equal ellipsoids has the solution of the default; `linear_history`, whose spring does not grow with the contact; the engines' laws for aspect ratios beyond 3."""


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
        f"LSD fitted at {middle:g} errs in the largest force by {span([of_force(r, 'LSD') for r in at(viscous, slow)])} % at {slow:g} and {span([of_force(r, 'LSD') for r in at(viscous, fast)])} % at {fast:g}. "
        f"The engines' own laws for ellipsoids, run in LAMMPS and LIGGGHTS: with the mean or the Gaussian curvature in place of the contact ellipse the largest force of elastic normal impacts errs by "
        f"{span([force_error(results, name, r) for name in (SUPERELLIPSOID, GAUSSIAN) for r in normal])} %, beside {span([of_force(r) for r in normal])} % by NFD; with the radius of the same volume, LIGGGHTS' default, by {span([force_error(results, SUPERQUADRIC, r) for r in normal])} %. "
        f"They know no partial slip: along x they err by up to {engines_largest(results, SUPERELLIPSOID, short_ones)['velocity_x']:.3f} where TFD errs by {engines_largest(results, OURS, short_ones)['velocity_x']:.3f}, the long grains side by side left out."
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
volume with the same law; LAMMPS' own are [below](#the-engines-own-laws). The durations of spheres are not shown.

{viscous_table(results)}""",
        f"""## Oblique impacts, elastic and viscous

By NFD and TFD; *along* and *apart* are the velocities along x and z. Two spins where the bodies differ. *Force differs by*: root mean square of the difference of the force vector over time, over that of the force.

{oblique_table(results, ('45 degrees', '45 degrees, viscous', '45 degrees, other side', '63 degrees'))}
The largest error along x, {number(of('velocity_x', worst_along))} of v, is of *{worst_along['pose']}, {worst_along['impact']}* at {worst_along['speed']:g} (error bar {results.bar(worst_along, 'velocity_x'):.3f}). TFD has no hysteresis below sliding ([tangential contact](tangential-contact.md)), so its spring gives back what partial slip loses. In collisions that stick, the force turns its sign before the end. This swing back, over the largest normal force, at 45 degrees and v/c = {middle:g}: {swing_back}.""",
        f"""## LSD and spheres at 45 degrees, viscous

{spring_table(results)}
LSD has 2/7 of its normal stiffness and half of its normal damping along the contact, as LAMMPS' `gran/hooke` has by default. Spheres spin as spheres: neither their moment of inertia nor the arm of the force is that of the grain.""",
        engines_part(results),
        """## What follows

- For grains up to 2:1, and longer ones that meet with their tips, the laws are as good as their assumption of half-spaces: the error of the largest force is the one of [elastic contact](elastic-contact.md) at rest, and grows as the root of the overlap.
- Long grains that meet side by side lose energy to bending. No contact law of two rigid bodies has it. A lower restitution for such grains, in place of a larger viscosity in the material, is the way to take it into account where it matters: it grows with the speed.
- A spring and dashpot fitted at one speed is right at that speed and in that pose.""",
        """## What is left out

Large strain and plasticity, which real grains have at the higher speeds. Viscosities that are not in proportion (the reduced bodies need it). Bodies that leave their plane of
symmetry. Other constants of the engines' laws than those that follow from the material or are fitted to it.""",
    ]
    write(HERE, "Collisions of two ellipsoids against finite elements with inertia", conclusion, parts, ["collisions.csv", "laws.csv", "forces.csv", "checks.csv", "whole_mesh.csv", "pressed.csv", "vibrations.csv", "engines.csv", "engine_steps.csv"])


if __name__ == "__main__":
    main()
