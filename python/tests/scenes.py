# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies that several tests use."""
import numpy as np

import ellgran

MATERIALS = ("nfd 1e4 0.3 40 60 tangential tfd 0.4", "nfd 3e4 0.2 90 30 tangential tfd 0.2")


def random_bodies(count, seed=1):
    """Triaxial ellipsoids of two types in a cube, many of them touching, in motion."""
    generator = np.random.default_rng(seed)
    return ellgran.Bodies(
        generator.random((count, 3)) * 1.7 * count ** (1 / 3),
        generator.uniform(0.7, 1.35, (count, 3)),
        generator.normal(size=(count, 4)),
        velocities=generator.uniform(-0.5, 0.5, (count, 3)),
        angular_velocities=generator.uniform(-0.5, 0.5, (count, 3)),
        masses=generator.uniform(0.5, 2.0, count),
        types=1 + np.arange(count) % 2,
        identifiers=1000 + np.arange(count),
    )


def all_pairs(count):
    return np.stack(np.triu_indices(count, 1), axis=1).astype(np.int32)


def two_spheres(radius=1e-3, gap=0.0, **more):
    return ellgran.Bodies([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0 * radius + gap]], radius, density=2500.0, **more)
