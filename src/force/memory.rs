// SPDX-License-Identifier: MIT OR Apache-2.0
//! The memory of Kelvin-Voigt solids in the normal force: `viscosity memory` (docs/theory.md, section 3.1).
//!
//! Under a normal load a body is two Kelvin-Voigt elements in series, `1/E*(s) = 1/(4 G(s)) + 1/(4 K(s) + 4/3 G(s))` with
//! `G(s) = (E1 + eta1 s)/2` and `K(s) = E2 + eta2 s`; two bodies are four. In all
//!
//! ```text
//! E*(s) = E0 + D s + sum of R s/(s + 1/T)
//! ```
//!
//! with one relaxing part fewer than there are different relaxation times of the elements, at most three. With `h` the elastic force at
//! `E* = 1`, the growing contact has exactly (Lee and Radok 1960) `F = E0 h + D dh/dt + sum of R q`, `dq/dt = -q/T + dh/dt`.
//!
//! What is remembered of a part is the penetration `b` at which it would be at rest: `q = h(delta) - h(b)` while `b < delta`. The contact
//! is taken as a foundation of such elements side by side, as many as make Hertz' force, of which each lets go when its own force is zero: that is
//! Ting's receding contact (1966), were the whole distribution of their states known. Here that of a part is the one that it would have
//! at rest at `b`. Such a foundation has an energy, so no path takes more out of it than went in.
//!
//! # Example
//! ```
//! use ellgran::force::memory::{Part, MOST_PARTS};
//! use ellgran::force::syntax::parse;
//! use ellgran::force::PairLaw;
//!
//! // A Kelvin-Voigt solid has one relaxing part beside its spring and its dashpot.
//! let words = ["nfd", "1e7", "0.3", "2e3", "2e3", "viscosity", "memory"];
//! let (parameters, _) = parse(&words)?;
//! let law = PairLaw::resolve(&parameters, &parameters)?;
//! let memory = &law.constants.memory;
//! let count = law.kinds.normal.memory as usize;
//! assert!(count >= 1 && count <= MOST_PARTS);
//! let parts: [Part; MOST_PARTS] = memory.parts();
//! let added: f64 = parts[..count].iter().map(|part| part.ratio / part.rate).sum();
//! assert!((memory.relaxing_time() / added - 1.0).abs() < 1e-14);
//! // In a step of any length it resists as its spring does at most, of this part of the static one.
//! let (spring, dashpot) = memory.springs_and_dashpots(count);
//! assert!((spring / (parts[0].share * parts[0].ratio) - 1.0).abs() < 1e-14 && dashpot == 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::choice::resolved_constants;
use super::hertz_factors::Factors;
use super::material::Material;
use super::normal::{per_power, NormalConstants, NormalForce};
use crate::real::Real;
#[cfg(not(feature = "std"))]
use alloc::vec::Vec;

/// The most relaxing parts that two bodies have.
pub const MOST_PARTS: usize = 3;

/// Elements that make up less of the compliance are left out: a rigid wall has no memory of its own.
const LEAST_SHARE: f64 = 1e-8;
/// Relaxation times of elements below this are 0: their squares would leave double precision.
const LEAST_TIME: f64 = 1e-100;
/// Relaxation times that differ by less are one.
const LEAST_DIFFERENCE: f64 = 1e-8;

resolved_constants! {
    $
    /// The relaxing parts of a pair of types. The contact is divided among them: part `k` has the share `share_k` of the static modulus
    /// and of the dashpot. All zero where there is no such part.
    MemoryConstants, memory_constants {
        /// Share of part 1: `R T` over the sum of all.
        share_1,
        /// `R/E0` of part 1 over its share.
        ratio_1,
        /// `1/T` of part 1, 1/time.
        rate_1,
        /// Share of part 2.
        share_2,
        /// `R/E0` of part 2 over its share.
        ratio_2,
        /// `1/T` of part 2, 1/time.
        rate_2,
        /// Share of part 3.
        share_3,
        /// `R/E0` of part 3 over its share.
        ratio_3,
        /// `1/T` of part 3, 1/time.
        rate_3,
    }
}

