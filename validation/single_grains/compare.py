# SPDX-License-Identifier: MIT OR Apache-2.0
"""Impacts of single spheres through LAMMPS: the tests of Chung and Ooi (2011) against closed forms and what they printed, Kharaz et al.
(2001), measured, and LAMMPS' own granular tests."""
from __future__ import annotations

import os
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List

import numpy as np

import lammps_tests
from stored import write_csv, write_origin

HERE = Path(__file__).resolve().parent
#: Contact time of an elastic Hertz collision, in units of the greatest penetration over the speed.
HERTZ_TIME = 2.9432751843247047
STEPS = 2000


@dataclass
class Impact:
    """SI units. Against a plane the modulus is that of the sphere, and the plane is rigid. The large sphere has 5 times the radius, 1000
    times the density, and `partner_modulus` times the modulus."""

    partner: str
    radius: float
    density: float
    modulus: float
    poisson: float
    down: float
    along: float = 0.0
    spin: float = 0.0
    restitution: float = 1.0
    tangential: str = "none"
    partner_modulus: float = 1.0

    @property
    def mass(self) -> float:
        return self.density * 4 / 3 * np.pi * self.radius**3

    @property
    def stiffness(self) -> float:
        """k of F = k delta^(3/2), delta the penetration of sphere and plane, or of the two spheres."""
        effective_radius = self.radius * {"plane": 1, "sphere": 1 / 2, "large": 5 / 6}[self.partner]
        return 2 / 3 * self.modulus_of_both / (1 - self.poisson**2) * np.sqrt(effective_radius)

    @property
    def modulus_of_both(self) -> float:
        """Of two equal materials that are as compliant together as these are. The words of a law stand for both sides."""
        return self.modulus * {"plane": 2, "sphere": 1, "large": 2 / (1 + 1 / self.partner_modulus)}[self.partner]

    @property
    def closing_speed(self) -> float:
        return 2 * self.down if self.partner == "sphere" else self.down

    @property
    def closing_mass(self) -> float:
        return self.mass * {"plane": 1, "sphere": 1 / 2, "large": 125000 / 125001}[self.partner]

    @property
    def greatest_penetration(self) -> float:
        """Of the elastic impact, by Hertz."""
        return (5 * self.closing_mass * self.closing_speed**2 / (4 * self.stiffness)) ** 0.4

    @property
    def duration(self) -> float:
        """Of the elastic impact, by Hertz."""
        return HERTZ_TIME * self.greatest_penetration / self.closing_speed

    def law(self) -> str:
        damping = "" if self.restitution == 1 else f" damping restitution {self.restitution}"
        return f"hertz {self.modulus_of_both!r} {self.poisson}{damping} tangential {self.tangential}"


