# SPDX-License-Identifier: MIT OR Apache-2.0
"""The granular tests of LAMMPS (unittest/granular of 4 Jul 2026, dem01 to dem11), with our own deck: the same scenes by `granular` and by
`gran/ellipsoid`, each against its closed form."""
from __future__ import annotations

import os
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

HERE = Path(__file__).resolve().parent
ELLIPSOID, GRANULAR = "gran/ellipsoid", "granular"

Row = Dict[str, Any]


@dataclass
class Grain:
    """Axes are whole ones; `spin` is the angular velocity."""

    place: Tuple[float, float, float]
    velocity: Tuple[float, float, float] = (0, 0, 0)
    spin: Tuple[float, float, float] = (0, 0, 0)
    axes: Tuple[float, float, float] = (1, 1, 1)
    density: float = 1.0

    @property
    def mass(self) -> float:
        return self.density * np.pi / 6 * float(np.prod(self.axes))

    @property
    def inertia(self) -> np.ndarray:
        """Principal moments; the grain is not turned in the beginning."""
        squares = np.square(self.axes)
        return self.mass / 20 * (squares.sum() - squares)


@dataclass
class Scene:
    """`law` has the words of each style."""

    law: Dict[str, str]
    grains: Sequence[Grain]
    step: float
    steps: int
    every: int = 1
    wall: str = ""
    gravity: float = 0.0
    downwards: str = "0 0 -1"
    drag: str = ""
    wide: float = 10.0