/// One relaxing part.
#[derive(Clone, Copy, Debug)]
pub struct Part<T = f64> {
    /// Its share of the static modulus and of the dashpot.
    pub share: T,
    /// The modulus that relaxes over that share of the static one.
    pub ratio: T,
    /// The inverse of its relaxation time, 1/time.
    pub rate: T,
}

impl<T: Copy> MemoryConstants<T> {
    /// The parts, those that there are first.
    #[inline(always)]
    pub fn parts(&self) -> [Part<T>; MOST_PARTS] {
        let part = |share, ratio, rate| Part { share, ratio, rate };
        [
            part(self.share_1, self.ratio_1, self.rate_1),
            part(self.share_2, self.ratio_2, self.rate_2),
            part(self.share_3, self.ratio_3, self.rate_3),
        ]
    }
}

/// `E*(s)` of two bodies: what the kernels take from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Relaxation {
    /// `D/E0`, time.
    pub dashpot_time: f64,
    /// How many relaxing parts there are.
    pub parts: usize,
    /// The parts.
    pub constants: MemoryConstants,
}

/// What of a part's resistance to fast motion counts as a spring, and what as a dashpot: both are bounds, and a part that is this many
/// times as stiff as the static spring is the dashpot that it becomes for slower motion.
const STIFFEST_SPRING: f64 = 30.0;

impl MemoryConstants {
    /// Nothing relaxes.
    pub const NONE: MemoryConstants = MemoryConstants {
        share_1: 0.0,
        ratio_1: 0.0,
        rate_1: 0.0,
        share_2: 0.0,
        ratio_2: 0.0,
        rate_2: 0.0,
        share_3: 0.0,
        ratio_3: 0.0,
        rate_3: 0.0,
    };

    /// What the relaxing parts add to the relaxation time of first order, `sum of R T/E0`, time.
    pub fn relaxing_time(&self) -> f64 {
        let time = |p: &Part| p.share * p.ratio / p.rate;
        self.parts()
            .iter()
            .filter(|p| p.share > 0.0)
            .map(time)
            .sum()
    }
}

impl<T: Real> MemoryConstants<T> {
    /// Bounds of what the relaxing parts add to the static spring, over it, and of their dashpots over it, time. In a step of any length
    /// a part resists no more than its spring `R` or its dashpot `R T` does: with the exponential of the step a motion that changes its
    /// sign in each meets `R tanh(z/2)/(z/2)`, `z` the step over `T`.
    #[inline(always)]
    pub fn springs_and_dashpots(&self, parts: usize) -> (T, T) {
        let zero = self.share_1.constant(0.0);
        let limit = zero.constant(STIFFEST_SPRING);
        let (mut spring, mut dashpot) = (zero, zero);
        for p in &self.parts()[..parts] {
            let stiffness = p.share * p.ratio;
            let is_dashpot = limit.less(stiffness);
            let time = stiffness / p.rate.max(zero.constant(1e-300));
            spring = spring + T::select(is_dashpot, zero, stiffness);
            dashpot = dashpot + T::select(is_dashpot, time, zero);
        }
        (spring, dashpot)
    }
}

/// The Kelvin-Voigt elements of a body under a normal load: compliances and relaxation times.
fn elements(m: &Material) -> [(f64, f64); 2] {
    let deviatoric = m.youngs_modulus / (1.0 + m.poissons_ratio);
    let nearly = 1.0 - 2.0 * m.poissons_ratio;
    // 4 G and 4 K + 4/3 G; of an incompressible body the second is rigid.
    let shear = (0.5 / deviatoric, m.shear_relaxation_time());
    let bulk = if nearly > 0.0 {
        let stiffness = 4.0 / 3.0 * m.youngs_modulus / nearly + 2.0 / 3.0 * deviatoric;
        let dashpot = 4.0 * m.bulk_viscosity + 2.0 / 3.0 * m.shear_viscosity;
        (1.0 / stiffness, dashpot / stiffness)
    } else {
        (0.0, 0.0)
    };
    [shear, bulk]
}

