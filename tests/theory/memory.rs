// SPDX-License-Identifier: MIT OR Apache-2.0
//! `viscosity memory`: the modulus of two bodies over frequency, the loading of Lee and Radok against the convolution, the receding
//! contact in its limits, and what is remembered.

use crate::support::random::Stream;
use crate::support::scene::{advance, body, laws, pair_law, Felt, Memory, Rotation, Vector};
use ellgran::contact::{Body, Laws};
use ellgran::force::PairLaw;

/// `E*(s)` of a pair: static, dashpot, and of each relaxing part its modulus and its time.
struct Modulus {
    fixed: f64,
    dashpot: f64,
    parts: Vec<(f64, f64)>,
}

impl Modulus {
    fn of(law: &PairLaw) -> Modulus {
        let fixed = law.effective_modulus();
        let parts = &law.constants.memory.parts()[..law.kinds.normal.memory as usize];
        Modulus {
            fixed,
            dashpot: fixed * law.constants.normal.damping,
            parts: parts
                .iter()
                .map(|p| (fixed * p.share * p.ratio, 1.0 / p.rate))
                .collect(),
        }
    }

    fn at(&self, s: f64) -> f64 {
        let relaxing = self.parts.iter().map(|(r, t)| r * s / (s + 1.0 / t));
        self.fixed + self.dashpot * s + relaxing.sum::<f64>()
    }
}

/// `1/E*(s)` of a body by its moduli.
fn compliance([e, nu, eta1, eta2]: [f64; 4], s: f64) -> f64 {
    let g = 0.5 * (e / (1.0 + nu) + eta1 * s);
    let k = e / (3.0 * (1.0 - 2.0 * nu)) + eta2 * s;
    (3.0 * k + 4.0 * g) / (4.0 * g * (3.0 * k + g))
}

fn deck([e, nu, eta1, eta2]: [f64; 4]) -> String {
    format!("nfd {e:e} {nu} {eta1:e} {eta2:e} viscosity memory")
}

/// At any frequency the parts are the modulus that the moduli of the two bodies make.
#[test]
fn the_parts_are_the_modulus_of_the_solids() {
    let mut stream = Stream::new(3);
    let mut most: f64 = 0.0;
    for k in 0..400 {
        let mut material = || {
            let e = stream.log_uniform(1e2, 1e9);
            [
                e,
                stream.uniform(-0.4, 0.49),
                e * stream.log_uniform(1e-6, 1e-2),
                e * stream.log_uniform(1e-6, 1e-2),
            ]
        };
        let (a, b) = (material(), material());
        let b = match k % 4 {
            // The same, elastic, of shear alone.
            0 => a,
            1 => [b[0], b[1], 0.0, 0.0],
            2 => [b[0], b[1], b[2], 0.0],
            _ => b,
        };
        let laws = laws(&[&deck(a), &deck(b)]);
        let law = laws.get(1, 2);
        let modulus = Modulus::of(law);
        assert!(modulus.parts.iter().all(|(r, t)| *r >= 0.0 && *t > 0.0));
        let count = [1, 2, 3, 3][k % 4];
        assert!(modulus.parts.len() <= count, "{}", modulus.parts.len());
        // An element of less than 1e-8 of the compliance is left out, and then a high frequency sees no spring there.
        for s in [1e-2, 1.0, 1e2, 1e4, 1e6, 1e8] {
            let wanted = 1.0 / (compliance(a, s) + compliance(b, s));
            let error = (modulus.at(s) / wanted - 1.0).abs();
            let stiff = (a[0] / b[0]).max(b[0] / a[0]);
            if stiff < 1e4 {
                most = most.max(error);
            }
            assert!(error < 1e-6 || stiff > 1e4, "{a:?} {b:?} s {s}: {error:e}");
        }
        // Of first order it is the closure `energy`.
        let first = laws_of_first_order(a, b);
        let time = first.get(1, 2).normal_relaxation_time();
        assert!((law.normal_relaxation_time() / time - 1.0).abs() < 1e-7);
    }
    println!("E*(s) is right to {most:.1e}");
    assert!(most < 1e-9);
}

