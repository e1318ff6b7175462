# SPDX-License-Identifier: MIT OR Apache-2.0
"""Twisting about the normal: closed forms, and `twisting marshall` and `lubkin` held against boundary elements with friction.

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

**The grid of `lubkin`.** The elements of a contact have edges that are fixed when it first touches; as it grows they are merged in pairs, so that four
to eight of them carry. All eight do where the overlap is that of first touch, and how many and which in a contact that grew to it goes by the part of
it at which it touched: anew with every 2^(4/3).
"""
from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
from scipy.special import ellipe, ellipk

import torque_of_discs
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
    radius = 0.5 * (1.0 + np.cos(np.linspace(0.0, np.pi, 4001)))
    radius[-1] = 1e-12
    # The discs up to c are turned by the angle, and those outside slide.
    turned = torque_of_discs.disc(radius) / (3.0 * np.pi**2 / 64.0)
    return np.interp(angles, turned, radius**3 * turned + 1.0 - torque_of_discs.share(radius))


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
# The laws about the normal, each with that of the force beside it.
LAWS = {"marshall": "rescaled", "lubkin": "hysteretic"}
# Parts of the overlap at which a contact touched, before it grew: eight phases of the grid, evenly apart.
TOUCHED = tuple(float(2.0 ** (-k / 6.0)) for k in range(8))


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
        self._scene = scene
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
        friction = Friction((major, minor), count, self.grains.shear_modulus, self._scene.poisson, COEFFICIENT)
        return loads_along(((self.contact, point[1:3], point[3]) for point in self.points), friction) / self.units

    def by_law(self, law: str, finer: int, touched: float = 1.0) -> np.ndarray:
        return Grains(self._scene, LAWS[law], law).loads_along(self.points, finer, touched) / self.units

    def dissipated(self, loads: np.ndarray, first: int) -> float:
        """Work done against the loads over the closed part, in units of half of the loads of sliding times the largest motion, which springs
        would hold."""
        work = -np.sum(0.5 * (loads[first + 1 :] + loads[first:-1]) * np.diff(self.points[first:, 1:], axis=0) * self.units)
        largest = np.array([np.hypot(*self.points[:, 1:3].T).max(), self.points[:, 3].max()])
        return round(float(work / (0.5 * np.sum(largest * self.units[1:]))), 12) + 0.0


def constants_of_the_law(scene: Scene, law: str) -> Tuple[float, float]:
    """Its stiffness and limit over the exact ones."""
    _, small, large = -Turned(scene, np.array([[0.0, 0.0], [0.0, 1e-3], [0.0, 1e3]])).by_law(law, 1)[:, 2]
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
    row: Dict[str, Any] = dict(
        aspect=scene.aspect,
        poisson=scene.poisson,
        contact_ratio=semi_axes[0] / semi_axes[1],
        stiffness_by_elements=extrapolated,
        stiffness_bar=abs(extrapolated - (2 * found[1] - found[0])),
    )
    for law in LAWS:
        row[f"stiffness_of_{law}"], row[f"limit_of_{law}"] = constants_of_the_law(scene, law)
    return row


def errors(loads: np.ndarray, full: np.ndarray, steps: int, alone: bool) -> Dict[str, float]:
    """The largest differences along a path; of a twist `alone` that of the torque on the first line too, which loads once."""
    difference = loads - full
    torque = np.abs(difference[:, 2])
    if alone:
        return {"torque_error": float(torque.max()), "first_torque_error": float(torque[: steps + 1].max())}
    return {"torque_error": float(torque.max()), "force_error": float(np.hypot(*difference[:, :2].T).max())}


def errors_of_the_law(
    turned: Turned, law: str, full: np.ndarray, finer: int, steps: int, alone: bool, closed: int
) -> Tuple[Dict[str, Any], np.ndarray]:
    """Errors of a law of the library and what it dissipates where the path closes, and its loads. Of `lubkin` where all elements carry; and the
    largest errors, and the least and the most that it dissipates, over the phases of its grid."""
    phases = [turned.by_law(law, finer, touched) for touched in (TOUCHED if law == "lubkin" else TOUCHED[:1])]
    found = [errors(loads, full, steps, alone) for loads in phases]
    lost = [turned.dissipated(loads, closed) if closed >= 0 else "" for loads in phases]
    row: Dict[str, Any] = {f"{key}_of_{law}": value for key, value in found[0].items()}
    row[f"dissipated_by_{law}"] = lost[0]
    if len(phases) > 1:
        row.update({f"worst_{key}_of_{law}": max(of[key] for of in found) for key in found[0]})
        row.update({f"least_dissipated_by_{law}": min(lost), f"most_dissipated_by_{law}": max(lost)})
    return row, phases[0]


def compare(
    scene: Scene, name: str, of: Dict[int, Tuple[np.ndarray, int]], coarse: Grid, fine: Grid, finer: int
) -> Tuple[Dict[str, Any], List[Dict[str, Any]]]:
    """One path of one scene: errors of the force in units of mu F_n and of the torque, energies; and the loads. `of` has the path by the steps of
    a line. In a pure twist also a spring and slider of the exact stiffness and limit, and the curve of the circle with Masing's rule, in these units."""
    (rough_path, first), (relative, closed) = of[coarse.steps], of[fine.steps]
    alone = not relative[:, 0].any()
    rough, turned = Turned(scene, rough_path), Turned(scene, relative)
    before, full = rough.full_problem(coarse.count), turned.full_problem(fine.count)
    row: Dict[str, Any] = dict(scene._asdict(), path=name)
    row.update({f"{key.replace('_error', '')}_bar": value for key, value in errors(full[::2], before, coarse.steps, alone).items()})
    if closed >= 0:
        row["dissipated"] = turned.dissipated(full, closed)
        row["dissipated_bar"] = abs(row["dissipated"] - rough.dissipated(before, first))
    else:
        row.update(dissipated="", dissipated_bar="")
    by_law: Dict[str, np.ndarray] = {}
    for law in LAWS:
        found, by_law[law] = errors_of_the_law(turned, law, full, finer, fine.steps, alone, closed)
        row.update(found)
    if alone:
        for key, torque in (("slider", spring_and_slider(relative[:, 1])), ("circle", masing(relative[:, 1], fine.steps))):
            other = np.concatenate([np.zeros((len(torque), 2)), -torque[:, None]], axis=1)
            row.update({f"{which}_of_{key}": value for which, value in errors(other, full, fine.steps, alone).items()})
            row[f"dissipated_by_{key}"] = turned.dissipated(other, closed)
    curves = [
        dict(scene._asdict(), path=name, point=k, displacement=place, angle=angle)
        for k, (place, angle) in enumerate(relative)
    ]
    for of_which, loads in (("full", full), *by_law.items()):
        for letter, column in zip(("x", "y", "torque"), loads.T):
            for curve, value in zip(curves, column):
                # What is nothing but rounding is nothing.
                curve[f"{of_which}_{letter}"] = round(float(value), 12) + 0.0
    return row, curves