/// `E*(s)` of two bodies.
pub(super) fn relaxation(i: &Material, j: &Material) -> Relaxation {
    let elements_of =
        |m| elements(m).map(|(c, time)| (c, if time < LEAST_TIME { 0.0 } else { time }));
    let all: Vec<(f64, f64)> = [i, j].into_iter().flat_map(elements_of).collect();
    let compliance: f64 = all.iter().map(|e| e.0).sum();
    let mut sorted: Vec<(f64, f64)> = all
        .into_iter()
        .filter(|e| e.0 > LEAST_SHARE * compliance)
        .collect();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut elements: Vec<(f64, f64)> = Vec::new();
    for (c, time) in sorted {
        match elements.last_mut() {
            Some(last) if time - last.1 <= LEAST_DIFFERENCE * time => {
                last.1 = (last.0 * last.1 + c * time) / (last.0 + c);
                last.0 += c;
            }
            _ => elements.push((c, time)),
        }
    }
    let compliance: f64 = elements.iter().map(|e| e.0).sum();
    let inverse_dashpot: f64 = elements.iter().map(|(c, time)| c / time).sum();
    let dashpot_time = if elements[0].1 > 0.0 {
        compliance / inverse_dashpot
    } else {
        0.0
    };
    // Between two relaxation times of elements lies one of E*: a zero of the sum of c/(T - time), which falls from infinity to minus
    // infinity there. So all are real and positive, and so are their moduli.
    let parts: Vec<(f64, f64)> = elements
        .windows(2)
        .map(|pair| {
            let sum = |t: f64| -> f64 { elements.iter().map(|(c, time)| c / (t - time)).sum() };
            let (mut low, mut high) = (pair[0].1, pair[1].1);
            loop {
                let middle = low + 0.5 * (high - low);
                if !(low < middle && middle < high) {
                    break;
                }
                if sum(middle) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let t = if low > pair[0].1 { low } else { high };
            let slope: f64 = elements
                .iter()
                .map(|(c, time)| c * time / ((t - time) * (t - time)))
                .sum();
            // R T/E0 and T.
            (compliance / slope, t)
        })
        .collect();
    let whole: f64 = parts.iter().map(|p| p.0).sum();
    let mut numbers = [[0.0; 3]; MOST_PARTS];
    for ((time, t), part) in parts.iter().zip(&mut numbers) {
        *part = [time / whole, whole / t, 1.0 / t];
    }
    let [a, b, c] = numbers;
    Relaxation {
        dashpot_time,
        parts: parts.len(),
        constants: MemoryConstants {
            share_1: a[0],
            ratio_1: a[1],
            rate_1: a[2],
            share_2: b[0],
            ratio_2: b[1],
            rate_2: b[2],
            share_3: c[0],
            ratio_3: c[1],
            rate_3: c[2],
        },
    }
}

/// How far the penetration of rest may be ahead of the bodies, over where no element touches any more: a little further, so that the
/// force is 0 there whatever the rounding.
const FURTHEST_BEHIND: f64 = 1.0 + 1e-9;

/// The motion of a contact in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach<T> {
    /// Penetration > 0.
    pub penetration: T,
    /// What it was a step ago, or 0 where the contact began within the step.
    pub before: T,
    /// Time since then.
    pub time: T,
    /// Rate of penetration, positive on approach, that the dashpot has.
    pub rate: T,
}

/// A part, or all of them, in units of `E0 h` at a penetration of 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartForce<T> {
    /// Force, of no sign but the positive one.
    pub force: T,
    /// The force without the dashpot: the derivative of the energy.
    pub elastic: T,
    /// The root of the penetration that has the contact's area: of static stiffness 3/2 of it.
    pub root: T,
    /// Energy that is held.
    pub energy: T,
    /// Energy that the relaxing part dissipated in the step.
    pub relaxed: T,
    /// The penetration at which the part would be at rest.
    pub rest: T,
}

