# SPDX-License-Identifier: MIT OR Apache-2.0
"""Golden pairs of triaxial ellipsoids: pairs_aspect_10.csv, pairs_aspect_100.csv, pairs_aspect_1000.csv.  See README.md."""

import argparse
import multiprocessing
import pathlib
import time

import mpmath
import numpy as np
from mpmath import mp, mpf

import ellipsoid_contact as reference

HERE = pathlib.Path(__file__).resolve().parent
VECTORS = (
    ["position_i_%s" % c for c in "xyz"]
    + ["quaternion_i_%s" % c for c in "wxyz"]
    + ["semi_axis_i_%d" % k for k in (1, 2, 3)]
    + ["position_j_%s" % c for c in "xyz"]
    + ["quaternion_j_%s" % c for c in "wxyz"]
    + ["semi_axis_j_%d" % k for k in (1, 2, 3)]
)
INPUTS = ["case"] + VECTORS + ["youngs_modulus_i", "poissons_ratio_i", "youngs_modulus_j", "poissons_ratio_j"]
RESULTS = ["delta"]
for name in (
    "normal",
    "contact_point",
    "AB",
    "force_j",
    "torque_i",
    "torque_j",
    "conservative_force_j",
    "conservative_torque_i",
    "conservative_torque_j",
):
    RESULTS += ["curvature_a", "curvature_b"] if name == "AB" else ["%s_%s" % (name, c) for c in "xyz"]


def random_quaternion(generator):
    q = generator.normal(size=4)
    return q / np.linalg.norm(q)


def random_semi_axes(generator, aspect_limit):
    aspect = aspect_limit ** generator.uniform()
    largest = 2.0 ** generator.uniform(-1, 1)
    middle = aspect ** -generator.uniform()
    return generator.permutation([largest, largest * middle, largest / aspect])


def touching_normal(generator, ti, tj):
    """Direction of the centre of j seen from i, and the common normal when they just touch along it."""
    u = generator.normal(size=3)
    u /= np.linalg.norm(u)
    s = ti @ ti.T + tj @ tj.T
    n = np.linalg.solve(s, u)
    n /= np.linalg.norm(n)
    for _ in range(2000):  # fixed point of the ray direction, monotone: the ray leaves the Minkowski sum here
        m = ti @ ti.T / np.linalg.norm(n @ ti) + tj @ tj.T / np.linalg.norm(n @ tj)
        new = np.linalg.solve(m, u)
        new /= np.linalg.norm(new)
        change = np.linalg.norm(new - n)
        n = new
        if change < 1e-15:
            break
    return n


def make_pair(case, aspect_limit, seed):
    """Doubles of one random pair whose overlap is near the drawn one."""
    generator = np.random.default_rng([seed, case])
    axes_i, axes_j = random_semi_axes(generator, aspect_limit), random_semi_axes(generator, aspect_limit)
    quaternion_i, quaternion_j = random_quaternion(generator), random_quaternion(generator)
    overlap = 10 ** generator.uniform(-8, -1) * min(axes_i.min(), axes_j.min())
    position_i = generator.uniform(-1, 1, size=3)

    def shape(q, a):
        r = reference.rotation_from_quaternion([float(x) for x in q])
        return np.array(r, dtype=float) * a

    ti, tj = shape(quaternion_i, axes_i), shape(quaternion_j, axes_j)
    if case % 2:  # the normal is uniform on the sphere: contacts crowd at tips and edges
        n = generator.normal(size=3)
        n /= np.linalg.norm(n)
    else:  # the direction between the centres is uniform: contacts crowd on flat sides
        n = touching_normal(generator, ti, tj)
    d = ti @ (n @ ti) / np.linalg.norm(n @ ti) + tj @ (n @ tj) / np.linalg.norm(n @ tj) - overlap * n
    materials = [1e7, 0.3, 1e7, 0.3]
    if case % 4 == 3:
        materials = [round(10 ** generator.uniform(6, 8)), 0.05, round(10 ** generator.uniform(6, 8)), 0.45]
    return [*position_i, *quaternion_i, *axes_i, *(position_i + d), *quaternion_j, *axes_j], materials


def row(job):
    case, aspect_limit, seed = job
    mp.dps = reference.DIGITS
    values, materials = make_pair(case, aspect_limit, seed)
    values = [float(x) for x in values]
    i = reference.Body.from_doubles(values[0:3], values[3:7], values[7:10])
    j = reference.Body.from_doubles(values[10:13], values[13:17], values[17:20])
    contact = reference.find_contact(i, j, seed=case + 1)
    if contact is None or contact.delta <= 0:
        return None
    if contact.delta > mpf("0.1000001") * min(min(i.semi_axes), min(j.semi_axes)):
        raise ArithmeticError("case %d: the penetration is larger than the one drawn" % case)
    material_i = (mpf(float(materials[0])), mpf(float(materials[1])))
    material_j = (mpf(float(materials[2])), mpf(float(materials[3])))
    point, force, torque_i, torque_j = reference.plain_force(i, j, contact, material_i, material_j)
    on_i, on_j, around_i, around_j = reference.conservative_force(i, j, contact, material_i, material_j)
    scale = reference.norm(force)
    arm = max(max(i.semi_axes), max(j.semi_axes))
    # Newton's third law and the balance of moments are not built in: they check the differences
    assert max(abs(a + b) for a, b in zip(on_i, on_j)) < scale * mpf("1e-22")
    moment = reference.cross([b - a for a, b in zip(i.position, j.position)], on_j)
    assert max(abs(m + a + b) for m, a, b in zip(moment, around_i, around_j)) < scale * arm * mpf("1e-22")
    results = [contact.delta, *contact.normal, *point, contact.a, contact.b, *force, *torque_i, *torque_j]
    results += [*on_j, *around_i, *around_j]
    fields = ["%d" % case] + ["%.17g" % x for x in values + [float(m) for m in materials]]
    return ",".join(fields + [mpmath.nstr(x, 22, strip_zeros=False, min_fixed=0, max_fixed=0) for x in results])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=400, help="pairs in each file (half as many in the last)")
    parser.add_argument("--processes", type=int, default=multiprocessing.cpu_count())
    parser.add_argument("--output", type=pathlib.Path, default=HERE)
    arguments = parser.parse_args()
    for aspect_limit, pairs in ((10, arguments.pairs), (100, arguments.pairs), (1000, arguments.pairs // 2)):
        started = time.time()
        path = arguments.output / ("pairs_aspect_%d.csv" % aspect_limit)
        lines, skipped = [], 0
        with multiprocessing.Pool(arguments.processes) as pool:
            jobs = ((case, aspect_limit, 20130000 + aspect_limit) for case in range(2 * pairs))
            for line in pool.imap(row, jobs, chunksize=1):
                if line is None:
                    skipped += 1
                else:
                    lines.append(line)
                if len(lines) == pairs:
                    break
            pool.terminate()
        path.write_text("\n".join([",".join(INPUTS + RESULTS)] + lines) + "\n")
        print("%s: %d pairs, %d drawn again, %.0f s" % (path.name, len(lines), skipped, time.time() - started), flush=True)


if __name__ == "__main__":
    main()
