# SPDX-License-Identifier: MIT OR Apache-2.0
"""Checks of the reference itself: more digits, closed forms, and the committed files.  See README.md."""

import csv
import pathlib

import mpmath
from mpmath import mp, mpf

import ellipsoid_contact as reference
import generate_pairs

HERE = pathlib.Path(__file__).resolve().parent


def check(name, error, limit):
    print("%-78s %.1e (limit %.0e)" % (name, float(error), limit))
    assert error <= limit, name


def two_spheres():
    i = reference.Body.from_doubles([0.1, 0.2, 0.3], [0.3, 0.1, -0.7, 0.2], [0.5] * 3)
    j = reference.Body.from_doubles([0.9, 0.1, 0.8], [1, 0, 0, 0], [0.75] * 3)
    contact = reference.find_contact(i, j)
    d = [b - a for a, b in zip(i.position, j.position)]
    steel = (mpf(10) ** 7, mpf("0.3"))
    delta = mpf("1.25") - reference.norm(d)
    force = mpf(4) / 3 * reference.contact_modulus(steel, steel) * mpmath.sqrt(mpf("0.3")) * delta ** mpf("1.5")
    _, vector, torque_i, torque_j = reference.plain_force(i, j, contact, steel, steel)
    check("two spheres, delta", abs(contact.delta / delta - 1), 1e-40)
    check("two spheres, force", abs(reference.norm(vector) / force - 1), 1e-40)
    check("two spheres, torque", max(reference.norm(torque_i), reference.norm(torque_j)) / force, 1e-40)
    on_i, on_j, around_i, around_j = reference.conservative_force(i, j, contact, steel, steel)
    check("two spheres, force by differences", max(abs(a - b) for a, b in zip(on_j, vector)) / force, 1e-25)
    check("two spheres, torque by differences", max(map(abs, around_i + around_j)) / force, 1e-25)


def aligned_ellipsoids():
    """Equal ellipsoids one above the other: radii a^2/c and b^2/c, crossed by 90 degrees."""
    a, b, c = mpf(3), mpf(2), mpf(1)
    identity = reference.rotation_from_quaternion([mpf(1), mpf(0), mpf(0), mpf(0)])
    turned = reference.rotation_about(2, mpmath.pi / 2)
    for rotation, expected in ((identity, (c / a**2, c / b**2)), (turned, ((c / a**2 + c / b**2) / 2,) * 2)):
        i = reference.Body([mpf(0)] * 3, identity, [a, b, c])
        j = reference.Body([mpf(0), mpf(0), mpf("1.95")], rotation, [a, b, c])
        contact = reference.find_contact(i, j)
        check("aligned ellipsoids, delta", abs(contact.delta / mpf("0.05") - 1), 1e-40)
        check("aligned ellipsoids, A and B", abs(contact.a / expected[0] - 1) + abs(contact.b / expected[1] - 1), 1e-25)


def hertz_table():
    """Known values of b/a, F1, F2, F2^(-3/2), to the digits in which they were given."""
    known = {
        "1.5": ("0.7632987856063925", "0.9977295650013222", "0.9977244179685665", "1.003423108152866"),
        "10": ("0.2222495192462214", "0.9370983326076421", "0.9333297892052033", "1.109040251656140"),
        "1e4": ("0.0041248573583856", "0.5830806036759311", "0.4822339122269940", "2.986162091172529"),
        "1e8": ("0.0000304491289708", "0.2846913203262498", "0.1454288155209082", "18.03118626022830"),
    }
    for ratio, values in known.items():
        h = reference.HertzFactors(mpf(ratio))
        error = max(abs(x / mpf(v) - 1) for x, v in zip((h.f1, h.f2, h.phi), values[1:]))
        check("Hertz factors at B/A = %s" % ratio, error, 1e-15)
        check("b/a at B/A = %s (sixteen decimals)" % ratio, abs(h.axis_ratio - mpf(values[0])), 1e-16)


def committed_pairs():
    for name in ("pairs_aspect_10.csv", "pairs_aspect_100.csv", "pairs_aspect_1000.csv"):
        with open(HERE / name) as file:
            rows = list(csv.DictReader(file))
        worst, nearest = mpf(0), None
        for row in rows[::20]:
            x = [float(row[key]) for key in generate_pairs.VECTORS]
            i = reference.Body.from_doubles(x[0:3], x[3:7], x[7:10])
            j = reference.Body.from_doubles(x[10:13], x[13:17], x[17:20])
            # another seed of the global search, and twenty more digits
            contact = reference.find_contact(i, j, seed=987654)
            materials = [
                (mpf(float(row["youngs_modulus_" + k])), mpf(float(row["poissons_ratio_" + k]))) for k in ("i", "j")
            ]
            _, force, torque_i, torque_j = reference.plain_force(i, j, contact, *materials)
            _, on_j, around_i, around_j = reference.conservative_force(i, j, contact, *materials)
            scale = reference.norm(force)
            for prefix, vector in (
                ("force_j", force),
                ("torque_i", torque_i),
                ("torque_j", torque_j),
                ("conservative_force_j", on_j),
                ("conservative_torque_i", around_i),
                ("conservative_torque_j", around_j),
            ):
                for c, value in zip("xyz", vector):
                    worst = max(worst, abs(value - mpf(row["%s_%s" % (prefix, c)])) / scale)
            worst = max(worst, abs(contact.delta / mpf(row["delta"]) - 1))
        check("%s, every 20th pair again with 80 digits" % name, worst, 1e-20)


def main():
    mp.dps = reference.DIGITS
    two_spheres()
    aligned_ellipsoids()
    hertz_table()
    mp.dps = reference.DIGITS + 20
    committed_pairs()
    print("all hold")


if __name__ == "__main__":
    main()
