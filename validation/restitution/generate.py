# SPDX-License-Identifier: MIT OR Apache-2.0
"""Generates validation/restitution/restitution.csv: the coefficient of restitution of a central impact on

    F = k delta^(3/2) + alpha sqrt(m k) delta^(1/4) d(delta)/dt

by integration of the equation of motion in 30 digits, once until the force is zero (an attractive force is cut off there)
and once until delta = 0 (attraction allowed; for alpha < 2, since from sqrt(5) on the bodies never part).

e depends on alpha alone: m = k = v = 1.  With delta = s^4 and the time scale dt = s^3 dtau the motion is that of a polynomial
vector field, smooth at first touch,

    ds/dtau = v/4 ,   dv/dtau = -s^9 - alpha s^4 v .

The library solves a closed form instead (src/force/damping.rs), which these numbers know nothing of.

Usage: python generate.py > restitution.csv      (needs mpmath)
"""
from mpmath import findroot, mp, mpf, nstr, odefun

mp.dps = 30
ALPHAS = ["0.001", "0.01", "0.05", "0.1", "0.2", "0.5", "0.8", "1", "1.3", "1.6", "1.9", "2.1", "2.25", "2.5",
          "3", "4", "6", "10", "20", "40"]


def restitution(alpha):
    """(e without attraction, e with attraction or None)."""
    motion = odefun(lambda _, y: [y[1] / 4, -(y[0] ** 9) - alpha * y[0] ** 4 * y[1]], 0, [mpf(0), mpf(1)])

    def end(event):
        step = mpf(1) / 4
        t = step
        while event(motion(t)) > 0:
            t += step
        low, high = t - step, t
        for _ in range(20):
            middle = (low + high) / 2
            low, high = (middle, high) if event(motion(middle)) > 0 else (low, middle)
        t = findroot(lambda x: event(motion(x)), (low, high), solver="secant", tol=mpf(10) ** -25)
        return -motion(t)[1]

    cut = end(lambda y: y[0] ** 5 + alpha * y[1])
    whole = end(lambda y: y[0]) if alpha < 2 else None
    return cut, whole


def main():
    print("alpha,without_attraction,with_attraction")
    for text in ALPHAS:
        cut, whole = restitution(mpf(text))
        print(f"{text},{nstr(cut, 20)},{nstr(whole, 20) if whole is not None else ''}", flush=True)


if __name__ == "__main__":
    main()