/// One part from one step to the next; `rest` is what it remembers. `dashpot_time` is `D/E0`.
///
/// While `rest` lies below the penetration the part relaxes exactly as the growing contact's does, for a force that changes
/// linearly in the step, else as Ting's condition does, for a penetration that changes linearly. Where no element touches any more the
/// penetration of rest follows the bodies, so that the energy is gone when they part.
#[inline(always)]
pub(crate) fn part_force<T: Real>(
    part: &Part<T>,
    dashpot_time: T,
    approach: &Approach<T>,
    rest: T,
) -> PartForce<T> {
    let d = approach.penetration;
    let (zero, one) = (d.constant(0.0), d.constant(1.0));
    let a = part.ratio;
    let (kept, share) = decay(part.rate * approach.time);
    let root = d.sqrt();
    let (power, power_before) = (root * d, approach.before.sqrt() * approach.before);
    let root_of_rest = rest.sqrt();
    // How far the part is from rest: ahead in h, behind in the penetration.
    let ahead = kept * (power_before - root_of_rest * rest) + share * (power - power_before);
    let behind = kept * (approach.before - rest) + share * (d - approach.before);
    let is_ahead = zero.less(ahead);
    let ahead = ahead.max(zero).min(power);
    let behind = behind
        .min(zero)
        .max(d / a.max(one * 1e-290) * -FURTHEST_BEHIND);
    // The penetration of rest, from h(b) = h(d) - ahead, and d - b without cancellation.
    let new_root = root * cube_root((power - ahead) / power.max(one * 1e-290));
    let product = root * new_root;
    let root_apart = ahead / (d + product + new_root * new_root);
    let new_rest = T::select(is_ahead, new_root * new_root, d - behind);
    // Where no time has passed nothing is to change, not by a rounding either.
    let new_rest = T::select(zero.less(approach.time), new_rest, rest);
    let apart = T::select(is_ahead, (root + new_root) * root_apart, behind);

    let ahead = T::select(is_ahead, ahead, zero);
    let a_behind = a * apart.min(zero);
    let at_rest = (d + a_behind).max(zero);
    let at_rest_root = at_rest.sqrt();
    let elastic = a.multiply_add(ahead, at_rest_root * at_rest);
    // Elements of which the force is not zero: all up to the edge.
    let receding = dashpot_time * approach.rate.min(zero);
    let edge = (receding / (a + 1.0) + d).min(a.multiply_add(apart, receding + d));
    let edge = edge.max(zero);
    let edge_root = edge.sqrt();
    let edge_power = edge_root * edge;
    let growing = dashpot_time * 1.5 * edge_root * approach.rate.max(zero);
    // On approach the edge is that of the elastic force.
    let force = (ahead - (power - edge_power)).max(zero);
    let force = a.multiply_add(force, edge_power) + growing;
    let held = energy(a, d, new_rest);
    let loss = energy(a, d, rest) - held;
    let loss_before = energy(a, approach.before, rest) - energy(a, approach.before, new_rest);
    PartForce {
        force,
        elastic,
        root: edge_root,
        energy: held,
        relaxed: (loss + loss_before) * 0.5,
        rest: new_rest,
    }
}

/// The normal force of a contact with memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForceWithMemory<T = f64> {
    /// Force, and what other parts of the law take from it. The elastic force is what the foundation would have at rest; its energy
    /// is that of all springs.
    pub normal: NormalForce<T>,
    /// What the parts remember, penetrations of rest.
    pub rests: [T; MOST_PARTS],
    /// Energy that the relaxing parts dissipated in the step.
    pub relaxed: T,
}

/// The force of all parts, as [`super::normal_force`] states it. Never attractive.
#[inline(always)]
pub(crate) fn normal_force_with_memory<T: Real>(
    parts: usize,
    c: &NormalConstants<T>,
    memory: &MemoryConstants<T>,
    approach: &Approach<T>,
    rests: [T; MOST_PARTS],
    determinant: T,
    factors: &Factors<T>,
) -> ForceWithMemory<T> {
    let zero = approach.penetration.constant(0.0);
    let [mut force, mut elastic, mut root, mut energy, mut relaxed] = [zero; 5];
    let mut new_rests = rests;
    let all = memory.parts();
    for k in 0..MOST_PARTS {
        if k >= parts {
            break;
        }
        let share = all[k].share;
        let found = part_force(&all[k], c.damping, approach, rests[k]);
        force = share.multiply_add(found.force, force);
        elastic = share.multiply_add(found.elastic, elastic);
        root = share.multiply_add(found.root, root);
        energy = share.multiply_add(found.energy, energy);
        relaxed = share.multiply_add(found.relaxed, relaxed);
        new_rests[k] = found.rest;
    }
    let unit = per_power(c.stiffness, determinant, factors);
    ForceWithMemory {
        normal: NormalForce {
            force: unit * force,
            elastic: unit * elastic,
            stiffness: unit * root * 1.5,
            elastic_energy: unit * energy,
        },
        rests: new_rests,
        relaxed: unit * relaxed,
    }
}

