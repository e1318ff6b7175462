# SPDX-License-Identifier: MIT OR Apache-2.0
"""Twisting about the normal: closed forms, and `twisting marshall` held against boundary elements with friction.

**Without slip.** The Fourier transform of the displacement of two half-spaces under equal and opposite shear tractions q is
(2/(G k)) (q - nu k^ (k^.q)), with k^ the unit vector along k. Tractions (-alpha y/b^2, beta x/a^2)/w, w^2 = 1 - x^2/a^2 - y^2/b^2, displace the
ellipse linearly. Theirs is (-alpha k_y, beta k_x) 2 pi a b j_1(kappa)/kappa but for a factor i, with kappa^2 = a^2 k_x^2 + b^2 k_y^2. The
integral of j_1^2 is pi/6, and with s(phi) = kappa/k the elastic energy and the torque are

    W = (pi a^2 b^2/(6 G)) [alpha^2 J_y + beta^2 J_x - nu (alpha - beta)^2 J_xy] ,    T = (2 pi a b/3) (alpha + beta)

where J_x, J_y, J_xy are the integrals of cos^2, sin^2, sin^2 cos^2 over s^3, all around. What is left of alpha and beta by dW = theta dT is the
rotation of a rigid surface. In Jahnke's and Emde's D, B, C of the modulus k^2 = 1 - b^2/a^2 (J_x = 4 D/a^3, J_y = 4 B/(a b^2), J_xy = 4 C/a^3),
the stiffness is Mindlin's (J. Appl. Mech. 16 (1949) 259), 8/3 G a^3 on the circle (Reissner and Sagoci 1944).

**At full sliding** each point's traction is mu p across its way to the centre: T = mu times the integral of p r, 3/32 of the circumference
times mu F_n with Hertz' pressure, 3 pi/16 a mu F_n on the circle.

**Partial slip on the circle** (Lubkin, J. Appl. Mech. 18 (1951) 183). The tractions are those of rigid discs of all radii s that are turned by psi'(s) ds
(Jaeger, Arch. Appl. Mech. 65 (1995) 478), (2 G r/pi) times the integral of psi'(s)/sqrt(s^2 - r^2) from r on. Outside the circle of radius c that
sticks it is mu p; Abel's equation gives psi' = -(mu/G) I', I(s) = p_0 (K - E) of the modulus kappa^2 = 1 - s^2/a^2. So

    theta = (mu/G) I(c) ,    T = (8/3) mu [c^3 I(c) + 3 integral of s^2 I(s) from c to a] .

Every way back at steady normal force is twice that curve at half the angle (Masing; Deresiewicz, J. Appl. Mech. 21 (1954) 52). Whole sliding needs an
infinite angle, since the pressure at the centre does not vanish.

Units: angle T_s/k and torque T_s, of the exact torque of sliding T_s and stiffness k.
"""
from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
from scipy.special import ellipe, ellipk, ellipkm1

from friction import Ellipse, Friction, loads_along
from grains import COEFFICIENT, OVERLAP, Grains, Grid, Scene, through
from half_space_kernels import Rectangles, Shear


class Linear(NamedTuple):
    """Tractions (-alpha y/b^2, beta x/a^2)/w per angle that turn the ellipse as a rigid surface, and torque over angle."""

    alpha: float
    beta: float
    stiffness: float


def without_slip(semi_axes: Tuple[float, float], shear_modulus: float, poisson: float) -> Linear:
    """Of two equal half-spaces, a >= b."""
    a, b = semi_axes
    square = 1.0 - (b / a) ** 2
    if square < 1e-8:
        along, across, both = np.pi / 4, np.pi / 4, np.pi / 16
    else:
        first, second = float(ellipk(square)), float(ellipe(square))
        along = (first - second) / square
        across = first - along
        both = (along - across) / square
        across *= (a / b) ** 2
    j_x, j_y, j_xy = (4.0 / a**3 * of for of in (along, across, both))
    shared = 2.0 * shear_modulus / (a * b) / (j_x * j_y - poisson * j_xy * (j_x + j_y))
    alpha, beta = shared * (j_x - 2.0 * poisson * j_xy), shared * (j_y - 2.0 * poisson * j_xy)
    return Linear(alpha, beta, 2.0 * np.pi * a * b / 3.0 * (alpha + beta))


