# SPDX-License-Identifier: MIT OR Apache-2.0
"""Generates src/force/hertz_factors/fit_coefficients.rs: two fits of the same two functions.

Far: the Hertz factors of an elliptical contact are smooth functions of

    w = ln(T^2 / (4 D)),   T = A + B,  D = A B        (= 2 ln cosh(L/2), L = ln(B/A))

which is 0 for a circle, ~L for a needle, and analytic at the circle, where L itself is not the natural variable:
a function that does not change when A and B are swapped is even in L.  Two functions are fitted on 0 <= w <= W_MAX:

    phi(w)   = F2^(-3/2)                       the factor in Hertz' force
    sigma(w) = (1/2 - Bl/K) / ((B - A)/(B + A))  the anisotropy of the tangential compliance

by Chebyshev interpolation in 40 digits (Trefethen, Approximation Theory and Approximation Practice, ch. 4),
truncated and rewritten in powers of x = 2 w / W_MAX - 1.  The nearest singularities are at w = +-2 pi i, so the
coefficients fall like 3.0^-n.  (d ln(phi)/dw = sigma/2 exactly, so that the gradient needs no fit of its own.)

Near a circle, without a logarithm and with half the terms:

    q = (T - 2 sqrt(D)) / (T + 2 sqrt(D)) = ((sqrt(B) - sqrt(A)) / (sqrt(B) + sqrt(A)))^2

in which the nearest singularities are at +-1; the same two functions on 0 <= q <= Q_MAX, in powers of q itself.

Printed: the largest relative error of the rounded polynomial on a fine grid.

Usage: python fit.py > ../../src/force/hertz_factors/fit_coefficients.rs      (needs mpmath)
"""
import sys

from mpmath import (acosh, chop, cos, ellipe, ellipk, exp, findroot, ln, log, mp, mpf, pi, sqrt, tanh, elliprd)

mp.dps = 40
W_MAX = mpf(12)
DEGREE = 24
NEAR_RATIO = mpf(10)  # B/A: every contact of grains of revolution up to an aspect ratio of 3.16
Q_MAX = ((sqrt(NEAR_RATIO) - 1) / (sqrt(NEAR_RATIO) + 1)) ** 2
NEAR_DEGREE = 13


def factors(w):
    """(phi, sigma) at w, by Newton in ln k with Carlson's R_D."""
    L = 2 * acosh(exp(w / 2))
    if L < mpf(10) ** -12:
        L = mpf(10) ** -12  # both functions are even in L: the error is of order L^2
    def ratio(lnk):
        k2 = exp(2 * lnk)
        return log(elliprd(0, 1, k2) / elliprd(0, k2, 1)) - L
    lnk = findroot(ratio, -L * 2 / pi if L > 0.1 else -L * mpf(2) / 3)
    k = exp(lnk)
    D = elliprd(0, k * k, 1) / 3
    Bl = k * k * elliprd(0, 1, k * k) / 3
    K = Bl + D
    F1 = (4 / pi * sqrt(k * Bl * D)) ** (mpf(1) / 3)
    F2 = 2 / pi * sqrt(k) * K / F1
    return F2 ** (mpf(-3) / 2), (D - Bl) / (2 * K) / tanh(L / 2)


def fit(values, n):
    """Monomial coefficients in x of the Chebyshev interpolant through values at the n+1 Chebyshev points."""
    c = []
    for j in range(n + 1):
        s = sum(values[k] * cos(pi * j * (k + mpf(1) / 2) / (n + 1)) for k in range(n + 1))
        c.append(s * 2 / (n + 1))
    c[0] /= 2
    t0, t1 = [mpf(1)], [mpf(0), mpf(1)]
    out = [mpf(0)] * (n + 1)
    for j in range(n + 1):
        t = t0 if j == 0 else t1
        for i, a in enumerate(t):
            out[i] += c[j] * a
        if j >= 1:
            t2 = [mpf(0)] + [2 * a for a in t1]
            for i, a in enumerate(t0):
                t2[i] -= a
            t0, t1 = t1, t2
    return out