/// Energy of a part at a penetration and a penetration of rest, in units of `E0 h` at a penetration of 1 times length.
#[inline(always)]
fn energy<T: Real>(a: T, d: T, rest: T) -> T {
    let zero = d.constant(0.0);
    let (r, t) = (d.sqrt(), rest.sqrt());
    let hertz = d * d * r * 0.4;
    // 0.4 r^5 - r^2 t^3 + 0.6 t^5
    let apart = r - t;
    let beside = (r * r * r).multiply_add(
        d.constant(0.4),
        r * t * (r * 0.8 + t * 1.2) + t * t * t * 0.6,
    );
    let ahead = a.multiply_add(apart * apart * beside, hertz);
    let touching = a.multiply_add(d - rest, d).max(zero);
    let behind = touching * touching * touching.sqrt();
    let behind = a.multiply_add(rest * rest * t, behind) * 0.4 / (a + 1.0);
    T::select(d.less(rest), behind, ahead)
}

/// `exp(-z)` and its mean from 0 to `z`, `(1 - exp(-z))/z`, for `z >= 0`; to 1e-15, the first absolutely.
#[inline(always)]
fn decay<T: Real>(z: T) -> (T, T) {
    const DOUBLINGS: i32 = 6;
    const END: f64 = 40.0;
    let one = z.constant(1.0);
    let near = z.min(one * END);
    let y = near * (1.0 / (1 << DOUBLINGS) as f64);
    // (1 - exp(-y))/y by its series, y at most 0.625.
    let mut mean = one * (1.0 / 15.0);
    for k in (2..15).rev() {
        mean = (y * mean).negative_multiply_add(one, one) * (1.0 / k as f64);
    }
    let mut mean = (y * mean).negative_multiply_add(one, one);
    let mut y = y;
    for _ in 0..DOUBLINGS {
        // exp(-y) = 1 - y mean
        mean = mean - mean * mean * y * 0.5;
        y = y + y;
    }
    let kept = y.negative_multiply_add(mean, one).max(z.constant(0.0));
    let far = mean * (near / z.max(one * 1e-290));
    (kept, T::select(one.constant(END).less(z), far, mean))
}

