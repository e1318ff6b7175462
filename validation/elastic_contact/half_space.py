# SPDX-License-Identifier: MIT OR Apache-2.0
"""Boundary elements: two elastic half-spaces pressed together over a given gap, frictionless, by the package tamaas.

Polonsky and Keer's conjugate gradients with the non-periodic Boussinesq operator; pressures are constant on rectangles. Nothing of
Hertz' theory enters: contact area, pressure and penetration are what the inequalities p >= 0, gap >= 0 leave.
"""
from __future__ import annotations

from typing import Callable, NamedTuple, Tuple

import numpy as np
import tamaas

tamaas.set_log_level(tamaas.LogLevel.error)

_solver = tamaas.PolonskyKeerRey


class Pressed(NamedTuple):
    """Lengths and pressures in the units of the input.

    ``penetration``: how far the bodies have come together since first touch. ``semi_axes``: along x and y, those of the elliptical
    Hertz pressure with the same second moments, sqrt(5 <x^2>). ``peak``: the largest pressure.
    """

    penetration: float
    semi_axes: Tuple[float, float]
    peak: float


def press(
    gap: Callable[[np.ndarray, np.ndarray], np.ndarray], force: float, modulus: float, half_widths: Tuple[float, float], count: int
) -> Pressed:
    """Presses two bodies together.

    Parameters: ``gap(x, y)`` between the undeformed surfaces at first touch, 0 at the origin; the normal ``force``; the effective
    ``modulus`` E*; the half widths of the rectangle that holds the contact; the ``count`` of elements along each side, even.
    """
    widths = [2.0 * half for half in half_widths]
    x, y = ((np.arange(count) + 0.5) / count * width - width / 2 for width in widths)
    undeformed = gap(x[:, None], y[None, :])
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, widths, [count, count])
    model.E, model.nu = modulus, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "open")
    solver = _solver(model, -undeformed, 1e-12, _solver.pressure, _solver.pressure)
    solver.setIntegralOperator("open")
    solver.max_iter = 20_000
    error = solver.solve(force / (widths[0] * widths[1]))
    if not error < 1e-11:
        raise RuntimeError(f"the boundary elements did not converge: {error}")
    pressure = np.array(model.traction)
    displacement = np.zeros_like(pressure)
    model.operators["open"](pressure, displacement)
    touching = pressure > 0
    approach = (displacement + undeformed)[touching]
    total = pressure.sum()
    moments = [float((pressure * square).sum() / total) for square in (x[:, None] ** 2, y[None, :] ** 2)]
    return Pressed(
        float(np.average(approach, weights=pressure[touching])),
        (float(np.sqrt(5 * moments[0])), float(np.sqrt(5 * moments[1]))),
        float(pressure.max()),
    )
