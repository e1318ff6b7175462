# SPDX-License-Identifier: MIT OR Apache-2.0
"""The sample of a stress run against the reference with 60 digits: `reference.py SAMPLE.json RESULT.csv`.

Each case has the pair's numbers, what each instruction set gave for it at rest, with the force along the normal and with the complete
gradient, and by how much rounding of the pair's numbers changes force and torque.  A case is wrong where

- a path says that the bodies touch and they do not, or the other way round, by more than rounding of their size;
- the penetration along the normal that was found exceeds the global minimum by more than a millionth and rounding;
- force or torque are off by more than 64 times what rounding explains, and 1e-11.
"""

import csv
import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "reference"))

import ellipsoid_contact as reference  # noqa: E402
import mpmath  # noqa: E402
import numpy as np  # noqa: E402
from mpmath import mp, mpf  # noqa: E402

RESOLUTION = mpf("1e-6")  # of src/geometry/contact_search.rs
ALLOWED = 64
LAW = mpf("1e-11")  # the Hertz factors' own error, and room
CLOSED_FORM_ENDS = mpf("0.9")  # of the least radius of curvature: the closed form of the gradient has a floor at 0.95


def overlap(bodies, normal):
    """h_i(n) + h_j(n) - n.d."""
    length = reference.norm(normal)
    n = [x / length for x in normal]
    f = -reference.dot(n, [b - a for a, b in zip(bodies[0].position, bodies[1].position)])
    for body in bodies:
        z = [a * x for a, x in zip(body.semi_axes, reference.matvec(reference.transpose(body.rotation), n))]
        f += reference.norm(z)
    return f


class Truth:
    """The global minimum of one pair; `contact` is None where several are as deep, or where the minimum is not isolated."""

    def __init__(self, bodies, seed):
        minima = reference.search_normals(*bodies, seed=seed)
        size = float(max(max(b.semi_axes) for b in bodies))
        best = np.array(minima[0][1])
        # A minimum and its opposite are two as well.
        tied = [np.array(n) for value, n in minima[1:] if value - minima[0][0] < 1e-9 * size]
        self.contact = None
        self.delta = overlap(bodies, [mpf(float(x)) for x in best])
        try:
            start = reference.witness_start(*bodies, best)
            contact = reference.Contact(*bodies, reference.solve_kkt(*bodies, start))
        except (ArithmeticError, ZeroDivisionError, ValueError):
            return
        if contact.delta > self.delta * (1 + RESOLUTION):
            return
        self.delta = contact.delta
        if all(np.linalg.norm(n - best) < 1e-6 for n in tied):
            self.contact = contact


def vectors(bodies, truth, conservative, material):
    """Force on j, torques on i and j; None where the reference has none."""
    contact = truth.contact
    if contact is None or contact.delta <= 0:
        return None
    radius = 1 / max(contact.curvatures_i) + 1 / max(contact.curvatures_j)
    if conservative and contact.delta > CLOSED_FORM_ENDS * radius:
        return None
    try:
        if not conservative:
            _, force, torque_i, torque_j = reference.plain_force(*bodies, contact, material, material)
            return force, torque_i, torque_j
        _, force, torque_i, torque_j = reference.conservative_force(*bodies, contact, material, material)
    except (ArithmeticError, ZeroDivisionError, ValueError):
        return None
    return force, torque_i, torque_j


def apart(given, true):
    return reference.norm([mpf(a) - b for a, b in zip(given, true)])


def judge(case, seed):
    """What is stored of a case; `wrong` says what, if anything."""
    bodies = [reference.Body.from_doubles(b["position"], b["quaternion"], b["semi_axes"]) for b in case["bodies"]]
    material = tuple(mpf(x) for x in case["material"])
    truth = Truth(bodies, seed)
    rounding = mpf(case["allowed"][0])
    wrong, excess, error, units, compared = [], mpf(0), mpf(0), mpf(0), 0
    exact = {kind: vectors(bodies, truth, kind, material) for kind in (False, True)}
    for answer in case["answers"]:
        name = answer["instruction_set"]
        if answer["touching"] != (truth.delta > 0) and abs(truth.delta) > rounding:
            wrong.append("%s: touching is %s, penetration %s" % (name, answer["touching"], mpmath.nstr(truth.delta, 5)))
        if not answer["touching"] or truth.delta <= 0:
            continue
        more = overlap(bodies, [mpf(x) for x in answer["normal"]]) - truth.delta
        excess = max(excess, more / rounding)
        if more > rounding + RESOLUTION * truth.delta:
            wrong.append("%s: penetration off by %s of %s" % (name, mpmath.nstr(more, 3), mpmath.nstr(truth.delta, 5)))
            continue
        true = exact[answer["conservative"]]
        if true is None:
            continue
        compared += 1
        force, *torques = true
        arm = max(max(b.semi_axes) for b in bodies)
        scale = reference.norm(force)
        off = [apart(answer["force_j"], force)]
        off += [apart(answer[key], torque) for key, torque in zip(("torque_i", "torque_j"), torques)]
        allowed = [ALLOWED * mpf(case["allowed"][1]) + LAW * scale] + [ALLOWED * mpf(case["allowed"][2]) + LAW * scale * arm] * 2
        error = max(error, off[0] / scale)
        most = max(x / y for x, y in zip(off, allowed))
        units = max(units, most)
        if most > 1:
            law = "complete gradient" if answer["conservative"] else "along the normal"
            wrong.append("%s, %s: %s times what rounding explains" % (name, law, mpmath.nstr(most, 3)))
    return {
        "family": case["family"],
        "block": case["block"],
        "pair": case["pair"],
        "step": case["step"],
        "why": case["why"],
        "penetration": mpmath.nstr(truth.delta, 6),
        "excess": mpmath.nstr(excess, 3),
        "force_error": mpmath.nstr(error, 3),
        "units_of_rounding": mpmath.nstr(units, 3),
        "forces_compared": compared,
        "wrong": "; ".join(wrong),
    }


def main():
    sample, result = sys.argv[1:]
    mp.dps = reference.DIGITS
    cases = json.loads(pathlib.Path(sample).read_text())
    rows, said = [], time.monotonic()
    for k, case in enumerate(cases):
        rows.append(judge(case, k + 1))
        if time.monotonic() - said > 10:
            said = time.monotonic()
            print("reference: %d of %d pairs" % (k + 1, len(cases)), file=sys.stderr, flush=True)
    with open(result, "w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