def in_the_words_of_the_law(
    squares: np.ndarray, beta: np.ndarray, normal_stiffness: float, kappa_0: float, kappa_1: float
) -> float:
    """The same stiffness in what the law has (docs/theory.md, sections 4 and 5.1), of two materials: S with the eigenvalues a^2 and b^2, beta with
    those B/K and D/K along the same axes, 2 x 2 matrices in any tangent basis. No eigenvector is needed."""
    identity = np.eye(2)
    deviator, other = (of - 0.5 * np.trace(of) * identity for of in (squares, beta))
    size = float(np.sum(deviator**2))
    area = float(np.linalg.det(squares))
    # det S (D/K - B/K)/(a^2 - b^2), which is a^2/8 on the circle.
    slope = -area * float(np.sum(deviator * other)) / size if size > 1e-12 * area else area**0.5 / 8.0
    both = float(np.trace(squares @ beta))
    nu = kappa_1 / kappa_0
    return normal_stiffness / (3.0 * kappa_0) * area * (both - 4.0 * nu * slope) / (area * float(np.linalg.det(beta)) - nu * slope * both)


def sliding_torque(contact: Ellipse, coefficient: float) -> float:
    """Of a contact of Hertz that slides everywhere about its centre."""
    a, b = contact.semi_axes
    circumference = 4.0 * a * float(ellipe(1.0 - (b / a) ** 2))
    return 3.0 / 32.0 * circumference * coefficient * contact.force


def lubkin(angles: np.ndarray) -> np.ndarray:
    """Torque of first loading on the circle in units of that of sliding, at angles >= 0 in units of its ratio to the stiffness."""
    # By the radius c that sticks, with a = 1: fine near the rim, where loading begins, and near the centre, where it ends.
    turn = np.linspace(0.0, np.pi, 4001)
    radius = 0.5 * (1.0 + np.cos(turn))
    radius[-1] = 1e-12
    square = 1.0 - radius**2
    profile = ellipkm1(radius**2) - ellipe(square)
    steps = 0.5 * (radius[1:] ** 2 * profile[1:] + radius[:-1] ** 2 * profile[:-1]) * (radius[:-1] - radius[1:])
    torque = radius**3 * profile + 3.0 * np.concatenate([[0.0], np.cumsum(steps)])
    # Of sliding: 3 times the integral of s^2 (K - E) from 0 to 1, which is 3 pi^2/64.
    return np.interp(angles, profile / (3.0 * np.pi**2 / 64.0), torque / (3.0 * np.pi**2 / 64.0))


def masing(angles: np.ndarray, steps: int) -> np.ndarray:
    """Torque along lines of so many steps from 0 to an angle, to its opposite, and back, by the curve of first loading on the circle."""
    first, there, back = angles[: steps + 1], angles[steps + 1 : 2 * steps + 1], angles[2 * steps + 1 :]
    reached = lubkin(first[-1:])
    return np.concatenate(
        [lubkin(first), reached - 2.0 * lubkin((first[-1] - there) / 2.0), -reached + 2.0 * lubkin((back - there[-1]) / 2.0)]
    )


def spring_and_slider(angles: np.ndarray) -> np.ndarray:
    """Torque of a spring and slider of stiffness and limit 1 along a path."""
    torque, last, found = 0.0, 0.0, []
    for angle in angles:
        torque = min(1.0, max(-1.0, torque + angle - last))
        last = angle
        found.append(torque)
    return np.array(found)


