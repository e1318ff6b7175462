# SPDX-License-Identifier: MIT OR Apache-2.0
"""Displacements of the surface of an elastic half-space under tractions that are constant on rectangles: Boussinesq, Love, Cerruti.

The integrals of 1/r, x^2/r^3, y^2/r^3 and xy/r^3 over a rectangle in closed form (K.L. Johnson, Contact Mechanics, section 3.2 and
3.6); the sums over rectangles by fast Fourier transform, without periodicity.
"""
from __future__ import annotations

from typing import Dict, Tuple

import numpy as np
from scipy import fft

Grid = np.ndarray


class Rectangles:
    """`count` x `count` rectangles over [-half_x, half_x] x [-half_y, half_y]; arrays are indexed [x, y]."""

    def __init__(self, half_widths: Tuple[float, float], count: int) -> None:
        self.count = count
        self.sides = tuple(2.0 * half / count for half in half_widths)
        middle = np.arange(count) + 0.5 - count / 2
        self.x, self.y = middle[:, None] * self.sides[0], middle[None, :] * self.sides[1]
        self.area = self.sides[0] * self.sides[1]
        offset = fft.fftfreq(2 * count, 1.0 / (2 * count))
        primitives: Dict[str, Grid] = {"xx": 0.0, "yy": 0.0, "xy": 0.0}
        for sign_x in (1, -1):
            for sign_y in (1, -1):
                x = (offset[:, None] + 0.5 * sign_x) * self.sides[0]
                y = (offset[None, :] + 0.5 * sign_y) * self.sides[1]
                sign = sign_x * sign_y
                primitives["xx"] = primitives["xx"] + sign * y * np.arcsinh(x / np.abs(y))
                primitives["yy"] = primitives["yy"] + sign * x * np.arcsinh(y / np.abs(x))
                primitives["xy"] = primitives["xy"] - sign * np.hypot(x, y)
        self._of_x2 = fft.rfft2(primitives["xx"])
        self._of_y2 = fft.rfft2(primitives["yy"])
        self._of_xy = fft.rfft2(primitives["xy"])

    def _transformed(self, field: Grid) -> Grid:
        return fft.rfft2(field, s=(2 * self.count,) * 2)

    def _back(self, product: Grid) -> Grid:
        return fft.irfft2(product, s=(2 * self.count,) * 2)[: self.count, : self.count]

    def averaged(self, function: object, parts: int = 8) -> Grid:
        """Mean of function(x, y) over each rectangle, from `parts` x `parts` points."""
        shifts = (np.arange(parts) + 0.5) / parts - 0.5
        total = np.zeros((self.count, self.count))
        for shift_x in shifts:
            for shift_y in shifts:
                total += function(self.x + shift_x * self.sides[0], self.y + shift_y * self.sides[1])
        return total / parts**2

    def normal(self, pressure: Grid) -> Grid:
        """Normal displacement times E/(2 (1 - nu^2)) . 2 pi ... of a half-space with (1 - nu)/(2 pi G) = 1."""
        return self._back((self._of_x2 + self._of_y2) * self._transformed(pressure))


class Shear:
    """Relative tangential displacement of two equal half-spaces under equal and opposite shear tractions, shape (2, n, n)."""

    def __init__(self, rectangles: Rectangles, shear_modulus: float, poisson: float) -> None:
        self.rectangles = rectangles
        factor = 1.0 / (np.pi * shear_modulus)  # twice that of one body
        inverse = (rectangles._of_x2 + rectangles._of_y2) * (1.0 - poisson)
        self._xx = factor * (inverse + poisson * rectangles._of_x2)
        self._yy = factor * (inverse + poisson * rectangles._of_y2)
        self._xy = factor * poisson * rectangles._of_xy

    def __call__(self, traction: Grid) -> Grid:
        x, y = (self.rectangles._transformed(part) for part in traction)
        return np.stack(
            [self.rectangles._back(self._xx * x + self._xy * y), self.rectangles._back(self._xy * x + self._yy * y)]
        )
