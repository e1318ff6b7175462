# SPDX-License-Identifier: MIT OR Apache-2.0
"""The kernels against numerical integration over the loaded rectangle."""
import numpy as np
from scipy.integrate import dblquad

from half_space_kernels import Rectangles, Shear


def test_kernels_are_the_integrals_over_a_rectangle():
    grid = Rectangles((1.0, 0.6), 8)
    loaded, seen = (2, 3), (5, 6)
    load = np.zeros((8, 8))
    load[loaded] = 1.0
    at = grid.x[seen[0], 0] - grid.x[loaded[0], 0], grid.y[0, seen[1]] - grid.y[0, loaded[1]]
    half = [0.5 * side for side in grid.sides]

    def integral(function):
        return dblquad(lambda y, x: function(at[0] - x, at[1] - y), -half[0], half[0], -half[1], half[1])[0]

    def inverse(x, y):
        return 1.0 / np.hypot(x, y)

    poisson = 0.3
    shear = Shear(grid, 1.0 / np.pi, poisson)(np.stack([load, 0 * load]))
    for found, wanted in [
        (grid.normal(load)[seen], integral(inverse)),
        (shear[0][seen], integral(lambda x, y: (1 - poisson) * inverse(x, y) + poisson * x * x * inverse(x, y) ** 3)),
        (shear[1][seen], integral(lambda x, y: poisson * x * y * inverse(x, y) ** 3)),
    ]:
        assert abs(found / wanted - 1) < 1e-12