def run(impact: Impact) -> Dict[str, np.ndarray]:
    """Columns of all steps."""
    # A strongly damped impact takes longer than the elastic one.
    values = {
        "plugin": os.environ["ELLGRAN_LAMMPS_PLUGIN"],
        "partner": impact.partner,
        "law": impact.law(),
        "radius": impact.radius,
        "density": impact.density,
        "along": impact.along,
        "down": impact.down,
        "spin": impact.spin,
        "step": impact.duration / STEPS,
        "steps": round((1.3 if impact.restitution > 0.9 else 3) * STEPS),
    }
    words = [str(word) for name, value in values.items() for word in ("-var", name, value)]
    done = subprocess.run(
        [os.environ["ELLGRAN_LAMMPS"], "-nocite", "-log", "none", "-in", str(HERE / "impact.lmp"), *words], capture_output=True, text=True
    )
    if done.returncode != 0:
        raise RuntimeError(f"LAMMPS stopped at {impact}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    lines = done.stdout.splitlines()
    first = next(number for number, line in enumerate(lines) if line.split()[:1] == ["Step"])
    last = next(number for number, line in enumerate(lines) if line.startswith("Loop time"))
    table = np.array([line.split() for line in lines[first + 1 : last]], dtype=float)
    columns = dict(zip(("step", "height", "force", "along", "up", "spin"), table.T))
    if columns["force"][-1] != 0:
        raise RuntimeError(f"still in contact: {impact}")
    return columns


def normal(name: str, impact: Impact) -> Dict[str, Any]:
    """Greatest force, duration and restitution."""
    columns = run(impact)
    step = impact.duration / STEPS
    touching = columns["force"] != 0
    # The instant of parting, from the motion after it.
    over = columns["height"][-1] - impact.radius
    parted = columns["step"][-1] * step - over / columns["up"][-1]
    return {
        "test": name,
        "restitution_wanted": impact.restitution,
        "greatest_force": columns["force"].max(),
        "greatest_force_by_hertz": impact.stiffness * impact.greatest_penetration**1.5,
        "duration": parted if impact.restitution == 1 else float(touching.sum() * step),
        "duration_by_hertz": impact.duration,
        "restitution": columns["up"][-1] / impact.down,
    }


def oblique(name: str, impact: Impact, friction: float) -> Dict[str, Any]:
    """Velocity, spin and contact-point velocity after the impact, beside those of gross sliding."""
    columns = run(impact)
    point = impact.along - impact.radius * impact.spin
    # Gross sliding: the impulse of friction is mu times that of the normal force.
    slid = friction * (1 + impact.restitution) * impact.down
    wanted = {"along": impact.along - np.sign(point) * slid, "spin": impact.spin + np.sign(point) * 2.5 * slid / impact.radius}
    after = columns["along"][-1] - impact.radius * columns["spin"][-1]
    return {
        "test": name,
        "law": impact.tangential,
        "penetration": impact.greatest_penetration / impact.radius,
        "incidence": abs(point) / (friction * impact.down),
        # The coefficient of tangential restitution: of the velocity of the point, reversed.
        "tangential_restitution": -after / point,
        # The same of gross sliding, plus 1: 7 mu (1 + e) v_n / (2 v_t).
        "slip": 3.5 * friction * (1 + impact.restitution) * impact.down / abs(point),
        "angle": np.degrees(np.arctan2(impact.along, impact.down)),
        "along": columns["along"][-1],
        "up": columns["up"][-1],
        "spin": columns["spin"][-1],
        "along_sliding": wanted["along"],
        "spin_sliding": wanted["spin"],
        # Of what sliding changes.
        "along_error": (columns["along"][-1] - wanted["along"]) / slid,
        "spin_error": (columns["spin"][-1] - wanted["spin"]) / (2.5 * slid / impact.radius),
        "point_after": np.sign(point) * after / (friction * impact.restitution * impact.down),
    }


def main() -> None:
    started = time.monotonic()
    normals: List[Dict[str, Any]] = []
    for name, modulus, poisson, density in (("glass", 4.8e10, 0.2, 2800.0), ("limestone", 2.0e10, 0.25, 2500.0)):
        normals.append(normal(f"1, {name}", Impact("sphere", 0.01, density, modulus, poisson, 10.0)))
    for name, modulus, poisson, density in (("aluminium alloy", 7.0e10, 0.3, 2699.0), ("magnesium alloy", 4.0e10, 0.35, 1800.0)):
        normals.append(normal(f"2, {name}", Impact("plane", 0.1, density, modulus, poisson, 0.2)))
    for name, modulus, poisson, density in (("aluminium oxide", 3.8e11, 0.23, 4000.0), ("cast iron", 1.0e11, 0.25, 7000.0)):
        for restitution in (0.2, 0.4, 0.6, 0.8, 1.0):
            impact = Impact("plane", 0.0025, density, modulus, poisson, 3.9, restitution=restitution)
            normals.append(normal(f"3, {name}", impact))
    write_csv(HERE / "normal_impacts.csv", normals)

    obliques: List[Dict[str, Any]] = []
    laws = ("tfd", "mindlin")
    for name, modulus, poisson, density in (("aluminium oxide", 3.8e11, 0.23, 4000.0), ("aluminium alloy", 7.0e10, 0.33, 2700.0)):
        for law in laws:
            for angle in (2, 4, 6, 8, 10, 12, 15, 18, 20, 25, 30, 35, 40, 50, 60, 70, 80, 85):
                down, along = 3.9 * np.cos(np.radians(angle)), 3.9 * np.sin(np.radians(angle))
                impact = Impact("plane", 0.0025, density, modulus, poisson, down, along, 0.0, 0.98, f"{law} 0.092")
                obliques.append(oblique(f"4, {name}", impact, 0.092))
    for name, modulus, poisson, density in (("steel", 2.08e11, 0.3, 7850.0), ("polyethylene", 1.0e9, 0.4, 1400.0)):
        for law in laws:
            for along in (0.1, 0.3, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0):
                impact = Impact("plane", 1e-5, density, modulus, poisson, 5.0, along, 0.0, 1.0, f"{law} 0.3")
                obliques.append(oblique(f"5, {name}", impact, 0.3))
    for name, modulus, poisson, density in (("aluminium alloy", 7.0e10, 0.33, 2700.0), ("copper", 1.2e11, 0.35, 8900.0)):
        for law in laws:
            for spin in (0.175, 0.3, 0.5, 0.9, 1.3, 2.0, 3.0, 4.0, 5.0, 7.0, 9.0, 12.0, 22.0):
                impact = Impact("sphere", 0.1, density, modulus, poisson, 0.2, 0.0, -spin, 0.5, f"{law} 0.4")
                obliques.append(oblique(f"7, {name}", impact, 0.4))
    # Tests 6 and 8: the spin makes the point move at the angle to the impact that the paper has, 5 to 85 degrees.
    spins = [2 * np.tan(np.radians(angle)) for angle in range(5, 90, 5)]
    alloy, nylon = (7.0e10, 0.33, 2700.0), (2.5e9, 0.4, 1000.0)
    for name, partner, (modulus, poisson, density), ratio in (
        ("6, aluminium alloy", "plane", alloy, 1.0),
        ("6, nylon", "plane", nylon, 1.0),
        ("8, case A", "large", alloy, 1000.0),
        ("8, case B", "large", alloy, 1.0),
    ):
        for law in laws:
            for spin in spins:
                impact = Impact(partner, 0.1, density, modulus, poisson, 0.2, 0.0, -spin, 0.5, f"{law} 0.4", ratio)
                obliques.append(oblique(name, impact, 0.4))
    write_csv(HERE / "oblique_impacts.csv", obliques)
    write_csv(HERE / "lammps_tests.csv", lammps_tests.compared())
    write_csv(HERE / "heaps.csv", lammps_tests.heaps())
    write_origin(HERE, started, LAMMPS=os.environ["ELLGRAN_LAMMPS_VERSION"])


if __name__ == "__main__":
    main()