fn laws_of_first_order(a: [f64; 4], b: [f64; 4]) -> Laws {
    let [a, b] = [a, b].map(|m| deck(m).replace(" viscosity memory", ""));
    laws(&[&a, &b])
}

/// Proportional viscosity and an incompressible body have no memory; then the law is that of first order, to the bit.
#[test]
fn without_a_relaxing_part_it_is_the_law_of_first_order() {
    let tau = 1e-3;
    for nu in [0.0, 0.3, 0.5] {
        let (eta1, eta2) = (tau * 1e6 / (1.0 + nu), tau * 1e6 / (3.0 * (1.0 - 2.0 * nu)));
        let eta2 = if nu == 0.5 { 77.0 } else { eta2 };
        let law = pair_law(&deck([1e6, nu, eta1, eta2]));
        assert_eq!(law.kinds.normal.memory, 0, "nu {nu}");
        assert!((law.normal_relaxation_time() / tau - 1.0).abs() < 1e-12);
    }
}

/// A rigid wall takes no part: the memory is that of one body.
#[test]
fn a_rigid_body_adds_no_part() {
    let soft = [1e6, 0.3, 100.0, 300.0];
    let laws = laws(&[&deck(soft), &deck([1e50, 0.3, 0.0, 0.0])]);
    let law = laws.get(1, 2);
    assert_eq!(law.kinds.normal.memory, 1);
    let modulus = Modulus::of(law);
    for s in [1.0, 1e3, 1e6] {
        let wanted = 1.0 / compliance(soft, s);
        assert!((modulus.at(s) / wanted - 1.0).abs() < 1e-12);
    }
}

/// Two spheres of radius 1 that are led along their line of centres.
struct Led<'a> {
    laws: &'a Laws,
    types: [i32; 2],
    memory: Memory,
    depth: f64,
}

impl<'a> Led<'a> {
    fn new(laws: &'a Laws) -> Self {
        Led {
            laws,
            types: [1, laws.types() as i32],
            memory: Memory::new(laws),
            depth: 0.0,
        }
    }

    fn bodies(&self, depth: f64, rate: f64) -> [Body; 2] {
        let mut i = body([1.0; 3], Vector::zeros(), Rotation::identity());
        let mut j = i;
        [i.particle_type, j.particle_type] = self.types;
        j.position = [2.0 - depth, 0.0, 0.0];
        j.velocity = [-rate, 0.0, 0.0];
        [i, j]
    }

    /// In a step of this length, linearly; `rate` is what the force sees.
    fn to(&mut self, depth: f64, time: f64) -> Option<Felt> {
        let rate = if time > 0.0 {
            (depth - self.depth) / time
        } else {
            0.0
        };
        let [i, j] = self.bodies(depth, rate);
        self.depth = depth;
        advance(self.laws, &i, &j, time, &mut self.memory)
    }

    fn force(&mut self, depth: f64, time: f64) -> f64 {
        self.to(depth, time).map_or(0.0, |f| f.forces.normal_force)
    }
}

/// `F = c E* delta^(3/2)` of two unit spheres.
const COEFFICIENT: f64 = 4.0 / 3.0 * core::f64::consts::FRAC_1_SQRT_2;

/// What `exp(-(t - s)/T)` and the rate of `delta^(3/2)` make up to `t`, for `delta = v s^p`: by quadrature.
fn convolution(v: f64, power: f64, t: f64, time: f64) -> f64 {
    // s = t u^2 takes the root away; Gauss' points of two panels of 8 would do, many of the midpoint rule are simpler.
    let panels = 20_000;
    let sum: f64 = (0..panels)
        .map(|k| {
            let u = (k as f64 + 0.5) / panels as f64;
            let s = t * u * u;
            let rate = 1.5 * power * v.powf(1.5) * s.powf(1.5 * power - 1.0);
            (-(t - s) / time).exp() * rate * 2.0 * t * u
        })
        .sum();
    sum / panels as f64
}

