# SPDX-License-Identifier: MIT OR Apache-2.0
"""The contact of Kelvin-Voigt half-spaces with its exact memory, frictionless, for ellipses whose axis ratio stays.

A half-space under a normal load knows one operator, E*(s) = 4 G(s) (3 K(s) + G(s)) / (3 K(s) + 4 G(s)), with
G(s) = (E1 + eta1 s)/2 and K(s) = E2 + eta2 s. It is

    E*(s) = static + dashpot s + relaxing s/(s + rate),      rate = (2 E1 + 3 E2)/(2 eta1 + 3 eta2) = 1/tau_m .

While the contact grows (Lee and Radok 1960) the force is E* applied to c delta^(3/2). While it shrinks (Ting 1966) the force is that
of the history up to the earlier time t1 at which the contact was as large, and t1 is where E* applied to the history of delta
since t1 vanishes. Nothing is of first order in the rate.

Compliances add: 1/E*(s) = 1/(4 G(s)) + 1/(4 K(s) + 4/3 G(s)), two Kelvin-Voigt elements in series a body. Two bodies of different
solids have up to four, and E* then has up to three relaxing parts; nothing else changes.
"""
from __future__ import annotations

from typing import List, NamedTuple, Tuple

import numpy as np

from half_space_kernels import Rectangles


class Solid(NamedTuple):
    """E and nu; eta1 and eta2: shear and bulk viscosity, pressure x time."""

    modulus: float
    poisson: float
    shear_viscosity: float
    bulk_viscosity: float

    def polynomials(self) -> Tuple[np.ndarray, np.ndarray]:
        """Numerator and denominator of E*(s), highest power first."""
        shear = 0.5 * np.array([self.shear_viscosity, self.modulus / (1 + self.poisson)])
        bulk = np.array([self.bulk_viscosity, self.modulus / (3 * (1 - 2 * self.poisson))])
        return 4 * np.polymul(shear, 3 * bulk + shear), 3 * bulk + 4 * shear

    def relaxation(self) -> "Relaxation":
        """Of this solid on a rigid body."""
        above, below = self.polynomials()
        quotient, rest = np.polydiv(above, below)
        dashpot = quotient[-2] if len(quotient) > 1 else 0.0
        return Relaxation(
            static=float(above[-1] / below[-1]),
            dashpot=float(dashpot),
            relaxing=np.array([-rest[-1] / below[-1]]),
            rate=np.array([below[-1] / below[-2]]),
        )

    def on(self, other: "Solid") -> "Relaxation":
        """Of this solid on another one, with both viscosities positive: 1/E* is the sum of the two."""
        (above, below), (other_above, other_below) = self.polynomials(), other.polynomials()
        below, above = np.polyadd(np.polymul(below, other_above), np.polymul(other_below, above)), np.polymul(above, other_above)
        # E* = above/below, of degrees 4 and 3: E*(s)/s has the poles 0 and -rate, and the dashpot for s to infinity.
        rates = -np.roots(below).real
        residues = np.polyval(above, -rates) / (-rates * np.polyval(np.polyder(below), -rates))
        return Relaxation(
            static=float(above[-1] / below[-1]), dashpot=float(above[0] / below[0]), relaxing=residues, rate=rates
        )

    def first_order_time(self) -> float:
        """d ln E*(s)/ds at s = 0: what a law of first order in the rate should have for A_n."""
        above, below = self.polynomials()
        return float(above[-2] / above[-1] - below[-2] / below[-1])


class Relaxation(NamedTuple):
    """E*(s) = static + dashpot s + the sum of relaxing s/(s + rate)."""

    static: float
    dashpot: float
    relaxing: np.ndarray
    rate: np.ndarray

    def first_order_time(self) -> float:
        """d ln E*(s)/ds at s = 0."""
        return float((self.dashpot + np.sum(self.relaxing / self.rate)) / self.static)


class Contact:
    """The exact force from step to step. `coefficient` c: the elastic force is c E* delta^(3/2)."""

    def __init__(self, relaxation: Relaxation, coefficient: float) -> None:
        self._of = relaxation
        self._c = coefficient
        # The loading so far: time, penetration, its memory, delta^(3/2), its memory.
        none = np.zeros_like(relaxation.rate)
        self._loading: List[Tuple[float, float, np.ndarray, float, np.ndarray]] = [(0.0, 0.0, none, 0.0, none)]
        self._memory = none
        self._last = (0.0, 0.0)
        self._receding = False
        self._pointer = 0

    def force(self, time: float, penetration: float, rate: float) -> float:
        """At the end of a step; the penetration was linear in time during it, and its rate is now `rate`. 0 once the contact has
        ended, and ever after."""
        of, (before, depth) = self._of, self._last
        step = time - before
        kept = np.exp(-of.rate * step)
        share = -np.expm1(-of.rate * step) / (of.rate * step) if step > 0 else np.ones_like(of.rate)
        self._memory = kept * self._memory + share * (penetration - depth)
        self._last = (time, penetration)
        if not self._receding and rate >= 0:
            _, _, _, power, memory = self._loading[-1]
            grown = max(penetration, 0.0) ** 1.5
            memory = kept * memory + share * (grown - power)
            self._loading.append((time, penetration, self._memory, grown, memory))
            change = 1.5 * np.sqrt(max(penetration, 0.0)) * rate
            return self._c * (of.static * grown + of.dashpot * change + of.relaxing @ memory)
        if not self._receding:
            self._receding, self._pointer = True, len(self._loading) - 1
        now = of.static * penetration + of.dashpot * rate + of.relaxing @ self._memory

        def since(k: int) -> float:
            """E* applied to the history of the penetration since the k-th time of loading."""
            then, depth, memory, _, _ = self._loading[k]
            return now - of.static * depth - (of.relaxing * np.exp(-of.rate * (time - then))) @ memory

        while self._pointer > 0 and since(self._pointer) < 0:
            self._pointer -= 1
        low = since(self._pointer)
        if self._pointer == 0 and low <= 0:
            return 0.0
        high_index = min(self._pointer + 1, len(self._loading) - 1)
        high = since(high_index)
        part = low / (low - high) if low > high else 0.0
        a, b = self._loading[self._pointer], self._loading[high_index]
        then, _, _, power, memory = (x + min(part, 1.0) * (y - x) for x, y in zip(a, b))
        return self._c * (of.static * power + (of.relaxing * np.exp(-of.rate * (time - then))) @ memory)


