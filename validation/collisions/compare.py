# SPDX-License-Identifier: MIT OR Apache-2.0
"""Collisions of two ellipsoids by the laws, held against finite elements with inertia.

Unit modulus, unit density, unit smallest semi-axis: a speed of 1 is that of sound in a thin rod. `--go-on` keeps what collisions.csv has.
"""
from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np

import ellgran
from free_body import WIDTH, Grid, free_body
from stored import read_csv, write_csv, write_origin
from two_bodies import Impact, Pair
from whole_mesh import against_a_plane

HERE = Path(__file__).resolve().parent
POISSON = 0.3
FRICTION = 0.3
#: Shear and bulk viscosity over their moduli.
RELAXATION = 0.5
SPEEDS = (0.001, 0.003, 0.01)
#: LSD is fitted at this speed.
FITTED_AT = 0.003
#: Impacts of which the laws' forces over time are kept; those of the finite elements are of all.
SHOWN = ("normal, viscous", "45 degrees")
GRIDS = {"coarse": Grid(6, 2, 3.0), "medium": Grid(8, 3, 2.4), "fine": Grid(10, 3, 2.1)}
#: What the laws are held against; the coarse grid has all collisions too, the fine one these poses at the highest speed.
REFERENCE = "medium"
FINE = ("side by side",)
VIBRATIONS = 80
#: In the duration of the impact by Hertz.
STEPS = 600

_HALF = float(np.sqrt(0.5))
_ALONG_X = (1.0, 0.0, 0.0, 0.0)
_ALONG_Y = (_HALF, 0.0, 0.0, _HALF)
_ALONG_Z = (_HALF, 0.0, -_HALF, 0.0)
_TILTED = (float(np.cos(np.pi / 8)), 0.0, -float(np.sin(np.pi / 8)), 0.0)


def matrices(bodies: ellgran.Bodies) -> np.ndarray:
    """S = R diag(a^2) R^T."""
    roots = bodies.shape_tensors
    return roots @ roots


def moments(bodies: ellgran.Bodies) -> np.ndarray:
    """Of inertia about y."""
    shapes = matrices(bodies)
    return bodies.masses / 5 * (shapes[:, 0, 0] + shapes[:, 2, 2])


class Pose(NamedTuple):
    """Equal prolate grains; quaternions w x y z of the lower and the upper one, which touch with the normal along z."""

    name: str
    aspect: float
    lower: Tuple[float, float, float, float]
    upper: Tuple[float, float, float, float]

    def bodies(self, overlap: float = 0.0, **more: Any) -> ellgran.Bodies:
        turned = ellgran.Bodies(np.zeros((2, 3)), (self.aspect, 1.0, 1.0), [self.lower, self.upper], density=1.0)
        shapes = matrices(turned)
        arms = [shape[:, 2] / np.sqrt(shape[2, 2]) for shape in shapes]
        return ellgran.Bodies(
            [-arms[0], arms[1] - [0, 0, overlap]], turned.semi_axes, turned.quaternions, density=1.0, **more
        )


POSES = (
    Pose("crossed", 1.5, _ALONG_X, _ALONG_Y),
    Pose("oblique", 2.0, _TILTED, _TILTED),
    Pose("tip to tip", 3.0, _ALONG_Z, _ALONG_Z),
    Pose("side by side", 3.0, _ALONG_X, _ALONG_X),
)


def impacts(speed: float) -> Dict[str, Impact]:
    return {
        "normal": Impact(speed),
        "normal, viscous": Impact(speed, relaxation=RELAXATION),
        "45 degrees": Impact(speed, speed, FRICTION),
        "45 degrees, viscous": Impact(speed, speed, FRICTION, RELAXATION),
        "45 degrees, other side": Impact(speed, -speed, FRICTION),
        "63 degrees": Impact(speed, 2 * speed, FRICTION),
    }


def wanted(pose: Pose, speed: float) -> Dict[str, Impact]:
    """A pose without a tilt is the same from both sides. What slides by most of its radius of curvature is left out."""
    found = impacts(speed)
    if pose.name != "oblique":
        del found["45 degrees, other side"]
    curvature = np.mean([1.0 / (s[0, 0] / np.sqrt(s[2, 2]) - s[0, 2] ** 2 / s[2, 2] ** 1.5) for s in matrices(pose.bodies())])
    if found["63 degrees"].along * scale(pose, speed).duration * curvature > 0.7:
        del found["63 degrees"]
    return found