/// Loading against the convolution (Lee and Radok 1960), along a ramp and along a square root: one number per part is the whole memory.
#[test]
fn loading_is_the_convolution() {
    let soft = [1e5, 0.1, 20.0, 700.0];
    let other = [3e5, 0.4, 900.0, 10.0];
    for decks in [vec![deck(soft)], vec![deck(soft), deck(other)]] {
        let decks: Vec<&str> = decks.iter().map(String::as_str).collect();
        let laws = laws(&decks);
        let modulus = Modulus::of(laws.get(1, decks.len()));
        let slowest = modulus.parts.iter().fold(0.0, |a: f64, p| a.max(p.1));
        for power in [1.0, 0.8, 2.0] {
            let errors = [400, 1600].map(|steps| {
                let end = 2.0 * slowest;
                let v = 1e-3 / end.powf(power);
                let mut led = Led::new(&laws);
                let mut most: f64 = 0.0;
                for k in 1..=steps {
                    let t = end * k as f64 / steps as f64;
                    let depth = v * t.powf(power);
                    let [i, j] = led.bodies(depth, (depth - led.depth) * steps as f64 / end);
                    led.depth = depth;
                    let felt = advance(&laws, &i, &j, end / steps as f64, &mut led.memory).unwrap();
                    if k % (steps / 4) != 0 {
                        continue;
                    }
                    // The dashpot sees the mean rate of the step, not that at its end: it is compared apart.
                    let seen = felt.forces.viscous_force.x;
                    let wanted: f64 = modulus
                        .parts
                        .iter()
                        .map(|(r, time)| r * convolution(v, power, t, *time))
                        .sum::<f64>()
                        + modulus.fixed * depth.powf(1.5);
                    let got = felt.forces.normal_force - seen;
                    most = most.max((got / (COEFFICIENT * wanted) - 1.0).abs());
                }
                most
            });
            println!("delta ~ t^{power}, {} types: {errors:?}", decks.len());
            assert!(
                errors[1] < 1e-5 && errors[1] < errors[0] / 4.0,
                "{errors:?}"
            );
        }
    }
}

/// A contact that is held relaxes exactly, in one step or in many.
#[test]
fn relaxation_at_rest_does_not_depend_on_the_step() {
    let laws = laws(&[
        &deck([1e5, 0.1, 20.0, 700.0]),
        &deck([3e5, 0.4, 900.0, 10.0]),
    ]);
    let modulus = Modulus::of(laws.get(1, 2));
    let end = 3.0 * modulus.parts[1].1;
    let held = |steps: usize| {
        let mut led = Led::new(&laws);
        led.to(1e-3, 1e-3 * end);
        let first = led.force(1e-3, 0.0);
        let mut last = first;
        for _ in 0..steps {
            last = led.force(1e-3, end / steps as f64);
        }
        (first, last)
    };
    let (first, once) = held(1);
    let (_, often) = held(777);
    println!("held: {first} relaxes to {once} in one step, {often} in 777");
    assert!((once / often - 1.0).abs() < 1e-13 && first > 1.1 * once);
    // What is left of each part.
    let mean = |x: f64| -(-x).exp_m1() / x;
    let wanted: f64 = modulus.fixed
        + modulus
            .parts
            .iter()
            .map(|(r, t)| r * mean(1e-3 * end / t) * (-end / t).exp())
            .sum::<f64>();
    assert!((once / (COEFFICIENT * wanted * 1e-3f64.powf(1.5)) - 1.0).abs() < 1e-12);
}

/// Slow motion is that of first order, to second order in the rate, approaching and receding.
#[test]
fn slow_motion_is_of_first_order() {
    let material = [1e5, 0.2, 20.0, 700.0];
    let (with, first) = (
        laws(&[&deck(material)]),
        laws_of_first_order(material, material),
    );
    let time = with.get(1, 1).normal_relaxation_time();
    let error = |slow: f64| {
        let steps = 4000;
        let end = time / slow;
        let mut most = [0.0f64; 2];
        let (mut a, mut b) = (Led::new(&with), Led::new(&first));
        for k in 1..steps {
            let t = (k as f64 / steps as f64 * core::f64::consts::PI).sin();
            let depth = 1e-3 * t;
            let (fa, fb) = (
                a.force(depth, end / steps as f64),
                b.force(depth, end / steps as f64),
            );
            let part = usize::from(2 * k > steps);
            most[part] = most[part].max((fa - fb).abs());
        }
        let largest = COEFFICIENT * with.get(1, 1).effective_modulus() * 1e-3f64.powf(1.5);
        most.map(|m| m / largest)
    };
    let (slow, slower) = (error(0.01), error(0.001));
    println!("A/time 0.01: {slow:?}, 0.001: {slower:?}");
    for (a, b) in slow.into_iter().zip(slower) {
        // Near the touch the rate over the penetration is not small: there the power is 3/2.
        assert!(a < 1e-2 && b < a / 20.0, "{a} {b}");
    }
}