def bed_with_one_limit(path: np.ndarray, count: int = 8, finer: int = 8) -> np.ndarray:
    """Force and torque in their units along a path (displacement, angle) of a bed of springs as of `displacement hysteretic`, each with a force, a
    torque and one limit: (f/f_max)^2 + (t/t_max)^2 <= 1, to which both are reduced in proportion. No law of the library.

    Lubkin's torque is the integral of 8 G s^2 min(theta, (mu/G) I(s)) over the discs, Cattaneo's and Mindlin's force that of 4 G/(2 - nu)
    min(xi, xi_max (1 - s^2)), s in units of the radius: the spring of the disc s has both. A reduction takes energy from both, so that no cycle gives
    work."""
    edges = (np.arange(count + 1) / count) ** (2.0 / 3.0)
    inner, outer = edges[:-1], edges[1:]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    disc = inner[:, None] + np.outer(outer - inner, 0.5 * (nodes + 1.0))
    share = np.outer(outer - inner, 0.5 * weights)
    yields = (ellipkm1(disc**2) - ellipe(1.0 - disc**2)) / (3.0 * np.pi**2 / 64.0)
    stiffness = np.stack([np.sum(1.5 * share, axis=1), np.sum(3.0 * disc**2 * share, axis=1)])
    limits = np.stack([np.sum(1.5 * (1.0 - disc**2) * share, axis=1), np.sum(3.0 * disc**2 * yields * share, axis=1)])
    loads, found = np.zeros_like(stiffness), []
    last = path[0]
    for point in path:
        for _ in range(finer):
            loads = loads + stiffness * ((point - last) / finer)[:, None]
            loads = loads / np.maximum(1.0, np.hypot(*(loads / limits)))
        found.append(loads.sum(axis=1))
        last = point
    return np.array(found)


def stiffness_by_elements(semi_axes: Tuple[float, float], shear_modulus: float, poisson: float, count: int) -> float:
    """Torque over angle without slip, by conjugate gradients on the rectangles whose middle lies in the ellipse."""
    a, b = semi_axes
    rectangles = Rectangles((a, b), count)
    shear = Shear(rectangles, shear_modulus, poisson)
    x, y = np.broadcast_arrays(rectangles.x, rectangles.y)
    within = (x / a) ** 2 + (y / b) ** 2 < 1.0
    wanted = np.stack([-y, x]) * within
    traction, left = np.zeros_like(wanted), wanted
    way, size = left, float(np.sum(left**2))
    target = 1e-16 * size
    while size > target:
        meets = shear(way) * within
        step = size / float(np.sum(way * meets))
        traction, left = traction + step * way, left - step * meets
        before, size = size, float(np.sum(left**2))
        way = left + size / before * way
    return float(np.sum(traction * wanted)) * rectangles.area


def sliding_together(semi_axes: Tuple[float, float], direction: float, centre: float) -> Tuple[float, float]:
    """Force and torque in units of mu F_n and of the torque of sliding, of a contact that slides everywhere about an instantaneous centre, at
    `centre` times the major semi-axis from its middle, across the direction (degrees) in which the middle moves. With Hertz' pressure."""
    a, b = semi_axes
    nodes, weights = np.polynomial.legendre.leggauss(200)
    # r = sin: the pressure's root is smooth then. p r dr = cos^2 sin.
    turn = 0.25 * np.pi * (nodes + 1.0)
    radius = np.sin(turn)[:, None]
    around = np.linspace(0.0, 2.0 * np.pi, 401)[None, :-1]
    share = (0.25 * np.pi * weights * np.cos(turn) ** 2 * np.sin(turn))[:, None] * np.full(around.shape, 1.0 / around.size) * 3.0
    x, y = a * radius * np.cos(around), b * radius * np.sin(around)
    angle = np.radians(direction)
    # Velocity across the way to the centre: the middle moves along the direction.
    to_x, to_y = x - centre * a * np.sin(angle), y + centre * a * np.cos(angle)
    length = np.hypot(to_x, to_y)
    along_x, along_y = -to_y / length, to_x / length
    force = np.hypot(np.sum(share * along_x), np.sum(share * along_y))
    torque = np.sum(share * (x * along_y - y * along_x))
    return float(force), float(torque) / sliding_torque(Ellipse((a, b), 1.0), 1.0)


