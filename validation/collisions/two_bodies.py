# SPDX-License-Identifier: MIT OR Apache-2.0
"""The collision of two free bodies of finite elements, with Coulomb friction.

The rigid motions in the plane y = 0 are exact, with the true surfaces of the ellipsoids where they are now; the elastic displacement is linear,
about the shape at first touch. Vibrations, and where the bodies are, take explicit steps (leapfrog). The flexibility without inertia is solved for in
each step, under the inequalities alone: no node is below the other body's surface, no node pulls, and shear is at most mu times the normal
force and opposes slip. No penalty.

Kelvin-Voigt viscosity with both viscosities `relaxation` times their moduli damps a vibration of frequency w at the rate relaxation w^2, and lets the
flexibility follow the force with the delay `relaxation`.
"""
from __future__ import annotations

from typing import Dict, List, NamedTuple, Tuple

import numpy as np
import scipy.linalg

from free_body import FreeBody

# Inversion at the touching point and mirroring at y = 0: what becomes of displacements along x, y and z.
_INVERTED = (-1.0, 1.0, -1.0)


class Impact(NamedTuple):
    """`along` is the speed of the upper body relative to the lower one along x, `normal` that of approach."""

    normal: float
    along: float = 0.0
    friction: float = 0.0
    relaxation: float = 0.0


class Outcome(NamedTuple):
    """Relative velocity of the centres and sum of the spins about y after the collision, and energies, for the whole bodies."""

    #: Columns: time, force along x and z on the upper body, normal force, and the number of nodes in contact.
    path: np.ndarray
    #: Of the upper body relative to the lower one: along x, and along z.
    velocity: Tuple[float, float]
    #: Of the lower and the upper body.
    spins: Tuple[float, float]
    duration: float
    #: In the motion before, in the rigid motion after, in vibration after, lost to friction and viscosity, and what does not add up.
    energies: Dict[str, float]
    #: Largest rotation of a body during contact.
    rotation: float


