# SPDX-License-Identifier: MIT OR Apache-2.0
"""Solid fraction, coordination and orientation of a packing: of all of it, or of a layer between two heights."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from ellgran import Packing


@dataclass
class Measures:
    """What a packing is compared by.

    Attributes
    ----------
    solid_fraction : float
        Volume of the grains over that of the space; overlaps count twice.
    coordination : float
        Mean number of contacts of the grains that bear load.
    rattlers : float
        Share of the grains that do not.
    order : float
        Largest eigenvalue of the mean of (3 u u - 1)/2, u the first (unequal) axis of each grain: 0 without order, 1 where all are
        parallel. Without order it is of the size of 1/sqrt(number of grains).
    """

    solid_fraction: float
    coordination: float
    rattlers: float
    order: float


def bearing(count: int, pairs: np.ndarray, least: int, kept: Optional[np.ndarray] = None) -> np.ndarray:
    """Which grains bear load: those left when grains with fewer than `least` contacts are removed, again and again.

    Grains marked in `kept` stay whatever they touch: those that lie on a wall.
    """
    stays = np.ones(count, dtype=bool)
    while True:
        both = stays[pairs].all(axis=1)
        contacts = np.bincount(pairs[both].ravel(), minlength=count)
        left = stays & (contacts >= least)
        if kept is not None:
            left |= stays & kept
        if (left == stays).all():
            return stays
        stays = left


def volume_below(packing: Packing, height: float) -> float:
    """The volume of the parts of all grains below this height."""
    bodies = packing.bodies
    reach = np.linalg.norm(bodies.rotations[:, 2, :] * bodies.semi_axes, axis=1)
    t = np.clip((height - bodies.positions[:, 2]) / reach, -1.0, 1.0)
    return float((bodies.volumes * (2 + 3 * t - t**3) / 4).sum())


def measures(packing: Packing, pairs: np.ndarray, least: int, layer: Optional[Tuple[float, float]] = None) -> Measures:
    """Of a periodic packing, or of a `layer` between two heights, of one that lies on a floor and is periodic along it.

    `pairs` are those that touch, `least` the number of contacts below which a grain bears no load.
    """
    bodies = packing.bodies
    inside = np.ones(len(bodies), dtype=bool)
    kept = None
    if layer is None:
        fraction = packing.solid_fraction
    else:
        low, high = layer
        floor = np.linalg.norm(np.cross(packing.box.edges[0], packing.box.edges[1]))
        fraction = (volume_below(packing, high) - volume_below(packing, low)) / (floor * (high - low))
        heights = bodies.positions[:, 2]
        inside = (heights >= low) & (heights < high)
        kept = heights < bodies.semi_axes.max()
    stays = bearing(len(bodies), pairs, least, kept)
    contacts = np.bincount(pairs[stays[pairs].all(axis=1)].ravel(), minlength=len(bodies))
    axes = bodies.rotations[inside][:, :, 0]
    order = 1.5 * np.einsum("ki,kj->ij", axes, axes) / len(axes) - 0.5 * np.eye(3)
    return Measures(
        solid_fraction=float(fraction),
        coordination=float(contacts[inside & stays].mean()),
        rattlers=float(1.0 - stays[inside].mean()),
        order=float(np.linalg.eigvalsh(order)[-1]),
    )