TWISTED = tuple(Scene(aspect, poisson, 0.0) for aspect in (1.0, 2.0, 5.0) for poisson in (0.0, 0.3))
BOTH = (Scene(1.0, 0.3, 0.0), Scene(2.0, 0.3, 45.0), Scene(5.0, 0.3, 90.0))
AMPLITUDES = (0.4, 1.0, 3.0, 6.0)


def twists(steps: int) -> Dict[str, Tuple[np.ndarray, int]]:
    """Displacement along the scene's direction, in units of that at which the contact slides as a whole, and the angle; and where the path is closed."""
    return {
        f"reversed at {largest:g}": (through([(0, 0), (0, largest), (0, -largest), (0, largest)], steps), steps) for largest in AMPLITUDES
    }


def both(steps: int) -> Dict[str, Tuple[np.ndarray, int]]:
    """The same; -1 where the path does not close."""
    return {
        "twisted, then displaced": (through([(0, 0), (0, 1.5), (1.5, 1.5)], steps), -1),
        "displaced, then twisted": (through([(0, 0), (0.6, 0), (0.6, 3)], steps), -1),
        "slid, then twisted": (through([(0, 0), (1.2, 0), (1.2, 3)], steps), -1),
        "both at once, reversed": (through([(0, 0), (1.5, 3), (-1.5, -3), (1.5, 3)], steps), steps),
    }


class Turned:
    """A path of a scene (overlap, x, y, angle) at steady normal force, and the units of its loads."""

    def __init__(self, scene: Scene, relative: np.ndarray) -> None:
        self.grains = Grains(scene, "rescaled")
        self._poisson = scene.poisson
        self.contact = self.grains.ellipse(OVERLAP)
        self.stiffness = without_slip(self.contact.semi_axes, self.grains.shear_modulus, scene.poisson).stiffness
        limit = sliding_torque(self.contact, COEFFICIENT)
        self.units = np.array([COEFFICIENT * self.contact.force] * 2 + [limit])
        self.angle = limit / self.stiffness
        direction = np.array([np.cos(np.radians(scene.direction)), np.sin(np.radians(scene.direction))])
        self.sliding = self.grains.sliding_displacement(direction)
        places = self.sliding * relative[:, :1] * direction
        self.points = np.concatenate([np.full((len(relative), 1), OVERLAP), places, self.angle * relative[:, 1:]], axis=1)

    def full_problem(self, count: int) -> np.ndarray:
        """Loads by boundary elements in their units; the ellipse ends between the same two rectangles on each grid."""
        major, minor = (axis * count / (count - 2) for axis in self.contact.semi_axes)
        friction = Friction((major, minor), count, self.grains.shear_modulus, self._poisson, COEFFICIENT)
        return loads_along(((self.contact, point[1:3], point[3]) for point in self.points), friction) / self.units

    def by_law(self, finer: int) -> np.ndarray:
        return self.grains.loads_along(self.points, finer) / self.units

    def dissipated(self, loads: np.ndarray, first: int) -> float:
        """Work done against the loads over the closed part, in units of half of the loads of sliding times the largest motion, which springs
        would hold."""
        work = -np.sum(0.5 * (loads[first + 1 :] + loads[first:-1]) * np.diff(self.points[first:, 1:], axis=0) * self.units)
        largest = np.array([np.hypot(*self.points[:, 1:3].T).max(), self.points[:, 3].max()])
        return round(float(work / (0.5 * np.sum(largest * self.units[1:]))), 12) + 0.0


def constants_of_the_law(scene: Scene) -> Tuple[float, float]:
    """Stiffness and limit of the law over the exact ones."""
    _, small, large = -Turned(scene, np.array([[0.0, 0.0], [0.0, 1e-3], [0.0, 1e3]])).by_law(1)[:, 2]
    return float(small) / 1e-3, float(large)