class Rebound(NamedTuple):
    """Of a central impact: rebound speed over impact speed, duration, and (time, penetration, rate, force) on the way."""

    restitution: float
    duration: float
    path: np.ndarray


def impact(relaxation: Relaxation, coefficient: float, mass: float, speed: float, steps: int) -> Rebound:
    """Of effective mass `mass`, by velocity Verlet with `steps` steps in the time depth/speed of the elastic impact."""
    stiffness = coefficient * relaxation.static
    step = (5 * mass * speed**2 / (4 * stiffness)) ** 0.4 / speed / steps
    contact = Contact(relaxation, coefficient)
    time, depth, rate, force = 0.0, 0.0, speed, 0.0
    path = []
    for _ in range(100 * steps):
        half = rate - 0.5 * step * force / mass
        time += step
        depth += step * half
        # The force depends on the rate: of the end of the step, in two turns.
        ahead = half - 0.5 * step * force / mass
        force_now = _peek(contact, time, depth, ahead)
        force = contact.force(time, depth, half - 0.5 * step * force_now / mass)
        rate = half - 0.5 * step * force / mass
        path.append((time, depth, rate, force))
        if rate < 0 and force <= 0:
            return Rebound(-rate / speed, time, np.array(path))
    raise RuntimeError("the impact does not end")


def _peek(contact: Contact, time: float, depth: float, rate: float) -> float:
    """The force that `force` would give, without its step taken."""
    kept = (contact._memory, contact._last, contact._receding, contact._pointer, len(contact._loading))
    found = contact.force(time, depth, rate)
    contact._memory, contact._last, contact._receding, contact._pointer = kept[:4]
    del contact._loading[kept[4] :]
    return found


def by_boundary_elements(
    solid: Solid, curvatures: Tuple[float, float], half_widths: Tuple[float, float], count: int, penetrations: np.ndarray, step: float
) -> np.ndarray:
    """Forces on a rigid paraboloid x^2 A + y^2 B pressed into the half-space along a history of penetrations: boundary elements
    marching in time. Neither Lee and Radok's nor Ting's argument enters: the contact is what p >= 0 and gap >= 0 leave.

    1/E*(s) is two terms c/(s + rate); each has its own displacement of the surface, integrated exactly for a load that is constant
    during a step: of first order in the step, without oscillation. Both viscosities must be positive.
    """
    grid = Rectangles(half_widths, count)
    gap = curvatures[0] * grid.x**2 + curvatures[1] * grid.y**2
    above, below = solid.polynomials()
    rates = -np.roots(above).real
    weights = [np.polyval(below, -rate) / np.polyval(np.polyder(above), -rate) for rate in rates]
    kept = np.exp(-rates * step)
    of_new = (1 - kept) / rates * weights
    influence = 1.0 / np.pi  # a half-space of E* = 1 under a pressure: its integral over 1/(pi r)
    parts = np.zeros((2, count, count))
    pressure = np.zeros((count, count))
    field = np.ones((count, count))
    for _ in range(30):
        field = grid.normal(field / np.linalg.norm(field))
    largest = 1.02 * influence * float(np.linalg.norm(field)) * of_new.sum()
    forces = []
    for penetration in penetrations:
        rest = sum(k * part for k, part in zip(kept, parts))
        wanted = penetration - gap - rest
        ahead, momentum = pressure, 1.0
        for _ in range(20_000):
            residual = influence * of_new.sum() * grid.normal(ahead) - wanted
            following = np.maximum(0.0, ahead - residual / largest)
            change = following - pressure
            if np.sum((ahead - following) * change) > 0:
                momentum = 1.0
            moved = float(np.abs(following - ahead).max())
            later = 0.5 * (1 + np.sqrt(1 + 4 * momentum**2))
            ahead = following + (momentum - 1) / later * change
            pressure, momentum = following, later
            if moved <= 1e-6 * float(pressure.max()):
                break
        else:
            raise RuntimeError("the boundary elements did not converge")
        new = influence * grid.normal(pressure)
        parts = np.stack([k * part + w * new for k, part, w in zip(kept, parts, of_new)])
        forces.append(float(pressure.sum() * grid.area))
    return np.array(forces)