/// Cube root of a number from 0 to 1; 0 below 1e-280.
#[inline(always)]
fn cube_root<T: Real>(x: T) -> T {
    const SQUARINGS: i32 = 9;
    let one = x.constant(1.0);
    let least = one * 1e-280;
    let far = x.max(least);
    // exp(ln(x)/3) to some 1e-6, then Halley's step, which is of third order.
    let z = far.ln() * (1.0 / (3.0 * (1 << SQUARINGS) as f64));
    let mut power = one * (1.0 / 8.0);
    for k in (1..8).rev() {
        power = (z * power).multiply_add(one, one) * (1.0 / k as f64);
    }
    let mut y = (z * power).multiply_add(one, one);
    for _ in 0..SQUARINGS {
        y = y * y;
    }
    let cube = y * y * y;
    let y = y * ((cube + far + far) / (cube + cube + far));
    T::select(x.less(least), x.constant(0.0), y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_and_their_means() {
        assert_eq!(decay(0.0), (1.0, 1.0));
        for k in 0..2000 {
            let z = 10f64.powf(-12.0 + 0.01 * k as f64);
            let (kept, mean) = decay(z);
            assert!((kept - (-z).exp()).abs() < 1e-15, "{z}");
            assert!((mean * z / -(-z).exp_m1() - 1.0).abs() < 2e-15, "{z}");
        }
    }

    #[test]
    fn cube_roots() {
        assert_eq!((cube_root(0.0), cube_root(1e-281)), (0.0, 0.0));
        for k in 0..3000 {
            let x = 10f64.powf(-0.093 * k as f64);
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 2e-15, "{x}");
        }
    }

    /// A contact that is drawn back until nothing touches has no force and no area, on any instruction set.
    #[test]
    fn where_nothing_touches_there_is_nothing() {
        for k in 0..1000 {
            let part = Part {
                share: 1.0,
                ratio: 0.013 * (k + 1) as f64,
                rate: 1e-3,
            };
            let back = Approach {
                penetration: 0.1 + 1e-4 * k as f64,
                before: 10.0,
                time: 1e-3,
                rate: 0.0,
            };
            let found = part_force(&part, 0.5, &back, 1e4);
            assert_eq!([found.force, found.elastic, found.root], [0.0; 3]);
            assert!(found.rest > back.penetration && found.energy > 0.0);
        }
    }

    /// Work along any way between two penetrations is the change of the energy where nothing relaxes: the elastic force is its derivative.
    #[test]
    fn the_elastic_force_is_the_derivative_of_the_energy() {
        let part = Part {
            share: 1.0,
            ratio: 0.7,
            rate: 1.0,
        };
        for rest in [0.0, 0.3, 0.9, 1.1, 1.9, 2.3] {
            for d in [0.2, 0.7, 1.0, 1.5] {
                let at = |d: f64| {
                    let still = Approach {
                        penetration: d,
                        before: d,
                        time: 0.0,
                        rate: 0.0,
                    };
                    part_force(&part, 0.0, &still, rest)
                };
                let h = 1e-5;
                let slope = (at(d + h).energy - at(d - h).energy) / (2.0 * h);
                let found = at(d);
                assert!((found.elastic - slope).abs() < 1e-8, "{d}, {rest}");
                assert!((found.force - found.elastic).abs() < 1e-12, "{d}, {rest}");
                assert_eq!(found.rest, rest);
            }
        }
    }

    /// The foundation of docs/theory.md, section 3.1, spring by spring: each of its gap `g` carries `h''(g) dg`, and lets go where its
    /// force vanishes. Force, force at rest, root of the area and energy, by the midpoint rule.
    fn foundation(
        a: f64,
        dashpot_time: f64,
        (penetration, rate): (f64, f64),
        rest: f64,
    ) -> [f64; 4] {
        let count = 10_000;
        let furthest = penetration.max(rest).sqrt();
        let mut sums = [0.0; 4];
        for k in 0..count {
            // With g = u^2 all springs of the same du are equally stiff.
            let u = (k as f64 + 0.5) / count as f64 * furthest;
            let gap = u * u;
            let stiffness = 1.5 * furthest / count as f64;
            let (way, remembered) = (penetration - gap, (rest - gap).max(0.0));
            let at_rest = way + a * (way - remembered);
            let with_dashpot = at_rest + dashpot_time * rate;
            if way > 0.0 && at_rest > 0.0 {
                sums[1] += stiffness * at_rest;
                if rate > 0.0 || with_dashpot > 0.0 {
                    sums[0] += stiffness * with_dashpot;
                    sums[2] += stiffness / 1.5;
                }
            }
            // One that has let go is where its own force vanishes, at the penetration of the bodies or further out.
            let free = a * remembered / (1.0 + a);
            let x = way.max(free);
            sums[3] += stiffness * 0.5 * (x * x + a * (x - remembered).powi(2));
        }
        sums
    }

    /// Force, area and energy of a part against the sum over the springs: ahead of its rest, behind it, and where springs have let go.
    #[test]
    fn a_part_is_the_sum_of_its_springs() {
        let mut least_edge: f64 = 1.0;
        for a in [0.3, 2.0, 9.0] {
            let part = Part {
                share: 1.0,
                ratio: a,
                rate: 1.0,
            };
            for rest in [0.0, 0.2, 0.95, 1.0, 1.05, 1.3, 1.8] {
                for speed in [-0.5, -0.1, 0.0, 0.2] {
                    let now = Approach {
                        penetration: 1.0,
                        before: 1.0,
                        time: 0.0,
                        rate: speed,
                    };
                    let dashpot_time = 0.7;
                    let found = part_force(&part, dashpot_time, &now, rest);
                    let wanted = foundation(a, dashpot_time, (1.0, speed), rest);
                    let got = [found.force, found.elastic, found.root, found.energy];
                    for (k, (got, wanted)) in got.into_iter().zip(wanted).enumerate() {
                        // The spring at an edge counts or does not.
                        let allowed = 2e-4 * (1.0 + wanted);
                        assert!(
                            (got - wanted).abs() < allowed,
                            "{k}: a {a}, rest {rest}, rate {speed}: {got} {wanted}"
                        );
                    }
                    least_edge = least_edge.min(found.root);
                }
            }
        }
        assert_eq!(least_edge, 0.0);
    }

    /// What a part is ahead by decays in `h`, what it is behind by in the penetration, each exactly for a motion that is linear in it.
    #[test]
    fn a_part_relaxes_as_its_equation_says() {
        let (a, rate, time) = (1.5, 2.0, 0.3f64);
        let part = Part {
            share: 1.0,
            ratio: a,
            rate,
        };
        let power = |x: f64| x * x.sqrt();
        let kept = (-rate * time).exp();
        let mean = (1.0 - kept) / (rate * time);
        let after = |before: f64, now: f64, rest: f64| {
            let approach = Approach {
                penetration: now,
                before,
                time,
                rate: 0.0,
            };
            part_force(&part, 0.0, &approach, rest).rest
        };
        for (before, now) in [(0.0, 0.7), (0.8, 1.1), (1.1, 0.9), (1.0, 1.0)] {
            for rest in [0.0, 0.1, 0.5] {
                let ahead =
                    kept * (power(before) - power(rest)) + mean * (power(now) - power(before));
                if ahead < 0.0 {
                    continue;
                }
                let wanted = power(now) - ahead;
                let found = power(after(before, now, rest));
                assert!((found - wanted).abs() < 1e-14, "{before} {now} {rest}");
            }
        }
        for (before, now, rest) in [(1.0, 1.0, 1.3), (1.0, 0.8, 1.2), (1.0, 1.02, 1.5)] {
            let behind = kept * (before - rest) + mean * (now - before);
            let found = after(before, now, rest);
            assert!(
                (now - behind - found).abs() < 1e-14,
                "{before} {now} {rest}"
            );
        }
    }

    /// Held, a part loses to relaxation what its energy falls by; in motion so in the limit of small steps.
    #[test]
    fn what_relaxes_is_what_the_energy_falls_by() {
        let part = Part {
            share: 1.0,
            ratio: 1.5,
            rate: 2.0,
        };
        for rest in [0.0, 0.4, 1.2] {
            let held = Approach {
                penetration: 1.0,
                before: 1.0,
                time: 0.4,
                rate: 0.0,
            };
            let still = Approach { time: 0.0, ..held };
            let before = part_force(&part, 0.0, &still, rest).energy;
            let found = part_force(&part, 0.0, &held, rest);
            assert!(found.relaxed > 1e-3 * before);
            assert!(
                (before - found.energy - found.relaxed).abs() < 1e-14,
                "{rest}"
            );
        }
        // Out and back, in steps: work = energy + what relaxed.
        let open = [200, 800].map(|steps| {
            let (mut rest, mut energy, mut work, mut relaxed, mut force) =
                (0.0, 0.0, 0.0, 0.0, 0.0);
            let mut before = 0.0;
            for k in 1..=steps {
                let t = k as f64 / steps as f64;
                let now = (3.0 * t).sin().powi(2);
                let approach = Approach {
                    penetration: now,
                    before,
                    time: 1.0 / steps as f64,
                    rate: 0.0,
                };
                let found = part_force(&part, 0.0, &approach, rest);
                work += 0.5 * (force + found.elastic) * (now - before);
                relaxed += found.relaxed;
                (rest, energy, force, before) = (found.rest, found.energy, found.elastic, now);
            }
            (work - relaxed - energy).abs()
        });
        println!("balance open by {open:?}");
        assert!(open[1] < 1e-4 && open[1] < open[0] / 6.0, "{open:?}");
    }
}