class Scale(NamedTuple):
    """Of the elastic impact by Hertz, with the mass that the contact feels."""

    mass: float
    depth: float
    duration: float
    half_widths: Tuple[float, float]


def scale(pose: Pose, speed: float) -> Scale:
    bodies = pose.bodies()
    inverse = 0.0
    for place, mass, moment in zip(bodies.positions, bodies.masses, moments(bodies)):
        inverse += 1.0 / mass + place[0] ** 2 / moment
    law = f"hertz 1.0 {POISSON} conservative no"
    small = 1e-6
    found = ellgran.contacts(law, pose.bodies(small), [[0, 1]])
    coefficient = float(found.normal_force[0]) / small**1.5
    depth = (5 * speed**2 / (4 * coefficient * inverse)) ** 0.4
    major, minor = (float(axis) * np.sqrt(depth / small) for axis in found.contact_semi_axes[0])
    widths = (major, minor) if abs(found.major_direction[0, 0]) > 0.5 else (minor, major)
    return Scale(1.0 / inverse, depth, 2.9432751843247047 * depth / speed, widths)


def finite_elements(pose: Pose, speed: float, grid: Grid, vibrations: int = VIBRATIONS) -> Pair:
    of = scale(pose, speed)
    lower_shape, upper_shape = matrices(pose.bodies())
    widths = (WIDTH * of.half_widths[0], WIDTH * of.half_widths[1])
    lower = free_body(lower_shape, POISSON, widths, grid, vibrations)
    upper = lower if pose.lower == pose.upper else free_body(upper_shape, POISSON, widths, grid, vibrations)
    return Pair(lower, upper, (lower_shape, upper_shape))


def measures(
    pose: Pose, impact: Impact, path: np.ndarray, duration: float, velocity: Sequence[float], spins: Sequence[float]
) -> Dict[str, float]:
    """What an impact is compared by. Velocities are of the upper body relative to the lower one, over the speed of approach."""
    bodies = pose.bodies()
    # Where they touched: at the origin.
    parting = velocity[1] + spins[1] * bodies.positions[1, 0] - spins[0] * bodies.positions[0, 0]
    reduced = 0.5 * bodies.masses[0]
    before = 0.5 * reduced * (impact.normal**2 + impact.along**2)
    after = 0.5 * reduced * (velocity[0] ** 2 + velocity[1] ** 2) + 0.5 * float(moments(bodies) @ np.square(spins))
    return {
        "peak_force": float(path[:, 3].max()),
        "duration": duration / scale(pose, impact.normal).duration,
        "restitution": parting / impact.normal,
        "velocity_x": velocity[0] / impact.normal,
        "velocity_z": velocity[1] / impact.normal,
        "spin_lower": spins[0] / impact.normal,
        "spin_upper": spins[1] / impact.normal,
        "kept": after / before,
    }