@dataclass
class Motion:
    """Arrays of shape (frames, grains, 3), the first frame the beginning."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    angular_momentum: np.ndarray


def words(numbers: Sequence[float]) -> str:
    return " ".join(f"{number:.17g}" for number in numbers)


def run(scene: Scene, style: str) -> Motion:
    values: Dict[str, Any] = {
        "plugin": os.environ["ELLGRAN_LAMMPS_PLUGIN"],
        "style": style,
        "law": scene.law[style],
        "wide": scene.wide,
        "gravity": scene.gravity,
        "downwards": scene.downwards,
        "step": scene.step,
        "steps": scene.steps,
        "every": scene.every,
        "grains": len(scene.grains),
    }
    if scene.wall:
        values.update(planes=1, wall=scene.wall)
    if scene.drag:
        values.update(drags=1, drag=scene.drag)
    for grain, mark in zip(scene.grains, ("", "2")):
        sphere = style == GRANULAR
        values[f"place{mark}"] = words(grain.place)
        values[f"axes{mark}"] = words(grain.axes[:1] if sphere else grain.axes)
        values[f"density{mark}"] = grain.density
        values[f"velocity{mark}"] = words(grain.velocity)
        values[f"spin{mark}"] = words(grain.spin if sphere else grain.inertia * grain.spin)
    with tempfile.TemporaryDirectory() as directory:
        dump = Path(directory) / "grains.dump"
        options = [str(word) for name, value in {**values, "dump": dump}.items() for word in ("-var", name, value)]
        done = subprocess.run(
            [os.environ["ELLGRAN_LAMMPS"], "-nocite", "-log", "none", "-in", str(HERE / "few_grains.lmp"), *options], capture_output=True, text=True
        )
        if done.returncode != 0:
            raise RuntimeError(f"LAMMPS stopped at {scene}, {style}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        lines = dump.read_text().splitlines()
    count = len(scene.grains)
    frames = np.array([line.split() for start in range(9, len(lines), 9 + count) for line in lines[start : start + count]], dtype=float)
    frames = frames.reshape(-1, count, 4, 3)
    if style == GRANULAR:
        frames[:, :, 3] *= np.array([grain.inertia for grain in scene.grains])
    time = scene.step * scene.every * np.arange(len(frames))
    return Motion(time, *(frames[:, :, k] for k in range(4)))


def energy(grain: Grain, velocity: np.ndarray, angular_momentum: np.ndarray) -> float:
    """Kinetic, of a sphere, or of an ellipsoid that turns about one of its axes alone."""
    return float(grain.mass * velocity @ velocity + angular_momentum**2 @ (1 / grain.inertia)) / 2


def dashpot(mass: float, stiffness: float, restitution: float) -> float:
    """Damping of a linear contact whose collisions end with this restitution, in the mass that moves against the other."""
    logarithm = np.log(restitution)
    return float(-2 * logarithm * np.sqrt(mass * stiffness) / np.hypot(np.pi, logarithm))


def linear(mass: float, stiffness: float, restitution: float, tangential: str = "none", granular_tangential: str = "linear_nohistory 0 0", more: str = "") -> Dict[str, str]:
    """A linear spring and dashpot in the words of both styles."""
    return {
        ELLIPSOID: f"lsd {stiffness!r} {dashpot(mass, stiffness, restitution)!r} tangential {tangential} {more} limit_force no",
        GRANULAR: f"hooke {stiffness!r} {restitution!r} tangential {granular_tangential} {more} damping coeff_restitution",
    }


def hertz(modulus: float, poisson: float, restitution: float, friction: float = 0.0) -> Dict[str, str]:
    damping = "" if restitution == 1 else f"damping restitution {restitution!r}"
    return {
        ELLIPSOID: f"hertz {modulus!r} {poisson!r} {damping} tangential {f'mindlin {friction!r}' if friction else 'none'}",
        GRANULAR: f"hertz/material {modulus!r} {restitution!r} {poisson!r} tangential {f'mindlin NULL 0 {friction!r}' if friction else 'linear_nohistory 0 0'} "
        "damping coeff_restitution",
    }


@dataclass
class Table:
    rows: List[Row] = field(default_factory=list)

    def add(self, test: str, scene: str, quantity: str, closed_form: float, found: Dict[str, float], scale: float = 0.0) -> None:
        """One line: `found` by style. Errors are relative to `scale`, or to the closed form where there is none."""
        unit = abs(scale or closed_form)
        error = {style: (found[style] - closed_form) / unit if style in found else "" for style in (GRANULAR, ELLIPSOID)}
        self.rows.append(
            {
                "test": test,
                "scene": scene,
                "quantity": quantity,
                "closed_form": float(closed_form),
                "granular_error": error[GRANULAR],
                "ellipsoid_error": error[ELLIPSOID],
            }
        )
        errors = ", ".join(f"{style} {value:+.1e}" for style, value in error.items() if value != "")
        print(f"{test}, {scene}, {quantity}: {closed_form:.6g}, {errors}", flush=True)


def both(scene: Scene) -> Dict[str, Motion]:
    return {style: run(scene, style) for style in (GRANULAR, ELLIPSOID)}


def free_fall_and_bounce(table: Table) -> None:
    """dem01. Three stages: fall, contact under gravity, flight."""
    stiffness, restitution, gravity, height, radius = 1e4, 0.8, 9.81, 0.5, 0.1
    grain = Grain((0, 0, height), axes=(0.2,) * 3, density=2600)
    motions = both(Scene(linear(grain.mass, stiffness, restitution), [grain], 1e-4, 7000, 500, "zplane 0 NULL", gravity, wide=1))
    touch = np.sqrt(2 * (height - radius) / gravity)
    damping = dashpot(grain.mass, stiffness, restitution)
    rate, load = damping / (2 * grain.mass), grain.mass * gravity / stiffness
    pulse = np.sqrt(stiffness / grain.mass - rate**2)

    def penetration(t: float) -> Tuple[float, float]:
        """And its rate, from first touch on."""
        sine = (gravity * touch - rate * load) / pulse
        decay, s, c = np.exp(-rate * t), np.sin(pulse * t), np.cos(pulse * t)
        x = load + decay * (-load * c + sine * s)
        return x, decay * ((load * rate + sine * pulse) * c + (load * pulse - sine * rate) * s)

    lasts = brentq(lambda t: penetration(t)[0], 0.5 * np.pi / pulse, 1.9 * np.pi / pulse, xtol=1e-15)
    speed, flight = -penetration(lasts)[1], 0.7 - touch - lasts
    wanted = {
        "velocity before, at 0.25 s": -gravity * 0.25,
        "height after, at 0.7 s": radius + speed * flight - gravity * flight**2 / 2,
        "velocity after, at 0.7 s": speed - gravity * flight,
    }
    found = {
        "velocity before, at 0.25 s": {style: motion.velocity[5, 0, 2] for style, motion in motions.items()},
        "height after, at 0.7 s": {style: motion.position[14, 0, 2] for style, motion in motions.items()},
        "velocity after, at 0.7 s": {style: motion.velocity[14, 0, 2] for style, motion in motions.items()},
    }
    for quantity, scale in zip(wanted, (gravity * touch, height - radius, gravity * touch)):
        table.add("dem01", "a sphere falls on a plane, linear", quantity, wanted[quantity], found[quantity], scale)


def bounces(table: Table) -> None:
    """dem02. Rigid spheres rise to e^2 of the height each time; contacts that last do so as their duration vanishes."""
    restitution, gravity, height, radius = 0.9, 9.81, 0.5, 0.1
    grain = Grain((0, 0, height), axes=(0.2,) * 3, density=2600)
    fall = np.sqrt(2 * (height - radius) / gravity)
    third = fall * (1 + 2 * restitution + 2 * restitution**2 + restitution**3)
    for name, law, step in (
        ("linear, 1e6 N/m", linear(grain.mass, 1e6, restitution), 5e-5),
        ("linear, 1e8 N/m", linear(grain.mass, 1e8, restitution), 5e-6),
        ("Hertz, 1e10 Pa", hertz(1e10, 0.3, restitution), 5e-6),
    ):
        steps = round(third / step)
        motions = both(Scene(law, [grain], step, steps, steps, "zplane 0 NULL", gravity, wide=1))
        heights = {style: motion.position[-1, 0, 2] - radius + motion.velocity[-1, 0, 2] ** 2 / (2 * gravity) for style, motion in motions.items()}
        table.add("dem02", f"it bounces on, {name}", "third height over the first", restitution**6, {style: value / (height - radius) for style, value in heights.items()})


def stack(table: Table) -> None:
    """dem03. Two spheres pressed between two planes touch one another and both all the time: a linear system."""
    stiffness, gravity, diameter, ceiling = 1e3, 9.81, 1e-3, 1.8e-3
    for name, densities, damping in (("equal, without damping", (1e4, 1e4), 0.0), ("unequal, damped", (2e4, 1e4), 0.01)):
        grains = [Grain((0, 0, place), axes=(diameter,) * 3, density=density) for place, density in zip((0.45e-3, 1.35e-3), densities)]
        law = {
            ELLIPSOID: f"lsd {stiffness} {damping} limit_force no",
            GRANULAR: f"hooke {stiffness} {damping} tangential linear_nohistory 0 0 damping velocity",
        }
        motions = both(Scene(law, grains, 5e-7, 4000, 4000, f"zplane 0 {ceiling}", gravity, wide=0.005))
        # Of the state (z1, z2, v1, v2, 1).
        system = np.zeros((5, 5))
        system[0, 2] = system[1, 3] = 1
        for k, (grain, least) in enumerate(zip(grains, (diameter / 2, ceiling - diameter / 2))):
            spring = np.array([-2.0, 1.0] if k == 0 else [1.0, -2.0])
            away = least - diameter if k == 0 else least + diameter
            system[2 + k, :2] = stiffness / grain.mass * spring
            system[2 + k, 2:4] = damping / grain.mass * spring
            system[2 + k, 4] = stiffness / grain.mass * away - gravity
        end = expm(system * 2e-3) @ np.array([*(grain.place[2] for grain in grains), 0, 0, 1])
        for k, which in enumerate(("lower", "upper")):
            table.add("dem03", f"two pressed between planes, {name}", f"height of the {which} after 2 ms", end[k], {s: m.position[-1, k, 2] for s, m in motions.items()}, 1e-4)


def sliding(table: Table) -> None:
    """dem04."""
    stiffness, restitution, radius = 1e4, 0.9, 0.5
    for friction in (0.2, 0.5):
        grain = Grain((0, 0, radius - np.pi / 6 / stiffness), (1, 0, 0))
        damping = 50 * dashpot(grain.mass, stiffness, restitution)
        law = linear(grain.mass, stiffness, restitution, f"linear 2857 {damping!r} {friction}", f"linear_history 2857 50 {friction}")
        motions = both(Scene(law, [grain], 1e-4, 30000, 1000, "zplane 0 NULL", 1.0))
        scene = f"a sphere slides, then rolls, friction {friction:g}"
        at = 4
        inertia = grain.inertia[1]
        table.add("dem04", scene, "velocity while it slides", 1 - friction * 0.4, {s: m.velocity[at, 0, 0] for s, m in motions.items()}, 1.0)
        table.add("dem04", scene, "spin while it slides", 2.5 * friction * 0.4 / radius, {s: m.angular_momentum[at, 0, 1] / inertia for s, m in motions.items()}, 1 / radius)
        table.add("dem04", scene, "velocity when it rolls", 5 / 7, {s: m.velocity[-1, 0, 0] for s, m in motions.items()})
        table.add("dem04", scene, "spin when it rolls", 5 / 7 / radius, {s: m.angular_momentum[-1, 0, 1] / inertia for s, m in motions.items()})


def oblique(table: Table) -> None:
    """dem05. Gross sliding, and no energy from nothing at any incidence; two ellipsoids (there superellipsoids) keep their momenta."""
    restitution, friction, radius = 0.9, 0.3, 0.5
    for name, law in (
        ("linear", linear(np.pi / 6, 1e4, restitution, f"linear 2857 0 {friction}", f"linear_history 2857 0 {friction}")),
        ("Hertz and Mindlin", hertz(1e5, 0.3, restitution, friction)),
        ("Hertz and Mindlin, 1e9", hertz(1e9, 0.3, restitution, friction)),
    ):
        step = 1e-6 if "1e9" in name else 5e-5
        grain = Grain((0, 0, 0.51), (6, 0, -1))
        steps = round((0.03 if "1e9" in name else 0.15) / step)
        motions = both(Scene(law, [grain], step, steps, steps, "zplane 0 NULL"))
        slid = friction * (1 + restitution)
        table.add("dem05", f"oblique impact that slides, {name}", "tangential velocity", 6 - slid, {s: m.velocity[-1, 0, 0] for s, m in motions.items()}, slid)
        table.add("dem05", f"oblique impact that slides, {name}", "normal velocity", restitution, {s: m.velocity[-1, 0, 2] for s, m in motions.items()})
        table.add(
            "dem05", f"oblique impact that slides, {name}", "spin", 2.5 * slid / radius, {s: m.angular_momentum[-1, 0, 1] / grain.inertia[1] for s, m in motions.items()}
        )
    most = {style: -1.0 for style in (GRANULAR, ELLIPSOID)}
    for along in (0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 6.0):
        grain = Grain((0, 0, 0.51), (along, 0, -1))
        for style, motion in both(Scene(hertz(1e5, 0.3, 1.0, friction), [grain], 5e-5, 3000, 3000, "zplane 0 NULL")).items():
            after, before = (energy(grain, motion.velocity[k, 0], motion.angular_momentum[k, 0]) for k in (-1, 0))
            most[style] = max(most[style], after / before - 1)
    table.add("dem05", "oblique impacts at ten incidences, elastic, Hertz and Mindlin", "greatest gain of energy", 0.0, most, 1.0)
    ellipsoids = [
        Grain(place, velocity, axes=(1.5, 1, 1), density=4 / np.pi) for place, velocity in (((-2, 0, 0), (3, 0, 0)), ((2, 0.5, 0), (0, 0, 0)))
    ]
    motion = run(Scene({ELLIPSOID: "lsd 1000 0 tangential linear 285 0 0.5"}, ellipsoids, 5e-4, 2400, 2400), ELLIPSOID)
    masses = np.array([grain.mass for grain in ellipsoids])
    momentum = masses @ motion.velocity[-1] - masses @ motion.velocity[0]
    turning = [(np.cross(motion.position[k], motion.velocity[k]) * masses[:, None] + motion.angular_momentum[k]).sum(0) for k in (0, -1)]
    table.add("dem05", "two ellipsoids collide, linear, friction 0.5", "momentum gained, over that before", 0.0, {ELLIPSOID: np.abs(momentum).max()}, 3 * masses[0])
    table.add(
        "dem05", "two ellipsoids collide, linear, friction 0.5", "angular momentum gained, over the momentum and a semi-axis", 0.0, {ELLIPSOID: np.abs(turning[1] - turning[0]).max()}, 3 * masses[0] * 0.75
    )


def settling_velocity(table: Table) -> None:
    """dem06."""
    grain = Grain((0, 0, 8))
    motions = both(Scene(linear(grain.mass, 1e4, 0.9), [grain], 1e-3, 6000, 6000, gravity=1.0, drag="viscous 1"))
    # Velocity from rest: the limit is reached but for exp(-6/m).
    wanted = -grain.mass * (1 - np.exp(-6 / grain.mass))
    table.add("dem06", "a sphere sinks with linear drag", "velocity", wanted, {s: m.velocity[-1, 0, 2] for s, m in motions.items()})


def rolling(table: Table) -> None:
    """dem07."""
    stiffness, gravity, resistance = 1e4, 10.0, 0.1
    grain = Grain((0, 0, 0.5 - np.pi / 6 * gravity / stiffness), spin=(0, 5, 0))
    law = linear(grain.mass, stiffness, 0.5, more=f"rolling sds 1000 0 {resistance}")
    motions = both(Scene(law, [grain], 1e-4, 4000, 4000, "zplane 0 NULL", gravity))
    table.add(
        "dem07", "rolling resistance stops a spin", "spin after 0.4 s", 5 - 5 * resistance * gravity * 0.4, {s: m.angular_momentum[-1, 0, 1] / grain.inertia[1] for s, m in motions.items()}, 5.0
    )


def collisions(table: Table) -> None:
    """dem09."""
    stiffness, radius = 1e4, 0.5
    half = np.pi / 12
    pair = [Grain((-0.51, 0, 0), (1, 0, 0)), Grain((0.51, 0, 0), (-1, 0, 0))]
    for name, law in (("linear", linear(half, stiffness, 0.9)), ("Hertz", hertz(1e5, 0.3, 0.9))):
        motions = both(Scene(law, pair, 5e-5, 3000, 3000))
        table.add("dem09", f"two spheres meet head on, {name}", "restitution", 0.9, {s: (m.velocity[-1, 1, 0] - m.velocity[-1, 0, 0]) / 2 for s, m in motions.items()})
    offset = [Grain((-0.6, -0.2, 0), (1, 0, 0)), Grain((0.6, 0.2, 0), (-1, 0, 0))]
    law = linear(half, stiffness, 0.9, "linear 8235 0 0.5", "linear_history 8235 0 0.5")
    motions = both(Scene(law, offset, 5e-5, 7200, 7200))
    gained = {}
    for style, motion in motions.items():
        turning = [(np.cross(motion.position[k], motion.velocity[k]) * pair[0].mass + motion.angular_momentum[k]).sum(0) for k in (0, -1)]
        gained[style] = float(np.abs(turning[1] - turning[0]).max())
    table.add("dem09", "two spheres meet off centre, linear, friction 0.5", "angular momentum gained", 0.0, gained, 2 * 0.2 * pair[0].mass)
    law = linear(half, stiffness, 0.9, "linear 2857 0 0.5", "linear_history 2857 0 0.5")
    turned = [Grain((0, 0, -0.5), (0, 0, 1), (0, 10, 0)), Grain((0, 0, 0.5), (0, 0, -1), (0, -10, 0))]
    motions = both(Scene(law, turned, 2e-4, 600, 600))
    table.add("dem09", "two that roll on one another meet", "spin after", 10.0, {s: m.angular_momentum[-1, 0, 1] / turned[0].inertia[1] for s, m in motions.items()})
    friction, restitution = 0.4, 0.8
    spinning = Grain((0, 0, radius), (0, 0, -1), (0, 20, 0))
    heavy = Grain((0, 0, -2.5), axes=(5, 5, 5), density=1000)
    law = linear(spinning.mass, stiffness, restitution, f"linear 2857 0 {friction}", f"linear_history 2857 0 {friction}")
    slid = friction * (1 + restitution)
    for name, grains, wall in (("a plane", [spinning], "zplane 0 NULL"), ("a sphere of 125 000 times its mass", [spinning, heavy], "")):
        motions = both(Scene(law, grains, 2e-5, 6000, 6000, wall))
        scene = f"a sphere that turns meets {name}"
        table.add("dem09", scene, "normal velocity", restitution, {s: m.velocity[-1, 0, 2] for s, m in motions.items()})
        table.add("dem09", scene, "tangential velocity", slid, {s: m.velocity[-1, 0, 0] for s, m in motions.items()})
        table.add("dem09", scene, "spin", 20 - 2.5 * slid / radius, {s: m.angular_momentum[-1, 0, 1] / spinning.inertia[1] for s, m in motions.items()}, 2.5 * slid / radius)


def hertz_peak(table: Table) -> None:
    """dem11: greatest penetration and force of an elastic impact, of two spheres and on a plane."""
    modulus, poisson, speed, radius = 1e11, 0.25, 3.9, 2.5e-3
    for name, count in (("on a plane", 1), ("of two spheres", 2)):
        axes = (2 * radius,) * 3
        grains = [Grain((0, 0, radius), (0, 0, -speed), axes=axes, density=7000), Grain((0, 0, -radius), (0, 0, speed), axes=axes, density=7000)][:count]
        mass, closing, effective = (grains[0].mass, speed, radius) if count == 1 else (grains[0].mass / 2, 2 * speed, radius / 2)
        stiffness = 4 / 3 * modulus / (2 * (1 - poisson**2)) * np.sqrt(effective)
        greatest = (5 * mass * closing**2 / (4 * stiffness)) ** 0.4
        step = greatest / closing / 2000
        scene = Scene(hertz(modulus, poisson, 1.0), grains, step, 4000, 1, "zplane 0 NULL" if count == 1 else "", wide=0.02)
        motions = both(scene)
        overlaps = {s: (radius - m.position[:, 0, 2] if count == 1 else 2 * radius + m.position[:, 1, 2] - m.position[:, 0, 2]).max() for s, m in motions.items()}
        table.add("dem11", f"elastic impact {name}, Hertz", "greatest penetration", greatest, overlaps)
        table.add("dem11", f"elastic impact {name}, Hertz", "greatest force", stiffness * greatest**1.5, {s: m.force[:, 0, 2].max() for s, m in motions.items()})


def heaps() -> List[Row]:
    """dem10: 120 grains poured between walls. LAMMPS asks for an angle, of the height of the uppermost centre over its greatest distance from the
    middle, between 15 and 55 degrees."""
    stiffness, restitution = 1e4, 0.3
    rolling = "rolling sds 500 50 0.5"

    def law(mass: float, style: str) -> str:
        damping = dashpot(mass, stiffness, restitution)
        words = {ELLIPSOID: f"linear 8235 {damping!r} 1", GRANULAR: "linear_history 8235 1 1"}
        return linear(mass, stiffness, restitution, words[ELLIPSOID], words[GRANULAR], rolling)[style]

    rows: List[Row] = []
    for style, shape, axes in (
        (GRANULAR, "spheres", (1.0,)),
        (ELLIPSOID, "spheres", (1.0, 1.0, 1.0)),
        (ELLIPSOID, "ellipsoids 1.5:1:1", (1.5 ** (2 / 3), 1.5 ** (-1 / 3), 1.5 ** (-1 / 3))),
    ):
        for seed in (5783, 5784, 5785):
            with tempfile.TemporaryDirectory() as directory:
                dump = Path(directory) / "heap.dump"
                values = {
                    "plugin": os.environ["ELLGRAN_LAMMPS_PLUGIN"],
                    "style": style,
                    "law": law(np.pi / 12, style),
                    "wall_law": law(np.pi / 6, style),
                    "axes": words(axes),
                    "seed": seed,
                    "dump": dump,
                }
                options = [str(word) for name, value in values.items() for word in ("-var", name, value)]
                command = [os.environ["ELLGRAN_LAMMPS"], "-nocite", "-log", "none", "-in", str(HERE / "heap.lmp"), *options]
                done = subprocess.run(command, capture_output=True, text=True)
                if done.returncode != 0:
                    raise RuntimeError(f"LAMMPS stopped at the heap of {shape}, {style}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
                places = np.loadtxt(dump, skiprows=9)
            energy_left = float(next(line for line in done.stdout.splitlines() if line.startswith("kinetic energy")).split()[2])
            away = np.hypot(*(places[:, :2] - places[:, :2].mean(0)).T)
            rows.append(
                {
                    "style": style,
                    "grains": shape,
                    "seed": seed,
                    "count": len(places),
                    "angle": float(np.degrees(np.arctan2(places[:, 2].max(), away.max()))),
                    "kinetic_energy": energy_left,
                }
            )
            print(f"dem10, {shape}, {style}: {rows[-1]['angle']:.1f} degrees, kinetic energy {energy_left:.1e}", flush=True)
    return rows


def compared() -> List[Row]:
    table = Table()
    for scene in (free_fall_and_bounce, bounces, stack, sliding, oblique, settling_velocity, rolling, collisions, hertz_peak):
        scene(table)
    return table.rows