class _Rigid:
    """Of one body, in the plane y = 0. `side` is -1 for the lower one, whose top touches."""

    def __init__(self, body: FreeBody, shape: np.ndarray, side: float) -> None:
        self.side = side
        # Of half the ellipsoid itself, not of its mesh.
        self.mass = 2.0 / 3.0 * np.pi * float(np.sqrt(np.linalg.det(shape)))
        self.moment = self.mass / 5.0 * float(shape[0, 0] + shape[2, 2])
        self.place = np.array([body.centre[0], body.centre[2]]) * -side
        self.angle, self.velocity, self.spin = 0.0, np.zeros(2), 0.0
        self._shape = shape

    def surface(self, x: np.ndarray, y: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Height of the surface that looks to the other body, and its slope along x."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        turn = np.array([[c, s], [-s, c]])
        form = np.linalg.inv(turn @ self._shape[np.ix_([0, 2], [0, 2])] @ turn.T)
        x = x - self.place[0]
        rest = form[0, 0] * x * x + y * y / self._shape[1, 1] - 1.0
        root = np.sqrt((form[0, 1] * x) ** 2 - form[1, 1] * rest)
        slope = (-form[0, 1] - self.side * (form[0, 1] ** 2 - form[1, 1] * form[0, 0]) * x / root) / form[1, 1]
        return self.place[1] + (-form[0, 1] * x - self.side * root) / form[1, 1], slope

    def drift(self, step: float) -> None:
        self.place = self.place + step * self.velocity
        self.angle += step * self.spin

    def kick(self, step: float, force: np.ndarray, torque: float) -> None:
        self.velocity = self.velocity + step * force / self.mass
        self.spin += step * torque / self.moment

    def curvature(self) -> float:
        """Along x where the bodies touch first."""
        shape = self._shape
        return 1.0 / (shape[0, 0] / np.sqrt(shape[2, 2]) - shape[0, 2] ** 2 / shape[2, 2] ** 1.5)


def _energy(rigid: List[_Rigid]) -> float:
    """Of the rigid motion of both whole bodies, beside that of their centre of mass."""
    total = sum(body.mass for body in rigid)
    mean = sum(body.mass * body.velocity for body in rigid) / total
    return sum(body.mass * float((body.velocity - mean) @ (body.velocity - mean)) + body.moment * body.spin**2 for body in rigid)


class Pair:
    """Two bodies that touch at the origin with the normal along z: `lower` as it is, `upper` inverted at the origin."""

    def __init__(self, lower: FreeBody, upper: FreeBody, shapes: Tuple[np.ndarray, np.ndarray]) -> None:
        self._bodies, self._shapes = (lower, upper), shapes
        count = len(lower.places)
        mirrored = np.arange(count).reshape(-1, lower.row)[:, ::-1].ravel()
        if np.abs(upper.places[mirrored] * [-1, 1] - lower.places).max() > 1e-9:
            raise ValueError("the nodes of the two bodies do not lie on one another")
        whole = np.concatenate([mirrored + axis * count for axis in range(3)])
        sign = np.repeat(_INVERTED, count)
        self._x, self._y = lower.places.T
        #: Of the relative displacement, upper less lower, to the force on the upper body.
        self.flexibility = lower.flexibility + (sign[:, None] * upper.flexibility[np.ix_(whole, whole)]) * sign
        self._modes = np.hstack([-lower.shapes, sign[:, None] * upper.shapes[whole]])
        self._squares = np.concatenate([lower.frequencies, upper.frequencies]) ** 2
        self._count = count
        edge = (np.abs(self._x) > np.abs(self._x).max() - 1e-9) | (self._y > self._y.max() - 1e-9)
        self._edge = edge
        self.unknowns = lower.unknowns + upper.unknowns

    def pressed(self, overlap: float) -> float:
        """Normal force without friction at rest, inertia and all vibrations in balance with it; `overlap` is that of the rigid surfaces."""
        whole = self.flexibility + (self._modes / self._squares) @ self._modes.T
        lower, upper = (_Rigid(body, shape, side) for body, shape, side in zip(self._bodies, self._shapes, (-1.0, 1.0)))
        gap = upper.surface(self._x, self._y)[0] - lower.surface(self._x, self._y)[0] - overlap
        force, _ = Contact(whole, self._count, 0.0, self._y < 1e-12).solve(gap, np.zeros(2 * self._count), np.zeros(3 * self._count))
        return 2 * float(force[2 * self._count :].sum())

    def collide(self, impact: Impact, duration: float, steps: int) -> Outcome:
        """`steps` in `duration`, which is about that of the contact."""
        step, count = duration / steps, self._count
        rigid = [_Rigid(body, shape, side) for body, shape, side in zip(self._bodies, self._shapes, (-1.0, 1.0))]
        # The frame in which the touching point rests while the bodies slide along one another.
        lower, upper = (body.curvature() for body in rigid)
        for body, share in zip(rigid, (-upper / (lower + upper), lower / (lower + upper))):
            body.velocity = np.array([share * impact.along, -0.5 * body.side * impact.normal])
        before = _energy(rigid)
        # The flexibility follows the force by backward Euler, whose lag is the delay.
        delay = impact.relaxation
        kept = delay / (delay + step)
        contact = Contact((1 - kept) * self.flexibility, count, impact.friction, self._y < 1e-12)
        damping = 0.5 * step * delay * self._squares
        amplitude, rate = np.zeros_like(self._squares), np.zeros_like(self._squares)
        force, held = np.zeros(3 * count), np.zeros(3 * count)
        slipped = viscous = rotation = 0.0
        rows, last, first = [], None, 0.0
        height, along, up = np.zeros(count), np.zeros(count), np.zeros(count)
        for number in range(1, 20 * steps):
            # Forces of the step at its beginning, then the way to its end.
            for body in rigid:
                torque = float((height - body.place[1]) @ along - (self._x - body.place[0]) @ up)
                body.kick(step if number > 1 else 0.5 * step, body.side * np.array([along.sum(), up.sum()]), body.side * torque)
            old_rate = rate
            rate = ((1 - damping) * rate + step * (self._modes.T @ force - self._squares * amplitude)) / (1 + damping)
            viscous += 2 * step * delay * float(self._squares @ (0.5 * (rate + old_rate)) ** 2)
            for body in rigid:
                body.drift(step)
            amplitude = amplitude + step * rate
            vibration = self._modes @ amplitude
            (lower, lower_slope), (upper, upper_slope) = (body.surface(self._x, self._y) for body in rigid)
            # The surfaces in contact lie on one another, between those of the ellipsoids: this is how their normal turns.
            height, slope = 0.5 * (lower + upper), 0.5 * (lower_slope + upper_slope)
            bent = self.flexibility @ held
            gap = upper - lower + vibration[2 * count :] + kept * bent[2 * count :]
            slip = step * (self._modes @ rate) - (1 - kept) * bent
            for body in rigid:
                sideways = body.velocity[0] + body.spin * (height - body.place[1])
                upwards = body.velocity[1] - body.spin * (self._x - body.place[0])
                slip[:count] += body.side * step * (sideways + slope * upwards) / np.hypot(1.0, slope)
            before_it = held
            force, done = contact.solve(gap, slip[: 2 * count], force)
            held = kept * held + (1 - kept) * force
            along, up = force[:count] - slope * force[2 * count :], slope * force[:count] + force[2 * count :]
            along, up = along / np.hypot(1.0, slope), up / np.hypot(1.0, slope)
            slipped -= 2 * float(force[: 2 * count] @ done)
            if delay > 0:
                change = held - before_it
                viscous += 2 * delay / step * float(change @ (self.flexibility @ change))
            if force[2 * count :][self._edge].any():
                raise RuntimeError("the contact is wider than the nodes that may touch")
            time = number * step
            normal = force[2 * count :]
            total = float(normal.sum())
            touching = int((normal > 0).sum())
            rows.append((time, 2 * float(along.sum()), 2 * float(up.sum()), 2 * total, touching))
            if touching:
                if last is None:
                    first = time - step
                last = time
                rotation = max(rotation, *(abs(body.angle) for body in rigid))
            elif last is not None and time - last > 0.4 * duration and (delay == 0 or time - last > 5 * delay or time - last > duration):
                break
        else:
            raise RuntimeError("the collision does not end")
        after = _energy(rigid)
        whole_rate = rate + 0.5 * step * (-self._squares * amplitude)
        vibrating = float(whole_rate @ whole_rate + self._squares @ amplitude**2)
        stored = float(held @ (self.flexibility @ held))
        relative = rigid[1].velocity - rigid[0].velocity
        return Outcome(
            path=np.array(rows),
            velocity=(float(relative[0]), float(relative[1])),
            spins=(rigid[0].spin, rigid[1].spin),
            duration=float(last - first),
            energies={
                "before": before,
                "after": after,
                "vibration": vibrating + stored,
                "friction": slipped,
                "viscosity": viscous,
                "rest": before - after - vibrating - stored - slipped - viscous,
            },
            rotation=rotation,
        )


class Contact:
    """The forces of a step: who touches, and who slips."""

    def __init__(self, flexibility: np.ndarray, count: int, friction: float, on_plane: np.ndarray) -> None:
        self._count, self._friction = count, friction
        self._normal = flexibility[2 * count :, 2 * count :]
        self._shear = flexibility[: 2 * count, : 2 * count]
        self._cross = flexibility[2 * count :, : 2 * count]
        self._on_plane = on_plane
        self._touching = np.zeros(count, dtype=bool)
        self._factor = None
        self._largest = 0.0
        if friction > 0:
            start = np.ones(2 * count)
            for _ in range(50):
                start = self._shear @ (start / np.linalg.norm(start))
            self._largest = 1.05 * float(np.linalg.norm(start))
        self._chosen: np.ndarray = np.zeros(0, dtype=int)
        self._small = np.zeros((0, 0))

    def solve(self, gap: np.ndarray, slip: np.ndarray, before: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Forces on the upper body at the end of the step, and the slip in it; `gap` and `slip` are those without them."""
        count = self._count
        shear = before[: 2 * count]
        for _ in range(3 if self._friction > 0 else 1):
            normal = self._press(gap + (self._cross @ shear if self._friction > 0 else 0.0))
            if self._friction == 0:
                break
            following = self._rub(slip + self._cross.T @ normal, normal, shear)
            changed = np.abs(following - shear).max()
            shear = following
            if changed <= 1e-4 * self._friction * normal.max() + 1e-300:
                break
        if self._friction == 0:
            shear = np.zeros(2 * count)
        done = slip + self._shear @ shear + self._cross.T @ normal
        return np.concatenate([shear, normal]), done

    def _press(self, gap: np.ndarray) -> np.ndarray:
        """normal >= 0, gap + flexibility normal >= 0, one of both 0 at each node."""
        touching = self._touching
        normal = np.zeros_like(gap)
        for _ in range(100):
            normal = np.zeros_like(gap)
            if touching.any():
                if self._factor is None or not np.array_equal(touching, self._touching):
                    self._factor = scipy.linalg.cho_factor(self._normal[np.ix_(touching, touching)], check_finite=False)
                    self._touching = touching
                normal[touching] = scipy.linalg.cho_solve(self._factor, -gap[touching], check_finite=False)
            else:
                self._touching, self._factor = touching, None
            open_gap = gap + self._normal[:, touching] @ normal[touching]
            wanted = np.where(touching, normal > 0, open_gap < 0)
            if np.array_equal(wanted, touching):
                return normal
            touching = wanted
        raise RuntimeError("which nodes touch was not found")

    def _rub(self, slip: np.ndarray, normal: np.ndarray, shear: np.ndarray) -> np.ndarray:
        """Coulomb's law by accelerated projected gradients: slip + flexibility shear is against the shear where |shear| = mu normal, else 0."""
        count = self._count
        touching = np.flatnonzero(normal > 0)
        found = np.zeros_like(shear)
        if not len(touching):
            return found
        chosen = np.concatenate([touching, touching + count])
        if not np.array_equal(chosen, self._chosen):
            self._chosen, self._small = chosen, np.ascontiguousarray(self._shear[np.ix_(chosen, chosen)])
        limit = self._friction * normal[touching]
        half, free = len(touching), ~self._on_plane[touching]
        now = shear[chosen]
        ahead, momentum = now, 1.0
        for _ in range(2000):
            trial = ahead - (slip[chosen] + self._small @ ahead) / self._largest
            trial[half:] *= free
            size = np.hypot(trial[:half], trial[half:])
            ratio = np.minimum(1.0, limit / np.maximum(size, 1e-300))
            following = trial * np.concatenate([ratio, ratio])
            if (ahead - following) @ (following - now) > 0:
                momentum = 1.0
            later = 0.5 * (1 + np.sqrt(1 + 4 * momentum**2))
            moved = np.abs(following - ahead).max()
            ahead = following + (momentum - 1) / later * (following - now)
            now, momentum = following, later
            if moved <= 1e-5 * limit.max():
                break
        found[chosen] = now
        return found
