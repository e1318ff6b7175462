# SPDX-License-Identifier: MIT OR Apache-2.0
"""The collisions through LAMMPS and LIGGGHTS: by the engines' own laws for ellipsoids and for spheres of the same volume, and by ours there,
which must end as `ellgran.collide` has it."""
from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np

import compare
from stored import write_csv

HERE = Path(__file__).resolve().parent
#: In the duration of the elastic impact by Hertz, as `ellgran.collide` has them, and of how many durations a run is.
STEPS = 500
DURATIONS = 3
#: Beyond every radius of curvature here, where LIGGGHTS wants to be told up to which one it is to take them.
CURVATURE_LIMIT = 1e3
_COLUMNS = ("step", "force_x", "force_z", "vx1", "vz1", "vx2", "vz2", "spin1", "spin2")


class Law(NamedTuple):
    """A law in an engine. `words` are those of the deck for an impact; restitution is what LIGGGHTS' damping is made of."""

    engine: str
    words: Callable[["compare.Impact", float, float], Dict[str, Any]]
    #: Spheres of the same volume.
    spheres: bool = False
    #: Its damping is a coefficient of restitution, fitted in each pose.
    fitted: bool = False


def _moduli() -> Tuple[float, float]:
    """E* of two equal materials, and G* of Mindlin's 8 G* a."""
    shear = 0.5 / (1 + compare.POISSON)
    return 0.5 / (1 - compare.POISSON**2), 0.5 * shear / (2 - compare.POISSON)


def _granular(normal: str, tangential: str, impact: "compare.Impact", mass: float) -> str:
    """LAMMPS' viscoelastic damping is eta a m_eff v: with eta = 2 E* tau / m_eff that of a material with viscosities in proportion to its
    moduli, and with 8 G* / (2 E*) of it along the contact."""
    modulus, shear = _moduli()
    damping = 2 * modulus * impact.relaxation / (0.5 * mass)
    normal = normal.format(stiffness=repr(4 / 3 * modulus), damping=repr(damping), poisson=repr(compare.POISSON))
    tangential = tangential.format(stiffness=repr(8 * shear))
    return f"{normal} tangential {tangential} {4 * shear / modulus!r} {impact.friction} damping viscoelastic limit_damping"


def _superellipsoid(words: str) -> Law:
    def deck(impact: "compare.Impact", mass: float, restitution: float) -> Dict[str, Any]:
        law = _granular("hertz {stiffness} {damping}", "classic {stiffness}", impact, mass)
        return {"style": "granular/superellipsoid", "words": words, "law": law}

    return Law("LAMMPS", deck)


def _spheres(impact: "compare.Impact", mass: float, restitution: float) -> Dict[str, Any]:
    return {"style": "granular", "law": _granular("hertz/material 1 {damping} {poisson}", "mindlin NULL", impact, mass)}


def _superquadric(words: str) -> Law:
    def deck(impact: "compare.Impact", mass: float, restitution: float) -> Dict[str, Any]:
        return {
            "model": f"hertz tangential history surface superquadric{words}",
            "integrator": "nve/superquadric",
            "restitution": restitution if impact.relaxation else 1.0,
            "friction": impact.friction,
        }

    return Law("LIGGGHTS", deck, fitted=True)


def _ours_in_lammps(impact: "compare.Impact", mass: float, restitution: float) -> Dict[str, Any]:
    return {"style": "gran/ellipsoid", "plugin": os.environ["ELLGRAN_LAMMPS_PLUGIN"], "law": compare.words(impact)}


def _ours_in_liggghts(impact: "compare.Impact", mass: float, restitution: float) -> Dict[str, Any]:
    shear, bulk = compare.viscosities(impact)
    tangential = " tangential tfd" if impact.friction else ""
    return {"model": f"nfd{tangential} surface ellipsoid", "shear": shear, "bulk": bulk, "friction": impact.friction}