def in_powers_of_q(c):
    """From powers of x = 2 q / Q_MAX - 1."""
    out, power = [mpf(0)] * len(c), [mpf(1)]
    for a in c:
        for k, b in enumerate(power):
            out[k] += a * b
        shifted = [mpf(0)] * (len(power) + 1)
        for k, b in enumerate(power):
            shifted[k] -= b
            shifted[k + 1] += b * 2 / Q_MAX
        power = shifted
    return out


def near_factors(q):
    return factors(-2 * log((1 - q) / (1 + q)))


def horner(coefficients, x):
    s = 0.0
    for a in reversed(coefficients):
        s = s * x + a
    return s


def main():
    n = DEGREE
    nodes = [cos(pi * (k + mpf(1) / 2) / (n + 1)) for k in range(n + 1)]
    pairs = [factors((x + 1) * W_MAX / 2) for x in nodes]
    polynomials = {}
    for name, index in (("PHI", 0), ("SIGMA", 1)):
        polynomials[name] = [float(a) for a in fit([p[index] for p in pairs], n)]
    errors = {"PHI": 0.0, "SIGMA": 0.0}
    for i in range(1, 400):
        w = float(W_MAX) * i / 400.0
        exact = factors(mpf(w))
        for name, index in (("PHI", 0), ("SIGMA", 1)):
            value = horner(polynomials[name], 2.0 * w / float(W_MAX) - 1.0)
            errors[name] = max(errors[name], abs(float((mpf(value) - exact[index]) / exact[index])))
    near_nodes = [cos(pi * (k + mpf(1) / 2) / (NEAR_DEGREE + 1)) for k in range(NEAR_DEGREE + 1)]
    near_pairs = [near_factors((x + 1) * Q_MAX / 2) for x in near_nodes]
    for name, index in (("NEAR_PHI", 0), ("NEAR_SIGMA", 1)):
        polynomials[name] = [float(a) for a in in_powers_of_q(fit([p[index] for p in near_pairs], NEAR_DEGREE))]
        errors[name] = 0.0
    for i in range(1, 400):
        q = float(Q_MAX) * i / 400.0
        exact = near_factors(mpf(q))
        for name, index in (("NEAR_PHI", 0), ("NEAR_SIGMA", 1)):
            value = horner(polynomials[name], q)
            errors[name] = max(errors[name], abs(float((mpf(value) - exact[index]) / exact[index])))
    print("// SPDX-License-Identifier: MIT OR Apache-2.0")
    print("//! Generated by `validation/hertz_factors/fit.py`; do not edit.")
    print("//!")
    print("//! Largest relative error of the rounded polynomials in double precision on 399 points of the range:")
    print(f"//! phi {errors['PHI']:.1e}, sigma {errors['SIGMA']:.1e}; near a circle phi {errors['NEAR_PHI']:.1e}, sigma")
    print(f"//! {errors['NEAR_SIGMA']:.1e}.")
    print()
    print("/// The fit holds for `0 <= w <= W_MAX`, `w = ln((A + B)^2 / (4 A B))`: B/A up to 6.5e5.")
    print(f"pub(super) const W_MAX: f64 = {float(W_MAX):.1f};")
    print()
    print("/// The fit near a circle holds for `0 <= q <= Q_MAX`, `q = (A + B - 2 sqrt(A B))/(A + B + 2 sqrt(A B))`: B/A up to")
    print(f"/// {float(NEAR_RATIO):g}.")
    print(f"pub(super) const Q_MAX: f64 = {float(Q_MAX)!r};")
    for name in ("PHI", "SIGMA", "NEAR_PHI", "NEAR_SIGMA"):
        print()
        what = "F2^(-3/2)" if "PHI" in name else "(1/2 - Bl/K) (A + B)/(B - A)"
        variable = "`q`" if "NEAR" in name else "`x = 2 w / W_MAX - 1`"
        print(f"/// Coefficients of `{what}` in rising powers of {variable}.")
        print("#[rustfmt::skip]")
        print("#[allow(clippy::excessive_precision)]")
        print(f"pub(super) const {name}: [f64; {len(polynomials[name])}] = [")
        for a in polynomials[name]:
            print(f"    {a!r},")
        print("];")
    print(errors, file=sys.stderr)


if __name__ == "__main__":
    main()
