# SPDX-License-Identifier: MIT OR Apache-2.0
"""A spinning sphere on a rigid plane with Hertz' normal force and Mindlin's tangential spring, both with the dashpot of a given
restitution: a law that many codes have and this library does not. It shows what such a tangential dashpot does to tests 6 and 8."""
from __future__ import annotations

from math import copysign, log, pi, sqrt


def tangential_restitution(slip: float, friction: float, restitution: float, poisson: float, damped: bool, steps: int = 4000) -> float:
    """Of the velocity of the point of contact, reversed. `slip` is 7 mu (1 + e) v_n / (2 v_t).

    Units: mass, radius, and impact speed are 1, and the plane strain modulus is 1e6; only Poisson's ratio has an effect.
    """
    modulus = 1e6
    # Over the plane strain modulus E/(1 - nu^2): 8 G/(2 - nu) against 2 E/(1 - nu^2) makes 2 (1 - nu)/(2 - nu).
    shear = modulus * 2 * (1 - poisson) / (2 - poisson)
    damping = -2 * sqrt(5 / 6) * log(restitution) / sqrt(log(restitution) ** 2 + pi**2)
    step = 3 * (15 / (16 * modulus)) ** 0.4 / steps
    depth, speed = 0.0, 1.0
    point = start = 3.5 * friction * (1 + restitution) / slip
    stretched = 0.0
    # Half a step ahead with the positions: leapfrog.
    depth += 0.5 * step * speed
    while depth > 0:
        normal_stiffness, tangential_stiffness = 2 * modulus * sqrt(depth), 2 * shear * sqrt(depth)
        normal = 4 / 3 * modulus * depth**1.5 + damping * sqrt(normal_stiffness) * speed
        stretched += step * point
        spring = tangential_stiffness * stretched
        dashpot = damping * sqrt(tangential_stiffness) * point if damped else 0.0
        limit = friction * max(normal, 0.0)
        if abs(spring) > limit:
            spring, dashpot = copysign(limit, spring), 0.0
            stretched = spring / tangential_stiffness
        force = spring + dashpot
        if abs(force) > limit:
            force = copysign(limit, force)
        speed -= step * normal
        # A force at the rim moves it 1 + 5/2 times as much as the centre.
        point -= step * 3.5 * force
        depth += step * speed
    return -point / start
