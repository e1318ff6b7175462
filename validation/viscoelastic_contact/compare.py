# SPDX-License-Identifier: MIT OR Apache-2.0
"""The viscous normal law held against Kelvin-Voigt half-spaces with their exact memory; see README.md here."""
from __future__ import annotations

import time
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

import ellgran
from kelvin_voigt import Contact, Rebound, Solid, by_boundary_elements, impact
from stored import write_csv, write_origin

HERE = Path(__file__).resolve().parent
POISSON = (0.1, 0.3, 0.45)
# Shear and bulk viscosity over their moduli; scaled so that the first-order time is 1.
VISCOSITIES = {"shear alone": (1.0, 0.0), "bulk alone": (0.0, 1.0), "bulk 3 x shear": (1.0, 3.0), "proportional": (1.0, 1.0)}
# First-order time times speed over elastic depth.
RATES = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)
LAWS = {
    "energy": "closure energy",
    "surface": "closure surface",
    "brilliantov": "closure brilliantov",
    "energy, first order receding": "closure energy unloading first_order",
    "memory": "viscosity memory",
}
# Two solids: E, nu, shear and bulk viscosity of each.
SOLIDS = {
    "both in shear and bulk": (Solid(1.0, 0.3, 1.0, 0.5), Solid(2.0, 0.2, 0.3, 4.0)),
    "one in shear, one in bulk": (Solid(1.0, 0.3, 1.0, 1e-6), Solid(1.0, 0.3, 1e-6, 3.0)),
    "one elastic": (Solid(1.0, 0.1, 1e-6, 1.0), Solid(1.0, 0.3, 1e-9, 1e-9)),
    "times 1000 apart": (Solid(1.0, 0.1, 1.0, 30.0), Solid(1.0, 0.3, 0.01, 0.01)),
}
SPEED = 1e-7
RADIUS = 1.0


def solid(poisson: float, viscosity: str) -> Solid:
    """E = 1, first-order time 1."""
    shear, bulk = VISCOSITIES[viscosity]
    shear, bulk = shear / (1 + poisson), bulk / (3 * (1 - 2 * poisson))
    scale = Solid(1.0, poisson, shear, bulk).first_order_time()
    return Solid(1.0, poisson, shear / scale, bulk / scale)


def deck(of: Solid, words: str) -> str:
    return f"nfd {of.modulus} {of.poisson} {of.shear_viscosity!r} {of.bulk_viscosity!r} {words} conservative no"


