# SPDX-License-Identifier: MIT OR Apache-2.0
"""The coefficients of `share_in_sliding_torque` of `twisting lubkin` (src/force/twisting_bed.rs).

The share of the discs up to r, in units of the radius of the contact, in the torque of a contact of Hertz that slides everywhere is

    L(r) = 64/pi^2 times the integral of s^2 (K - E) from 0 to r

with complete elliptic integrals of the modulus sqrt(1 - s^2). Both are power series in s^2, and others times ln s. So

    L(r)/r^3 = P(x) + Q(x) ln(1/x) ,    x = r^2

with five coefficients each, P(1) = 1, which L(1) = 1 asks for, and the squares of r^2 times the residual least in sum over r = sin of angles
that are evenly apart.

Run it to print them, and the largest error of L; it reads and writes nothing.
"""
from __future__ import annotations

from typing import Tuple

import numpy as np
from scipy.special import ellipe, ellipkm1

COUNT = 5
POINTS = 240


def disc(radius: np.ndarray) -> np.ndarray:
    """K - E of the modulus sqrt(1 - radius^2)."""
    return ellipkm1(radius**2) - ellipe(1.0 - radius**2)


def over_cube(radius: np.ndarray) -> np.ndarray:
    """L(r)/r^3 at 0 < r <= 1, to 1e-13 of itself."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    # s = r t^3: the logarithm of s at 0 comes with the eighth power of t.
    part = 0.5 * (nodes + 1.0)
    within = np.asarray(radius)[..., None] * part**3
    return 64.0 / np.pi**2 * np.sum(1.5 * weights * part**8 * disc(within), axis=-1)


def share(radius: np.ndarray) -> np.ndarray:
    """L(r)."""
    return np.asarray(radius) ** 3 * over_cube(radius)


def by_series(plain: np.ndarray, logarithmic: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """L(r) by the coefficients of P and Q."""
    square = radius**2
    powers = np.stack([square**k for k in range(len(plain))], axis=-1)
    return radius**3 * (powers @ plain - np.log(square) * (powers @ logarithmic))


def coefficients() -> Tuple[np.ndarray, np.ndarray]:
    """Of P and of Q."""
    radius = np.sin(0.5 * np.pi * (np.arange(POINTS) + 0.5) / POINTS)
    square = radius**2
    powers = np.stack([square**k for k in range(COUNT)], axis=1)
    # The first coefficient of P is 1 less the others.
    columns = np.concatenate([powers[:, 1:] - 1.0, -np.log(square)[:, None] * powers], axis=1)
    found = np.linalg.lstsq(square[:, None] * columns, square * (over_cube(radius) - 1.0), rcond=None)[0]
    others = found[: COUNT - 1]
    return np.concatenate([[1.0 - others.sum()], others]), found[COUNT - 1 :]


def largest_error(plain: np.ndarray, logarithmic: np.ndarray) -> float:
    """Of L, over 0 < r <= 1."""
    radius = np.sin(0.5 * np.pi * np.arange(1, 4001) / 4000)
    return float(np.abs(by_series(plain, logarithmic, radius) - share(radius)).max())


def main() -> None:
    plain, logarithmic = coefficients()
    for name, of in (("PLAIN", plain), ("LOGARITHMIC", logarithmic)):
        print(name, *(repr(float(value)) for value in of), sep="\n    ")
    print(f"largest error {largest_error(plain, logarithmic):.1e}")


if __name__ == "__main__":
    main()