/// Force and energy pass from one branch of the law to the other without a jump, and what the contact gives back is never more than it
/// got. After any cycle what it held is gone when the bodies part.
#[test]
fn force_and_energy_are_continuous() {
    let material = [1e5, 0.1, 20.0, 700.0];
    let laws = laws(&[&deck(material)]);
    let time = laws.get(1, 1).normal_relaxation_time();
    for (period, cycles) in [(0.3, 3.0), (3.0, 3.0), (30.0, 2.0)] {
        let largest = COEFFICIENT * laws.get(1, 1).effective_modulus() * 1e-3f64.powf(1.5);
        let jumps = [2000, 8000].map(|steps| {
            let step = period * time / steps as f64;
            let mut led = Led::new(&laws);
            let (mut force, mut energy, mut jump) = (0.0, 0.0, 0.0f64);
            let (mut work, mut dissipated) = (0.0, 0.0);
            for k in 1..=(cycles * steps as f64) as usize {
                let t = k as f64 / steps as f64 * core::f64::consts::TAU;
                // Deep, shallow, apart for a while.
                let depth = 1e-3 * (0.3 - 0.5 * t.cos() + 0.2 * (3.0 * t).sin());
                let before = led.depth.max(0.0);
                let felt = led.to(depth, step);
                let (f, e, relaxed, power) = felt.map_or((0.0, 0.0, 0.0, 0.0), |f| {
                    let f = f.forces;
                    (
                        f.normal_force,
                        f.elastic_energy,
                        f.relaxed_energy,
                        f.viscous_power,
                    )
                });
                assert!(f >= 0.0 && e >= 0.0);
                jump = jump.max((f - force).abs()).max((e - energy).abs() / 1e-3);
                work += 0.5 * (f + force) * (depth.max(0.0) - before);
                dissipated += relaxed + power * step;
                assert!(
                    work - e > -1e-3 * largest * 1e-3,
                    "period {period}: {work} {e}"
                );
                (force, energy) = (f, e);
            }
            let open = (work - dissipated - energy) / (largest * 1e-3);
            println!(
                "period {period}, {steps} steps: jump {:.1e}, balance open by {open:.1e}",
                jump / largest
            );
            (jump / largest, open.abs())
        });
        // The dashpot's force begins as the root of the time.
        assert!(jumps[1].0 < 0.6 * jumps[0].0, "{jumps:?}");
        assert!(jumps[1].1 < 0.5 * jumps[0].1.max(1e-4), "{jumps:?}");
    }
}

/// The exchanged contact remembers the same, and a contact that ends forgets.
#[test]
fn what_is_remembered() {
    let laws = laws(&[
        &deck([1e5, 0.1, 20.0, 700.0]),
        &deck([3e5, 0.4, 900.0, 10.0]),
    ]);
    let layout = laws.layout();
    assert_eq!(layout.rest_count, 3);
    let at = layout.rests.unwrap();
    let mut led = Led::new(&laws);
    for k in 1..10 {
        led.to(1e-4 * k as f64, 1e-4);
    }
    let rests = &led.memory.history[at..at + 3];
    assert!(rests.iter().all(|b| 0.0 < *b && *b < 9e-4), "{rests:?}");
    let mut other = vec![0.0; layout.length];
    layout.swap(&led.memory.history, &mut other);
    assert_eq!(rests, &other[at..at + 3]);
    assert!(led.to(-1e-4, 1e-4).is_none());
    assert_eq!(&led.memory.history[at..at + 3], &[0.0; 3]);
}