def constants(scene: Scene) -> Dict[str, Any]:
    """Those, and the stiffness by boundary elements over the exact one, extrapolated to rectangles of no size with an error that is proportional to
    theirs, and how much this changes from coarser ones."""
    turned = Turned(scene, np.zeros((1, 2)))
    semi_axes = turned.contact.semi_axes
    found = [
        stiffness_by_elements(semi_axes, turned.grains.shear_modulus, scene.poisson, count) / turned.stiffness for count in (96, 192, 384)
    ]
    extrapolated = 2 * found[2] - found[1]
    stiffness, limit = constants_of_the_law(scene)
    return dict(
        aspect=scene.aspect,
        poisson=scene.poisson,
        contact_ratio=semi_axes[0] / semi_axes[1],
        stiffness_by_elements=extrapolated,
        stiffness_bar=abs(extrapolated - (2 * found[1] - found[0])),
        stiffness_by_law=stiffness,
        limit_by_law=limit,
    )


def errors(loads: np.ndarray, full: np.ndarray, steps: int, alone: bool) -> Dict[str, float]:
    """The largest differences along a path; of a twist `alone` that of the torque on the first line too, which loads once."""
    difference = loads - full
    torque = np.abs(difference[:, 2])
    if alone:
        return {"torque_error": float(torque.max()), "first_torque_error": float(torque[: steps + 1].max())}
    return {"torque_error": float(torque.max()), "force_error": float(np.hypot(*difference[:, :2].T).max())}


def compare(
    scene: Scene, name: str, of: Dict[int, Tuple[np.ndarray, int]], coarse: Grid, fine: Grid, finer: int
) -> Tuple[Dict[str, Any], List[Dict[str, Any]]]:
    """One path of one scene: errors of the force in units of mu F_n and of the torque, energies; and the loads. `of` has the path by the steps of
    a line. In a pure twist also a spring and slider of the exact stiffness and limit, and the curve of the circle with Masing's rule, in these units."""
    (rough_path, first), (relative, closed) = of[coarse.steps], of[fine.steps]
    rough, turned = Turned(scene, rough_path), Turned(scene, relative)
    before, full = rough.full_problem(coarse.count), turned.full_problem(fine.count)
    law = turned.by_law(finer)
    row: Dict[str, Any] = dict(scene._asdict(), path=name, **errors(law, full, fine.steps, alone=not relative[:, 0].any()))
    row.update({f"{key.replace('_error', '')}_bar": value for key, value in errors(full[::2], before, coarse.steps, alone=not relative[:, 0].any()).items()})
    if closed >= 0:
        row["dissipated"] = turned.dissipated(full, closed)
        row["dissipated_bar"] = abs(row["dissipated"] - rough.dissipated(before, first))
        row["dissipated_by_law"] = turned.dissipated(law, closed)
    else:
        row.update(dissipated="", dissipated_bar="", dissipated_by_law="")
    if not relative[:, 0].any():
        for key, torque in (("slider", spring_and_slider(relative[:, 1])), ("circle", masing(relative[:, 1], fine.steps))):
            other = np.concatenate([np.zeros((len(torque), 2)), -torque[:, None]], axis=1)
            found = errors(other, full, fine.steps, alone=True)
            row[f"torque_error_of_{key}"] = found["torque_error"]
            row[f"first_torque_error_of_{key}"] = found["first_torque_error"]
            row[f"dissipated_by_{key}"] = turned.dissipated(other, closed)
    curves = [
        dict(scene._asdict(), path=name, point=k, displacement=place, angle=angle)
        for k, (place, angle) in enumerate(relative)
    ]
    for of_which, loads in (("full", full), ("law", law)):
        for letter, column in zip(("x", "y", "torque"), loads.T):
            for curve, value in zip(curves, column):
                # What is nothing but rounding is nothing.
                curve[f"{of_which}_{letter}"] = round(float(value), 12) + 0.0
    return row, curves