#: Computed beside them without an engine: the law of LAMMPS' spheres in our words.
IN_OUR_WORDS = "spheres, mindlin, unloading first_order"
#: By the name that engines.csv has. Controls first.
CONTROLS = ("gran/ellipsoid in LAMMPS", "surface ellipsoid in LIGGGHTS")
LAWS = {
    CONTROLS[0]: Law("LAMMPS", _ours_in_lammps),
    CONTROLS[1]: Law("LIGGGHTS", _ours_in_liggghts),
    "LAMMPS superellipsoid, mean curvature": _superellipsoid("no_bounding_box"),
    "LAMMPS superellipsoid, Gaussian curvature": _superellipsoid("curvature_gaussian no_bounding_box"),
    "LAMMPS superellipsoid, mean curvature, bounding boxes": _superellipsoid(""),
    "LIGGGHTS superquadric": _superquadric(""),
    "LIGGGHTS superquadric, mean curvature": _superquadric(f" meanCurvature yes curvatureLimitFactor {CURVATURE_LIMIT:g}"),
    "LIGGGHTS superquadric, Gaussian curvature": _superquadric(f" gaussianCurvature yes curvatureLimitFactor {CURVATURE_LIMIT:g}"),
    "LAMMPS granular, spheres": Law("LAMMPS", _spheres, spheres=True),
}


def left_out() -> Dict[str, str]:
    """Laws that cannot be run here, and why."""
    without = {}
    styles = ""
    if os.environ.get("ELLGRAN_LAMMPS"):
        styles = subprocess.run([os.environ["ELLGRAN_LAMMPS"], "-help"], capture_output=True, text=True).stdout
    for label, law in LAWS.items():
        variables = ["ELLGRAN_LAMMPS" if law.engine == "LAMMPS" else "ELLGRAN_LIGGGHTS"]
        if label == CONTROLS[0]:
            variables.append("ELLGRAN_LAMMPS_PLUGIN")
        unset = [name for name in variables if not os.environ.get(name)]
        if unset:
            without[label] = f"{', '.join(unset)} not set"
        elif "superellipsoid" in label and "granular/superellipsoid" not in styles.split():
            without[label] = "this LAMMPS has no granular/superellipsoid"
    return without


def _axis_and_angle(quaternion: Sequence[float]) -> str:
    """A unit vector, and degrees."""
    length = float(np.linalg.norm(quaternion[1:]))
    axis = np.array(quaternion[1:]) / length if length else (0, 0, 1)
    return " ".join(repr(float(x)) for x in (*axis, np.degrees(2 * np.arctan2(length, quaternion[0]))))