def sampled(path: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Forces along x and z on the upper body."""
    return np.stack([np.interp(times, path[:, 0], path[:, k], right=0.0) for k in (1, 2)], axis=1)


def relative_difference(force: np.ndarray, full: np.ndarray) -> float:
    """Root mean square of the difference of the force vectors over that of the force."""
    return float(np.sqrt(np.mean(np.sum((force - full) ** 2, axis=1)) / np.mean(np.sum(full**2, axis=1))))


def times_of(pose: Pose, speed: float, count: int = 61) -> np.ndarray:
    return np.linspace(0.0, 1.25 * scale(pose, speed).duration, count)[1:]


def collided(
    pose: Pose, speed: float, grid: str, vibrations: int = VIBRATIONS, finer: int = 1, only: Sequence[str] = ()
) -> Tuple[List[Dict[str, Any]], List[Dict[str, Any]]]:
    """All impacts of a pose at a speed by finite elements, or `only` some: what came out, and forces over time."""
    rows, forces = [], []
    pair = finite_elements(pose, speed, GRIDS[grid], vibrations)
    for name, impact in wanted(pose, speed).items():
        if only and name not in only:
            continue
        outcome = pair.collide(impact, scale(pose, speed).duration, finer * STEPS)
        common = {"pose": pose.name, "speed": speed, "impact": name}
        energies = {key: value / outcome.energies["before"] for key, value in outcome.energies.items() if key != "before"}
        found = measures(pose, impact, outcome.path, outcome.duration, outcome.velocity, outcome.spins)
        del energies["after"]
        rows.append(
            {**common, "grid": grid, **found, **energies, "rotation": outcome.rotation, "unknowns": pair.unknowns, "nodes": int(outcome.path[:, 4].max())}
        )
        for moment, (along, up) in zip(times_of(pose, speed), sampled(outcome.path, times_of(pose, speed))):
            forces.append({**common, "time": float(moment), "law": "finite elements", "force_x": float(along), "force_z": float(up)})
    return rows, forces


def viscosities(impact: Impact) -> Tuple[float, float]:
    """Shear and bulk, in proportion to the moduli."""
    return impact.relaxation / (1 + POISSON), impact.relaxation / (3 * (1 - 2 * POISSON))


def words(impact: Impact) -> str:
    """The law of a material with viscosities in proportion to its moduli."""
    shear, bulk = viscosities(impact)
    law = f"nfd 1.0 {POISSON} {shear!r} {bulk!r}" if impact.relaxation else f"hertz 1.0 {POISSON}"
    return f"{law} tangential tfd {impact.friction}" if impact.friction else law


def spring_and_dashpot(pose: Pose, fitted: Dict[str, Any], impact: Impact) -> str:
    """LSD with the duration and the restitution of an impact; tangential constants as LAMMPS' gran/hooke has them by default."""
    of = scale(pose, fitted["speed"])
    duration, loss = fitted["duration"] * of.duration, -np.log(fitted["restitution"])
    stiffness, damping = float(of.mass * (np.pi**2 + loss**2) / duration**2), float(2 * of.mass * loss / duration)
    law = f"lsd {stiffness!r} {damping!r}"
    if impact.friction:
        law += f" tangential linear {2 / 7 * stiffness!r} {0.5 * damping!r} {impact.friction}"
    return law + " limit_force no"


def by_law(pose: Pose, impact: Impact, law: str, spheres: bool = False) -> Tuple[Dict[str, float], np.ndarray]:
    """What came out, and the path as in `Outcome`. `spheres`: of the same volume."""
    half = 0.5 * np.array([impact.along, 0.0, -impact.normal])
    bodies = pose.bodies(velocities=[-half, half])
    if spheres:
        radius = float(np.cbrt(pose.aspect))
        bodies = ellgran.Bodies([[0, 0, -radius], [0, 0, radius]], radius, density=1.0, velocities=[-half, half])
    collision = ellgran.collide(law, bodies)
    after = collision.after
    velocity = after.velocities[1] - after.velocities[0]
    path = np.column_stack([collision.time, collision.force[:, 0], collision.force[:, 2], collision.normal_force])
    spins = after.angular_velocities[:, 1]
    found = measures(pose, impact, path, float(collision.time[-1]), velocity[[0, 2]], spins)
    if spheres:
        found.update(of_spheres(pose, impact, velocity[[0, 2]], spins))
    return found, path


def of_spheres(pose: Pose, impact: Impact, velocity: np.ndarray, spins: np.ndarray) -> Dict[str, float]:
    """What `measures` gives otherwise of spheres of the same volume."""
    mass = float(pose.bodies().masses[0])
    moment = 0.4 * mass * float(np.cbrt(pose.aspect)) ** 2
    before = 0.25 * mass * (impact.normal**2 + impact.along**2)
    after = 0.25 * mass * float(velocity @ velocity) + 0.5 * moment * float(spins @ spins)
    return {"restitution": velocity[1] / impact.normal, "kept": after / before}


def laws(rows: List[Dict[str, Any]], forces: List[Dict[str, Any]]) -> Tuple[List[Dict[str, Any]], List[Dict[str, Any]]]:
    """The laws' own impacts, and their forces over time, for all that finite elements have."""
    full_rows = [row for row in rows if row["grid"] == REFERENCE]
    reference: Dict[Tuple[str, float, str], List[List[float]]] = {}
    for row in forces:
        reference.setdefault((row["pose"], row["speed"], row["impact"]), []).append([row["force_x"], row["force_z"]])
    found, curves = [], []
    for pose in POSES:
        fitted = [row for row in full_rows if (row["pose"], row["speed"], row["impact"]) == (pose.name, FITTED_AT, "normal, viscous")]
        for speed in SPEEDS:
            for name, impact in wanted(pose, speed).items():
                if not any((row["pose"], row["speed"], row["impact"]) == (pose.name, speed, name) for row in full_rows):
                    continue
                chosen = {"NFD+TFD": (words(impact), False)}
                if impact.relaxation:
                    chosen["LSD"] = (spring_and_dashpot(pose, fitted[0], impact), False)
                    chosen["spheres"] = (words(impact), True)
                for label, (law, spheres) in chosen.items():
                    out, path = by_law(pose, impact, law, spheres)
                    times = times_of(pose, speed)
                    force = sampled(path, times)
                    full = np.array(reference[pose.name, speed, name])
                    common = {"pose": pose.name, "speed": speed, "impact": name}
                    difference = relative_difference(force, full)
                    found.append({**common, "law": label, **out, "force_difference": difference})
                    for moment, (along, up) in zip(times, force) if name in SHOWN and not spheres else ():
                        curves.append({**common, "time": float(moment), "law": label, "force_x": float(along), "force_z": float(up)})
    return found, curves


def checks() -> List[Dict[str, Any]]:
    """What else the result must not depend on."""
    rows = []
    pose = next(pose for pose in POSES if pose.name == "side by side")
    for changed, more in {"vibrations": {"vibrations": 2 * VIBRATIONS}, "steps": {"finer": 2}}.items():
        for row in collided(pose, SPEEDS[-1], "coarse", **more)[0]:
            rows.append({"twice as many": changed, **row})
    return rows


def whole_mesh(rows: List[Dict[str, Any]]) -> List[Dict[str, Any]]:
    """Normal impacts on the coarse grid with the inertia of every node, beside the reduced bodies."""
    found = []
    for pose in POSES:
        # Mirror images of one another, whose normal passes through the centres.
        if pose.lower != pose.upper or abs(pose.bodies().positions[0, 0]) > 1e-12:
            continue
        for speed in SPEEDS:
            of = scale(pose, speed)
            widths = (WIDTH * of.half_widths[0], WIDTH * of.half_widths[1])
            restitution, force = against_a_plane(
                matrices(pose.bodies())[0], POISSON, widths, GRIDS["coarse"], 0.5 * speed, of.duration, 400
            )
            reduced = next(
                row for row in rows if (row["pose"], row["speed"], row["impact"], row["grid"]) == (pose.name, speed, "normal", "coarse")
            )
            found.append(
                {"pose": pose.name, "speed": speed, "restitution": restitution, "restitution_reduced": reduced["restitution"], "peak_force": force, "peak_force_reduced": reduced["peak_force"]}
            )
    return found


def pressed() -> List[Dict[str, Any]]:
    """Hertz' force less that of the bodies at rest, tip to tip, beside what the axisymmetric elements of elastic_contact/ found."""
    found = []
    for stored in read_csv(HERE.parent / "elastic_contact" / "finite_bodies.csv"):
        aspect, overlap = stored["aspect"], stored["overlap"]
        if aspect not in (1, 2) or overlap < 1e-4:
            continue
        shape = np.diag([1.0, 1.0, aspect**2])
        # The overlap is in units of the tip's radius of curvature, which is 1/aspect.
        depth = overlap / aspect
        width = WIDTH * float(np.sqrt(0.5 * depth / aspect))
        bodies = ellgran.Bodies([[0, 0, 0], [0, 0, 2 * aspect - depth]], [1.0, 1.0, aspect])
        law = float(ellgran.contacts(f"hertz 1.0 {POISSON} conservative no", bodies, [[0, 1]]).normal_force[0])
        body = free_body(shape, POISSON, (width, width), GRIDS[REFERENCE], 20)
        force = Pair(body, body, (shape, shape)).pressed(depth)
        found.append({"aspect": aspect, "overlap": overlap, "error": law / force - 1, "axisymmetric": stored["free"], "axisymmetric_bar": stored["free_bar"]})
    return found


def lowest_vibrations() -> List[Dict[str, Any]]:
    """Of the lower body, those of lowest frequency that a normal force at its contact moves, beside the duration of the contact by Hertz."""
    found = []
    for pose in POSES:
        of = scale(pose, FITTED_AT)
        widths = (WIDTH * of.half_widths[0], WIDTH * of.half_widths[1])
        body = free_body(matrices(pose.bodies())[0], POISSON, widths, GRIDS["coarse"], 12)
        count = len(body.places)
        moved = np.abs(body.shapes[2 * count + int(np.argmin((body.places**2).sum(axis=1)))])
        period = 2 * np.pi / float(body.frequencies[np.flatnonzero(moved > 0.1 * moved.max())[0]])
        for speed in SPEEDS:
            found.append({"pose": pose.name, "speed": speed, "period": period, "duration": scale(pose, speed).duration})
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--go-on", action="store_true", help="keep the collisions that collisions.csv has")
    options = parser.parse_args()
    started = time.monotonic()
    rows: List[Dict[str, Any]] = []
    forces: List[Dict[str, Any]] = []
    earlier = 0.0
    # Of the earlier parts, where this run goes on.
    kept: Dict[str, str] = {}
    if options.go_on and (HERE / "collisions.csv").exists():
        rows = read_csv(HERE / "collisions.csv")
        forces = [row for row in read_csv(HERE / "forces.csv") if row["law"] == "finite elements"] if (HERE / "forces.csv").exists() else []
        origin = json.loads((HERE / "origin.json").read_text()) if (HERE / "origin.json").exists() else {}
        earlier = origin.get("seconds", 0.0)
        kept = {name: origin[name] for name in ("LAMMPS", "LIGGGHTS", "note") if name in origin}
    made = []

    def note_origin() -> None:
        write_origin(HERE, started, seconds=round(earlier + time.monotonic() - started), **kept)

    def collide_on(grid: str) -> None:
        for pose in POSES:
            for speed in SPEEDS:
                if grid == "fine" and (pose.name not in FINE or speed != SPEEDS[-1]):
                    continue
                if any((row["pose"], row["speed"], row["grid"]) == (pose.name, speed, grid) for row in rows):
                    continue
                began = time.monotonic()
                more, curves = collided(pose, speed, grid)
                rows.extend(more)
                write_csv(HERE / "collisions.csv", rows)
                if grid == REFERENCE:
                    forces.extend(curves)
                    write_csv(HERE / "forces.csv", forces)
                made.append(grid)
                note_origin()
                print(f"{grid} grid, {pose.name} at {speed:g}: {time.monotonic() - began:.0f} s", flush=True)

    collide_on("coarse")
    collide_on(REFERENCE)
    for name, make in {"checks": checks, "whole_mesh": lambda: whole_mesh(rows), "pressed": pressed, "vibrations": lowest_vibrations}.items():
        if not (options.go_on and (HERE / f"{name}.csv").exists()):
            write_csv(HERE / f"{name}.csv", make())
            note_origin()
            print(f"{name}.csv", flush=True)
    if REFERENCE in made or not (options.go_on and (HERE / "laws.csv").exists()):
        found, curves = laws(rows, forces)
        write_csv(HERE / "laws.csv", found)
        write_csv(HERE / "forces.csv", forces + curves)
        print("laws.csv", flush=True)
    collide_on("fine")
    if REFERENCE in made or not (options.go_on and (HERE / "engines.csv").exists()):
        # It needs this module.
        import engines

        began = time.monotonic()
        versions = engines.make(rows, forces)
        kept.update(versions)
        more = ""
        if versions and not made:
            more = f"engines.csv and engine_steps.csv were made later, of the stored collisions, in {time.monotonic() - began:.0f} s of these"
        elif not versions and (HERE / "engines.csv").exists():
            more = "engines.csv and engine_steps.csv are of an earlier run, as the engines were not there"
        if more:
            kept["note"] = "; ".join([*filter(None, [kept.get("note")]), more])
    note_origin()


if __name__ == "__main__":
    main()
