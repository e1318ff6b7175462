// SPDX-License-Identifier: MIT OR Apache-2.0
//! By how much is the viscous force of a contact that began within the last step to be greater, so that the sum over the steps
//! has the impulse of the contact's begin?
//!
//! A viscous force begins like `t^p` with the time `t` since the first touch: `p` is 1/2 for a relaxation time and 1/4 for a
//! coefficient of restitution of Hertz' law, 0 for a constant dashpot. Where a contact is `theta` of a step old when its force is
//! first computed, the sum of `(theta + k)^p` over the steps `k` from 0 on differs from its integral by Hurwitz' zeta function
//! `zeta(-p, theta)`, whatever comes later (the Euler-Maclaurin formula for an algebraic begin; I. Navot, J. Math. and Phys. 40
//! (1961) 271). The first force times `1 - zeta(-p, theta)/theta^p = -zeta(-p, 1 + theta)/theta^p` makes up for it. Without that
//! the error of a collision falls as the power `1 + p` of the step, with it as the square.

use crate::real::Real;

/// How a viscous force begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// With a jump: a constant dashpot.
    Jump,
    /// As the fourth root of the time.
    FourthRoot,
    /// As the square root of the time.
    SquareRoot,
}

/// `-zeta(-1/2, 1 + theta)` for `theta` from 0 to 1, to 2e-5: interpolated at Chebyshev's points.
const SQUARE_ROOT: [f64; 5] = [
    0.20787224069192617,
    0.7308857237845939,
    0.32048370282196914,
    -0.06413652261277455,
    0.012789642194896063,
];

/// `-zeta(-1/4, 1 + theta)`, likewise.
const FOURTH_ROOT: [f64; 5] = [
    0.32043808719013583,
    0.860989592812714,
    0.17821974537330879,
    -0.050033245706320534,
    0.010844898394162797,
];

/// Below this age the factor stays what it is there: the force has vanished.
const LEAST_AGE: f64 = 1e-8;

/// The factor of the viscous force of a contact with this penetration, `approach` its rate, in a step of this time; 1 where
/// the contact recedes, is older than the step, or is less deep than 1e-290. At most 2100.
#[inline(always)]
pub fn begin_factor<T: Real>(begin: Begin, penetration: T, approach: T, time: T) -> T {
    let one = time.constant(1.0);
    let way = approach * time;
    // Few contacts are new in a step. Lanes that do not touch have a penetration of 1e-300: they would all look new.
    let touches = (one * 1e-290).less(penetration);
    let is_new = T::select(touches, penetration, way).less(way);
    if !time.any(is_new) {
        return one;
    }
    let age = penetration / way.max(one * 1e-300);
    let age = age.max(one * LEAST_AGE).min(one);
    let factor = match begin {
        Begin::Jump => age + one * 0.5,
        Begin::SquareRoot => polynomial(&SQUARE_ROOT, age) * age.reciprocal_sqrt(),
        Begin::FourthRoot => {
            let root = age.reciprocal_sqrt();
            polynomial(&FOURTH_ROOT, age) * (root * root.reciprocal_sqrt())
        }
    };
    T::select(is_new, factor, one)
}

#[inline(always)]
fn polynomial<T: Real>(c: &[f64; 5], x: T) -> T {
    let mut sum = x.constant(c[4]);
    sum = sum.multiply_add(x, x.constant(c[3]));
    sum = sum.multiply_add(x, x.constant(c[2]));
    sum = sum.multiply_add(x, x.constant(c[1]));
    sum.multiply_add(x, x.constant(c[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the correction the sum of `(theta + k)^p` over the steps has the integral, up to the smooth upper end.
    #[test]
    fn a_sum_from_within_a_step_has_the_integral() {
        for (begin, p) in [
            (Begin::Jump, 0.0),
            (Begin::FourthRoot, 0.25),
            (Begin::SquareRoot, 0.5),
        ] {
            for theta in [1e-6, 0.1, 0.3, 0.5, 0.9, 0.999] {
                let first = begin_factor(begin, theta, 1.0, 1.0) * f64::powf(theta, p);
                let steps = 400;
                let sum: f64 = (1..steps).map(|k| (theta + k as f64).powf(p)).sum();
                // Half of the last sample, and the end's next term.
                let end = theta + steps as f64;
                let last = 0.5 * end.powf(p) - p * end.powf(p - 1.0) / 12.0;
                let integral = end.powf(p + 1.0) / (p + 1.0);
                let gap = first + sum + last - integral;
                assert!(gap.abs() < 2e-5, "p {p}, theta {theta}: {gap:e}");
            }
        }
    }

    /// What counts is how old the contact is in steps, whatever the units.
    #[test]
    fn the_units_do_not_matter() {
        for begin in [Begin::Jump, Begin::FourthRoot, Begin::SquareRoot] {
            for theta in [0.1, 0.5, 0.9] {
                let factor = begin_factor(begin, theta, 1.0, 1.0);
                for (rate, time) in [(1e-3, 1e-6), (7.0, 1e-5), (1e4, 30.0)] {
                    let found = begin_factor(begin, theta * rate * time, rate, time);
                    assert!((found / factor - 1.0).abs() < 1e-13, "{theta}");
                }
            }
        }
    }

    #[test]
    fn older_and_receding_contacts_are_left_alone() {
        for begin in [Begin::Jump, Begin::FourthRoot, Begin::SquareRoot] {
            assert_eq!(begin_factor(begin, 1.0, 1.0, 0.5), 1.0);
            assert_eq!(begin_factor(begin, 1e-9, -1.0, 0.5), 1.0);
            assert_eq!(begin_factor(begin, 1e-9, 1.0, 0.0), 1.0);
            assert_eq!(begin_factor(begin, 1e-300, 1.0, 1.0), 1.0);
            let largest = begin_factor(begin, 1e-280, 1.0, 1.0);
            assert!(largest > 0.0 && largest < 2100.0, "{largest}");
        }
    }
}
