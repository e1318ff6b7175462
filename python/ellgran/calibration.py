# SPDX-License-Identifier: MIT OR Apache-2.0
"""From measurements to a deck: viscosities from a coefficient of restitution, and the time step that a law allows."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Tuple, Union

import numpy as np

from . import _interface
from .bodies import Bodies
from .collision import restitution
from .contact_arrays import elastic_collisions, rayleigh_times, stiffnesses
from .law import Law, Laws, as_law, as_laws


def with_restitution(
    law: Union[Law, str],
    target: float,
    speed: float,
    bodies: Bodies,
    *,
    bulk_over_shear: float = 1.0,
    tolerance: float = 1e-6,
) -> Law:
    """The `nfd` law whose central impact of two bodies has a measured coefficient of restitution.

    Parameters
    ----------
    law : Law or str
        ``nfd E nu eta1 eta2 ...``; its viscosities are replaced, the other words stay.
    target : float
        The measured coefficient of restitution, above 0 and below 1.
    speed : float
        Speed along the normal at which it was measured, length/time.
    bodies : Bodies
        The two that met, in the pose of the impact, both of this law. A wall of the same material is a body of ``masses=inf``, of
        semi-axes so large that it is flat.
    bulk_over_shear : float
        ``eta2/eta1``, >= 0. Central impacts do not tell the two apart.
    tolerance : float
        Largest error of the coefficient.

    Returns
    -------
    Law

    Raises
    ------
    ValueError
        The law is not `nfd` or has ``viscosity memory``, the impact is not central, or no viscosity has this restitution.

    See Also
    --------
    ellgran.collision.restitution : the way back.
    """
    law = as_law(law)
    if law._parameters.normal != _interface.ELLGRAN_NORMAL_NFD:
        raise ValueError(f"'{law.words}' has no viscosities: begin it with nfd E nu eta1 eta2")
    if not 0.0 < target < 1.0:
        raise ValueError(f"target = {target} must be above 0 and below 1")
    if not bulk_over_shear >= 0.0 or not math.isfinite(bulk_over_shear):
        raise ValueError(f"bulk_over_shear = {bulk_over_shear} must be 0 or greater")
    if len(bodies) != 2:
        raise ValueError(f"an impact is of 2 bodies, not of {len(bodies)}")

    def trial(logarithm: float) -> Law:
        shear = math.exp(logarithm)
        return law.with_viscosities(shear, bulk_over_shear * shear)

    def excess(logarithm: float) -> float:
        return float(restitution(trial(logarithm), bodies, speed)) - target

    # A relaxation time of the order of the collision's duration: E times it is a viscosity.
    pair = np.array([[0, 1]], dtype=np.int32)
    one_type = bodies.copy()
    one_type.types = np.ones(2, dtype=np.int32)
    duration, _ = elastic_collisions(law, one_type, pair, speed)
    low = math.log(1e-2 * law.youngs_modulus * float(duration[0]) * (1.0 - target))
    high = low + math.log(100.0)
    at_low, at_high = excess(low), excess(high)
    for _ in range(40):
        if at_low >= 0.0:
            break
        low -= 2.0
        at_low = excess(low)
    for _ in range(40):
        if at_high <= 0.0:
            break
        high += 1.0
        at_high = excess(high)
    if at_low < 0.0 or at_high > 0.0:
        raise ValueError(
            f"no viscosity gives the restitution {target}: the law '{law.words}' reaches {at_high + target:.6g} to "
            f"{at_low + target:.6g}"
        )
    # Regula falsi with halved weights (the Illinois method): the bracket stays, and it converges faster than bisection.
    side = 0
    middle = low
    for _ in range(100):
        middle = (low * at_high - high * at_low) / (at_high - at_low) if at_high != at_low else 0.5 * (low + high)
        at_middle = excess(middle)
        if abs(at_middle) <= tolerance:
            break
        if at_middle > 0.0:
            low, at_low = middle, at_middle
            at_high *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            high, at_high = middle, at_middle
            at_low *= 0.5 if side == -1 else 1.0
            side = -1
    return trial(middle)


@dataclass(frozen=True)
class StepAdvice:
    """Times that limit the time step of a scene.

    Attributes
    ----------
    critical : float
        The longest step with which one contact is stable, at the overlap of the shortest collision, or at 1 % of the least
        semi-axis if that is more. A grain with n contacts needs a step shorter by the root of n.
    collision : float
        The shortest elastic collision. It needs at least 10 steps; 50 keep the energy of viscous grains to 1e-4.
    rayleigh : float
        The shortest Rayleigh time. A fifth of it is a common time step. ``inf`` for the linear law.
    penetration : float
        The deepest overlap of a collision at this speed, length.
    step : float
        Advice: the shortest of collision/50, rayleigh/5 and critical/sqrt(12) - as many contacts as a grain may have.
    """

    critical: float
    collision: float
    rayleigh: float
    penetration: float
    step: float


def step_advice(laws: Union[Laws, Law, str], bodies: Bodies, speed: float) -> StepAdvice:
    """The time step that laws, grains and their speed allow: what LAMMPS' log shows when a run starts.

    Parameters
    ----------
    laws : Laws, Law or str
        The laws between the types of the grains.
    bodies : Bodies
        All kinds of grains of the scene, one of each is enough. Of each type the one of the least semi-axis counts, flat side on flat
        side, where a contact is stiffest. Positions and rotations are not read.
    speed : float
        The largest relative speed of two grains, length/time, > 0.

    Returns
    -------
    StepAdvice
    """
    laws = as_laws(laws)
    if not (speed > 0.0 and math.isfinite(speed)):
        raise ValueError(f"speed = {speed} must be greater than 0")
    if len(bodies) == 0:
        raise ValueError("step advice needs at least one grain")
    least = bodies.semi_axes.min(axis=1)
    chosen = [
        int(np.flatnonzero(bodies.types == kind)[least[bodies.types == kind].argmin()])
        for kind in np.unique(bodies.types)
    ]
    grains = bodies[chosen]
    # The smallest semi-axis along z.
    grains.semi_axes = np.sort(grains.semi_axes, axis=1)[:, ::-1]
    grains.quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (len(grains), 1))
    which: List[Tuple[int, int]] = [(i, j) for i in range(len(grains)) for j in range(i, len(grains))]
    first, second = grains[[i for i, _ in which]], grains[[j for _, j in which]]
    both = Bodies.joined(first, second)
    count = len(which)
    pairs = np.stack([np.arange(count), count + np.arange(count)], axis=1).astype(np.int32)
    both.positions = np.zeros((2 * count, 3))
    both.velocities = np.zeros((2 * count, 3))
    reach = first.semi_axes[:, 2] + second.semi_axes[:, 2]
    overlap = 0.01 * np.minimum(first.semi_axes[:, 2], second.semi_axes[:, 2])
    both.positions[count:, 2] = reach - overlap
    duration, depth = elastic_collisions(laws, both, pairs, speed)
    # Deeper than a quarter of the grain no law holds.
    both.positions[count:, 2] = reach - np.minimum(np.maximum(overlap, depth), 0.25 * reach)
    critical = float(stiffnesses(laws, both, pairs).critical_step.min())
    collision = float(duration.min())
    # Another grain of a type can have the shorter Rayleigh time: it is a lighter one.
    rayleigh = float(rayleigh_times(laws, bodies).min())
    return StepAdvice(
        critical=critical,
        collision=collision,
        rayleigh=rayleigh,
        penetration=float(depth.max()),
        step=min(collision / 50.0, rayleigh / 5.0, critical / math.sqrt(12.0)),
    )