class Spheres:
    """Equal spheres of the solid, or of two, by the library: many contacts at a time, each with its penetration, its rate and what is
    remembered of it."""

    def __init__(self, of: Solid, words: str, count: int, other: Optional[Solid] = None) -> None:
        self._law = ellgran.Laws(deck(of, words), deck(other or of, words))
        self._remembers = words == LAWS["memory"]
        one = ellgran.Bodies(np.zeros((count, 3)), RADIUS)
        self._bodies, self._pairs = ellgran.side_by_side(one, one)
        self._bodies.types[count:] = 2
        self._count = count
        self._alone = ellgran.side_by_side(*2 * [ellgran.Bodies(np.zeros((1, 3)), RADIUS)])
        self._alone[0].types[1:] = 2
        self._memories = [ellgran.ContactMemory(self._law, 1) for _ in range(count)]

    def advance(self, penetrations: np.ndarray, before: np.ndarray, steps: np.ndarray) -> None:
        """What is remembered goes on by a step of each contact, in which its penetration was linear."""
        if not self._remembers:
            return
        bodies, pairs = self._alone
        for memory, now, then, step in zip(self._memories, penetrations, before, steps):
            bodies.positions[1, 2] = 2 * RADIUS - now
            bodies.velocities[1, 2] = -(now - then) / step
            ellgran.contacts(self._law, bodies, pairs, time_step=float(step), memory=memory, quantities=[])

    def forces(self, penetrations: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """At these rates; nothing goes on."""
        self._bodies.positions[self._count :, 2] = 2 * RADIUS - penetrations
        self._bodies.velocities[self._count :, 2] = -rates
        memory = ellgran.ContactMemory(self._law, self._count)
        memory.touching[:] = [one.touching[0] for one in self._memories]
        memory.history[:] = [one.history[0] for one in self._memories]
        return ellgran.contacts(
            self._law, self._bodies, self._pairs, advance_history=False, memory=memory, quantities=["normal_force"]
        ).normal_force

    def along(self, path: np.ndarray) -> np.ndarray:
        """Forces along (time, penetration, rate), of a single contact."""
        if not self._remembers:
            return Spheres.forces(self, path[:, 1], path[:, 2])
        before, forces = np.zeros(2), []
        for time_now, penetration, rate in path[:, :3]:
            self.advance(np.array([penetration]), before[1:], np.array([time_now - before[0]]))
            forces.append(float(self.forces(np.array([penetration]), np.array([rate]))[0]))
            before = np.array([time_now, penetration])
        return np.array(forces)

    def coefficient(self) -> float:
        """c of the elastic force c E* delta^(3/2), E* that of one body on a rigid one."""
        return (4.0 / 3.0) * 0.5 * np.sqrt(0.5 * RADIUS)


def masses(of: Solid, coefficient: float, rates: Sequence[float]) -> np.ndarray:
    """Effective masses whose impacts at SPEED have these RATES."""
    depths = of.first_order_time() * SPEED / np.array(rates)
    return 4 * coefficient * of.relaxation().static * depths**2.5 / (5 * SPEED**2)


def rebounds(spheres: Spheres, mass: np.ndarray, step: np.ndarray, steps: int) -> Tuple[np.ndarray, np.ndarray]:
    """Restitutions and durations of the law, integrated as `impact` integrates the reference."""
    depth, rate, force = np.zeros_like(mass), np.full_like(mass, SPEED), np.zeros_like(mass)
    left, duration = np.zeros_like(mass), np.zeros_like(mass)
    for number in range(1, 100 * steps):
        half = rate - 0.5 * step * force / mass
        before = depth
        depth = depth + step * half
        spheres.advance(depth, before, step)
        ahead = half - 0.5 * step * force / mass
        for _ in range(2):
            force = spheres.forces(depth, ahead)
            ahead = half - 0.5 * step * force / mass
        rate = ahead
        ended = (duration == 0) & (rate < 0) & (force <= 0)
        left[ended], duration[ended] = -rate[ended] / SPEED, (number * step)[ended]
        if duration.all():
            return left, duration
    raise RuntimeError("an impact does not end")


def impacts(
    poissons: Sequence[float], rates: Sequence[float], steps: int, viscosities: Sequence[str] = tuple(VISCOSITIES)
) -> List[Dict[str, Any]]:
    """Each closure against the exact memory: restitution, duration, force along the exact motion."""
    rows = []
    for poisson in poissons:
        for viscosity in viscosities:
            of = solid(poisson, viscosity)
            relaxation = of.relaxation()
            coefficient = Spheres(of, "closure energy", 1).coefficient()
            exact: List[Rebound] = []
            bars = []
            for mass in masses(of, coefficient, rates):
                exact.append(impact(relaxation, coefficient, mass, SPEED, steps))
                coarse = impact(relaxation, coefficient, mass, SPEED, steps // 2)
                bars.append(abs(coarse.restitution - exact[-1].restitution))
            for name, words in LAWS.items():
                mass = masses(of, coefficient, rates)
                step = of.first_order_time() / np.array(rates) / steps
                left, duration = rebounds(Spheres(of, words, len(rates)), mass, step, steps)
                for k, (rate, rebound) in enumerate(zip(rates, exact)):
                    path = rebound.path
                    forces = Spheres(of, words, 1 if name == "memory" else len(path)).along(path)
                    largest = path[:, 3].max()
                    loading = path[:, 2] >= 0
                    error = np.abs(forces - path[:, 3]) / largest
                    rows.append(
                        {
                            "poisson": poisson,
                            "viscosity": viscosity,
                            "law": name,
                            "rate": rate,
                            "memory": rate / float(relaxation.rate[0]) / of.first_order_time(),
                            "restitution": rebound.restitution,
                            "restitution_bar": bars[k],
                            "restitution_of_law": float(left[k]),
                            "duration": rebound.duration * SPEED / (of.first_order_time() * SPEED / rate),
                            "duration_of_law": float(duration[k]) * rate / of.first_order_time(),
                            "force_error_loading": float(error[loading].max()),
                            "force_error_receding": float(error[~loading].max()),
                        }
                    )
            print(f"nu {poisson}, {viscosity}: tau_m/A {1 / float(relaxation.rate[0]) / of.first_order_time():.3g}", flush=True)
    return rows


def impacts_of_two_solids(rates: Sequence[float], steps: int, solids: Sequence[str] = tuple(SOLIDS)) -> List[Dict[str, Any]]:
    """First order and memory against the exact memory of two solids, three relaxing parts: restitution, force along the exact motion."""
    rows = []
    for name in solids:
        one, other = SOLIDS[name]
        relaxation = one.on(other)
        coefficient = 2 * Spheres(one, "", 1).coefficient()
        time_of_first_order = relaxation.first_order_time()
        depths = time_of_first_order * SPEED / np.array(rates)
        mass = 4 * coefficient * relaxation.static * depths**2.5 / (5 * SPEED**2)
        exact = [impact(relaxation, coefficient, m, SPEED, steps) for m in mass]
        for law in ("energy", "memory"):
            step = time_of_first_order / np.array(rates) / steps
            left, duration = rebounds(Spheres(one, LAWS[law], len(rates), other), mass, step, steps)
            for k, (rate, rebound) in enumerate(zip(rates, exact)):
                path = rebound.path
                forces = Spheres(one, LAWS[law], 1 if law == "memory" else len(path), other).along(path)
                rows.append(
                    {
                        "solids": name,
                        "law": law,
                        "rate": rate,
                        "restitution": rebound.restitution,
                        "restitution_of_law": float(left[k]),
                        "duration": rebound.duration * rate / time_of_first_order,
                        "duration_of_law": float(duration[k]) * rate / time_of_first_order,
                        "force_error": float(np.abs(forces - path[:, 3]).max() / path[:, 3].max()),
                    }
                )
        print(f"{name}: relaxing times {np.round(1 / relaxation.rate / time_of_first_order, 3)} of the first-order time", flush=True)
    return rows


def ellipses(march: Sequence[Dict[str, Any]]) -> List[Dict[str, Any]]:
    """The library's laws along the motion of `marched`, beside its boundary elements: force / largest force of the exact memory."""
    rows = []
    finer = 20
    for ratio in sorted({row["ratio"] for row in march}):
        axes = [float(np.sqrt(ratio)), 1.0, 1.0]
        for poisson in POISSON:
            of = solid(poisson, "bulk 3 x shear")
            of = of._replace(shear_viscosity=0.1 * of.shear_viscosity, bulk_viscosity=0.1 * of.bulk_viscosity)
            own = [row for row in march if row["ratio"] == ratio and row["poisson"] == poisson]
            found: Dict[str, List[float]] = {}
            shape = ellgran.Bodies([[0, 0, 0], [0, 0, 1.0]], axes)
            shape.positions[1, 2] = 2.0 - 1e-3
            c = float(ellgran.contacts("hertz 1.0 0.0 conservative no", shape, [[0, 1]]).normal_force[0]) / 0.5 / 1e-3**1.5
            contact, largest = Contact(of.relaxation(), c), 0.0
            steps = len(own) * finer
            for k in range(1, steps + 1):
                now = k / steps
                depth, rate = 1e-3 * np.sin(np.pi * now), 1e-3 * np.pi * np.cos(np.pi * now)
                largest = max(largest, contact.force(now, depth, rate))
            for name, words in LAWS.items():
                law = ellgran.Laws(deck(of, words))
                memory = ellgran.ContactMemory(law, 1)
                before = 0.0
                for k in range(1, steps + 1):
                    now = k / steps
                    depth, rate = 1e-3 * np.sin(np.pi * now), 1e-3 * np.pi * np.cos(np.pi * now)
                    shape.positions[1, 2] = 2.0 - depth
                    shape.velocities[1, 2] = -(depth - before) * steps
                    ellgran.contacts(law, shape, [[0, 1]], time_step=1 / steps, memory=memory, quantities=[])
                    before = depth
                    if k % finer == 0:
                        shape.velocities[1, 2] = -rate
                        force = ellgran.contacts(
                            law, shape, [[0, 1]], advance_history=False, memory=memory, quantities=["normal_force"]
                        ).normal_force[0]
                        # Two such bodies have half the modulus of one on a rigid one.
                        found.setdefault(name, []).append(2 * float(force) / largest)
            for k, row in enumerate(own):
                rows.append(
                    {
                        "ratio": ratio,
                        "poisson": poisson,
                        "time": row["time"],
                        "boundary_elements": row["boundary_elements"],
                        "exact_memory": row["exact_memory"],
                        **{name: values[k] for name, values in found.items()},
                    }
                )
    return rows


def marched(ratios: Sequence[float], count: int, steps: int) -> List[Dict[str, Any]]:
    """The exact memory itself, held against boundary elements that march in time: a rigid paraboloid of curvature ratio B/A pressed
    in and drawn out along half a sine, at a first-order time of 0.1 of the time."""
    rows = []
    for ratio in ratios:
        shape = ellgran.Bodies([[0, 0, 0], [0, 0, 2.0 - 1e-3]], [float(np.sqrt(ratio)), 1.0, 1.0])
        found = ellgran.contacts("hertz 1.0 0.0 conservative no", shape, [[0, 1]])
        # Two bodies of E = 1, nu = 0 have E* = 1/2.
        coefficient = float(found.normal_force[0]) / 0.5 / 1e-3**1.5
        a, b = (float(axis) / np.sqrt(1e-3) for axis in found.contact_semi_axes[0])
        for poisson in POISSON:
            of = solid(poisson, "bulk 3 x shear")
            of = of._replace(shear_viscosity=0.1 * of.shear_viscosity, bulk_viscosity=0.1 * of.bulk_viscosity)
            deepest = 1e-3
            forces = []
            for refined in (1, 2):
                number = steps * refined
                times = (np.arange(number) + 1.0) / number
                widest = 1.2 * np.sqrt(deepest)
                forces.append(
                    by_boundary_elements(
                        of,
                        tuple(float(c) for c in found.curvatures[0]),
                        (widest * a, widest * b),
                        count,
                        deepest * np.sin(np.pi * times),
                        1.0 / number,
                    )
                )
            extrapolated = 2 * forces[1][1::2] - forces[0]
            contact = Contact(of.relaxation(), coefficient)
            exact, finer = [], 20
            for k in range(1, steps * finer + 1):
                now = k / (steps * finer)
                force = contact.force(now, deepest * np.sin(np.pi * now), deepest * np.pi * np.cos(np.pi * now))
                if k % finer == 0:
                    exact.append(force)
            largest = max(exact)
            for k, (one, other) in enumerate(zip(exact, extrapolated)):
                rows.append(
                    {
                        "ratio": float(ratio),
                        "poisson": poisson,
                        "time": (k + 1) / steps,
                        "exact_memory": one / largest,
                        "boundary_elements": float(other) / largest,
                    }
                )
            error = max(abs(row["exact_memory"] - row["boundary_elements"]) for row in rows[-steps:])
            print(f"B/A {ratio}, nu {poisson}: boundary elements differ by {error:.1e} of the largest force", flush=True)
    return rows


def main() -> None:
    started = time.monotonic()
    march = marched((1, 4, 16), 24, 40)
    write_csv(HERE / "boundary_elements.csv", march)
    write_csv(HERE / "ellipses.csv", ellipses(march))
    write_csv(HERE / "impacts.csv", impacts(POISSON, RATES, 800))
    write_csv(HERE / "two_solids.csv", impacts_of_two_solids(RATES, 800))
    write_origin(HERE, started)


if __name__ == "__main__":
    main()
