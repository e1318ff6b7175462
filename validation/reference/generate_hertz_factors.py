# SPDX-License-Identifier: MIT OR Apache-2.0
"""Golden table of Hertz's elliptical contact: hertz_factors.csv.  See README.md."""

import argparse
import pathlib

import mpmath
from mpmath import mp, mpf

import ellipsoid_contact as reference

HERE = pathlib.Path(__file__).resolve().parent


def ratios():
    near_circle = [1.0] + [1.0 + 10.0**-k for k in range(15, 0, -1)] + [1.2, 1.5, 2.0, 3.0]
    logarithmic = [float(mpf(10) ** (mpf(8) * k / 200)) for k in range(1, 201)]
    return sorted(set(near_circle + logarithmic))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=pathlib.Path, default=HERE)
    arguments = parser.parse_args()
    mp.dps = reference.DIGITS
    lines = ["ratio,b_over_a,F1,F2,phi,K,E,beta_major"]
    for ratio in ratios():
        h = reference.HertzFactors(mpf(ratio))
        values = (h.axis_ratio, h.f1, h.f2, h.phi, h.k, h.e, h.beta_major)
        lines.append(",".join(["%.17g" % ratio] + [mpmath.nstr(v, 25, strip_zeros=False, min_fixed=0, max_fixed=0) for v in values]))
    (arguments.output / "hertz_factors.csv").write_text("\n".join(lines) + "\n")
    print("hertz_factors.csv: %d rows" % (len(lines) - 1))


if __name__ == "__main__":
    main()