def run(engine: str, values: Dict[str, Any]) -> Tuple[str, np.ndarray]:
    """What the engine calls itself, and the rows of its deck."""
    words = [str(word) for name, value in values.items() for word in ("-var", name, value)]
    lammps = engine == "LAMMPS"
    program = os.environ["ELLGRAN_LAMMPS" if lammps else "ELLGRAN_LIGGGHTS"]
    deck = HERE / ("pair.lmp" if lammps else "pair.lig")
    command = [program, *(["-nocite"] if lammps else []), "-log", "none", "-in", str(deck), *words]
    done = subprocess.run(command, capture_output=True, text=True)
    lines = done.stdout.splitlines()
    ended = any(line.startswith("Loop time") for line in lines)
    if done.returncode != 0 or not ended or any(line.startswith("WARNING: Ellipsoid contact") for line in lines):
        raise RuntimeError(f"{' '.join(command)}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    first = next(number for number, line in enumerate(lines) if line.split()[:1] == ["Step"])
    last = next(number for number, line in enumerate(lines) if line.startswith("Loop time"))
    rows = np.array([line.split() for line in lines[first + 1 : last] if not line.startswith("WARNING")], dtype=float)
    if rows.shape[1:] != (len(_COLUMNS),):
        raise RuntimeError(f"{' '.join(command)}: other columns than {_COLUMNS}")
    return next(line for line in lines if line.startswith(engine)), rows


def collide(
    label: str, pose: "compare.Pose", impact: "compare.Impact", restitution: float = 1.0, steps: int = STEPS
) -> Tuple[Dict[str, float], np.ndarray, str]:
    """What came out, the path as in `Outcome`, and what the engine calls itself."""
    law = LAWS[label]
    bodies = pose.bodies()
    mass = float(bodies.masses[0])
    duration = compare.scale(pose, impact.normal).duration
    step = duration / steps
    radius = float(np.cbrt(pose.aspect))
    places = np.array([[0, 0, -radius], [0, 0, radius]]) if law.spheres else bodies.positions
    values: Dict[str, Any] = {
        **law.words(impact, mass, restitution),
        "along": repr(float(impact.along)),
        "approach": repr(float(impact.normal)),
        "step": repr(float(step)),
        "steps": DURATIONS * steps,
    }
    for number, place, turned in zip(("", "2"), places, (pose.lower, pose.upper)):
        values[f"place{number}"] = " ".join(repr(float(x)) for x in place)
        if law.engine == "LAMMPS":
            values[f"turned{number}"] = _axis_and_angle(turned)
        else:
            values[f"turned{number}"] = " ".join(repr(float(x)) for x in turned)
    if law.engine == "LAMMPS":
        values["mass"] = repr(mass)
        values["axes"] = repr(2 * radius) if law.spheres else f"{2 * pose.aspect!r} 2 2"
    else:
        values["axes"] = f"{pose.aspect!r} 1 1"
    version, rows = run(law.engine, values)
    force_x, force_z = rows[:, 1], rows[:, 2]
    if force_x[-1] != 0 or force_z[-1] != 0:
        raise RuntimeError(f"{label}, {pose.name}, {impact}: still in contact")
    time = rows[:, 0] * step
    # The normal turns with the bodies. Without friction the force is along it; with friction the normal force is taken as that along z.
    normal = force_z if impact.friction else np.sign(force_z) * np.hypot(force_x, force_z)
    end = rows[-1]
    velocity = np.array([end[5] - end[3], end[6] - end[4]])
    spins = end[7:9] if law.spheres else end[7:9] / compare.moments(bodies)
    path = np.column_stack([time, force_x, force_z, normal])
    touching = np.flatnonzero(np.hypot(force_x, force_z))
    # Between the last step with a force and the one after it.
    found = compare.measures(pose, impact, path, float(time[touching[-1]] + 0.5 * step), velocity, spins)
    found = {name: float(value) for name, value in found.items()}
    # Steps without a force before it.
    found["lost"] = 1.0 - len(touching) / (touching[-1] - touching[0] + 1)
    if law.spheres:
        found.update(compare.of_spheres(pose, impact, velocity, spins))
    return found, path, version


def fitted_restitution(label: str, pose: "compare.Pose", wanted: float) -> float:
    """With which the normal impact at the speed of the fit ends with the restitution of the finite elements."""
    impact = compare.impacts(compare.FITTED_AT)["normal, viscous"]

    def off(given: float) -> float:
        return collide(label, pose, impact, given)[0]["restitution"] - wanted

    older, newer = wanted, wanted - 0.5 * off(wanted)
    before = off(older)
    for _ in range(20):
        now = off(newer)
        if abs(now) < 1e-5 or newer == older:
            return newer
        older, newer, before = newer, newer - now * (newer - older) / (now - before), now
    raise RuntimeError(f"{label}, {pose.name}: no coefficient of restitution gives {wanted}")


class _Elements:
    """The finite elements' collisions, and what is fitted to them."""

    def __init__(self, rows: List[Dict[str, Any]], forces: List[Dict[str, Any]]) -> None:
        self.rows = [row for row in rows if row["grid"] == compare.REFERENCE]
        self.forces: Dict[Tuple[str, float, str], List[List[float]]] = {}
        for row in forces:
            if row["law"] == "finite elements":
                self.forces.setdefault((row["pose"], row["speed"], row["impact"]), []).append([row["force_x"], row["force_z"]])
        self.poses = {pose.name: pose for pose in compare.POSES}
        self._fits: Dict[Tuple[str, str], float] = {}

    def given(self, label: str, pose: str) -> float:
        """The coefficient of restitution for this law in this pose."""
        if not LAWS[label].fitted:
            return 1.0
        if (label, pose) not in self._fits:
            wanted = next(
                row["restitution"] for row in self.rows if (row["pose"], row["speed"], row["impact"]) == (pose, compare.FITTED_AT, "normal, viscous")
            )
            self._fits[label, pose] = fitted_restitution(label, self.poses[pose], wanted)
        return self._fits[label, pose]


def _in_our_words(pose: "compare.Pose", impact: "compare.Impact") -> Tuple[Dict[str, float], np.ndarray]:
    law = compare.words(impact).replace("tangential tfd", "tangential mindlin")
    if impact.relaxation:
        law += " unloading first_order"
    found, path = compare.by_law(pose, impact, law, True)
    return {**{name: float(value) for name, value in found.items()}, "lost": 0.0}, path


def collisions(rows: List[Dict[str, Any]], forces: List[Dict[str, Any]]) -> Tuple[List[Dict[str, Any]], List[Dict[str, Any]], Dict[str, str]]:
    """All collisions that finite elements have, by all laws; what four times as many steps change at the speed of the fit; and what
    the engines call themselves."""
    elements = _Elements(rows, forces)
    found, changes, versions = [], [], {}
    for label in (*LAWS, IN_OUR_WORDS):
        change: Dict[str, float] = {}
        for row in elements.rows:
            pose, impact = elements.poses[row["pose"]], compare.impacts(row["speed"])[row["impact"]]
            damped: Any = ""
            if label == IN_OUR_WORDS:
                out, path = _in_our_words(pose, impact)
            else:
                given = elements.given(label, pose.name)
                damped = given if LAWS[label].fitted and impact.relaxation else ""
                out, path, versions[LAWS[label].engine] = collide(label, pose, impact, given)
                if row["speed"] == compare.FITTED_AT:
                    finer = collide(label, pose, impact, given, 4 * STEPS)[0]
                    for name in ("peak_force", "duration", "restitution", "velocity_x", "velocity_z", "spin_lower", "spin_upper"):
                        relative = finer[name] if name == "peak_force" else 1.0
                        change[name] = max(change.get(name, 0.0), abs(out[name] - finer[name]) / relative)
            force = compare.sampled(path, compare.times_of(pose, row["speed"]))
            difference = compare.relative_difference(force, np.array(elements.forces[row["pose"], row["speed"], row["impact"]]))
            common = {key: row[key] for key in ("pose", "speed", "impact")}
            found.append({**common, "law": label, **out, "force_difference": difference, "given_restitution": damped})
        if change:
            changes.append({"law": label, **change})
        print(f"{label}: {sum(row['law'] == label for row in found)} collisions", flush=True)
    return found, changes, versions


def make(rows: List[Dict[str, Any]], forces: List[Dict[str, Any]]) -> Dict[str, str]:
    """engines.csv and engine_steps.csv, and the engines' versions. Without all of the engines nothing is written, and it says so."""
    without = left_out()
    if without:
        print("\nNOT RUN THROUGH THE ENGINES: engines.csv and engine_steps.csv stay as they are.")
        for label, why in without.items():
            print(f"  {label}: {why}")
        print("`cargo xtask validate collisions -- --go-on` fetches and builds the engines; without engines.csv it runs these alone.\n", flush=True)
        return {}
    found, changes, names = collisions(rows, forces)
    write_csv(HERE / "engines.csv", found)
    write_csv(HERE / "engine_steps.csv", changes)
    print("engines.csv, engine_steps.csv", flush=True)
    # LAMMPS (4 Jul 2026); LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled ...
    return {"LAMMPS": names["LAMMPS"].split("(")[1].split(")")[0], "LIGGGHTS": names["LIGGGHTS"].split("PUBLIC ")[-1].split(",")[0]}
