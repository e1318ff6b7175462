// SPDX-License-Identifier: MIT OR Apache-2.0
//! Nothing but numbers, and soon: coincident centres, needles and discs, deep overlap, rest.

use crate::support::random::Stream;
use crate::support::scene::{
    advance, body, force_scale, laws, pair_law, position, rotation, size, Felt, Memory, Vector,
};
use crate::support::strategies::{deck, direction, turn};
use ellgran::contact::Body;
use ellgran::force::{
    force_of_springs, hertz_factors, tangential_force, Displacement, Factors, PairLaw, Springs,
    TangentialConstants, SPRINGS,
};
use ellgran::real::Real;
use ellgran::simd::{InstructionSet, Lanes, Registers, Stage, MOST_LANES};
use ellgran::vector::{Symmetric2, Vector2};
use proptest::prelude::*;
use std::time::{Duration, Instant};

fn finite(f: &Felt) -> bool {
    let numbers = [
        f.force,
        f.torque_i,
        f.torque_j,
        f.tangential,
        f.normal,
        f.contact_point,
    ];
    let scalars = [
        f.geometry.penetration,
        f.geometry.curvature_a,
        f.geometry.curvature_b,
        f.forces.elastic_energy,
        f.forces.tangential_energy,
        f.forces.viscous_power,
        f.forces.tangential_power,
        f.forces.stiffness,
    ];
    numbers.iter().all(|v| v.iter().all(|x| x.is_finite()))
        && scalars.iter().all(|x| x.is_finite())
        && (f.normal.norm() - 1.0).abs() < 1e-12
        && f.geometry.curvature_a >= 0.0
        && f.geometry.curvature_a <= f.geometry.curvature_b
}

/// Two steps; all numbers finite, histories too, momentum kept.
fn hold(i: &Body, j: &Body, deck: &str) -> Result<(), TestCaseError> {
    let laws = laws(&[deck]);
    let mut memory = Memory::new(&laws);
    let start = Instant::now();
    for _ in 0..2 {
        let felt = advance(&laws, i, j, 1e-5, &mut memory);
        prop_assert!(memory.history.iter().all(|x| x.is_finite()), "{:?}", memory);
        if let Some(f) = felt {
            prop_assert!(finite(&f), "{f:?}");
            let d = position(j) - position(i);
            let sum = d.cross(&f.force) + f.torque_i + f.torque_j;
            // The radii of curvature of a needle differ by the square of its aspect ratio, 1e6, and cancel in the balance.
            let allowed = 1e-7 * force_scale(&f) * size(i, j);
            prop_assert!(sum.norm() <= allowed, "{:e} of {allowed:e}", sum.norm());
        }
    }
    // A hundred times what the slowest search takes.
    prop_assert!(
        start.elapsed() < Duration::from_millis(500),
        "{:?}",
        start.elapsed()
    );
    Ok(())
}

/// Needles, discs, blades and spheres up to an aspect ratio of 1000, sizes up to 1 : 100.
fn shape() -> impl Strategy<Value = [f64; 3]> {
    (0usize..5, 0.0..3.0f64, 0.0..3.0f64, -2.0..0.0f64).prop_map(|(kind, a, b, scale)| {
        let (a, b) = (10f64.powf(-a), 10f64.powf(-b));
        let s = 10f64.powf(scale);
        match kind {
            0 => [s, s * a, s * a],
            1 => [s * a, s, s],
            2 => [s, s * a, s * b],
            3 => [s; 3],
            _ => [s, s * 1e-3, s * 1e-3],
        }
    })
}

fn moving(semi_axes: [f64; 3], turn: crate::support::scene::Rotation, speed: f64) -> Body {
    let mut b = body(semi_axes, Vector::zeros(), turn);
    b.velocity = [speed, -0.3 * speed, 0.2 * speed];
    b.angular_velocity = [0.1 * speed, speed, -speed];
    b
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn coincident_centres(
        shapes in prop::array::uniform2(shape()),
        turns in prop::array::uniform2(turn()),
        deck in deck(),
        same in any::<bool>(),
        speed in prop::sample::select(vec![0.0, 1.0]),
    ) {
        let i = moving(shapes[0], turns[0], speed);
        let j = if same { i } else { moving(shapes[1], turns[1], -speed) };
        hold(&i, &j, deck)?;
    }

    #[test]
    fn nearly_coincident_centres(
        shapes in prop::array::uniform2(shape()),
        turns in prop::array::uniform2(turn()),
        deck in deck(),
        direction in direction(),
        exponent in -300.0..-1.0f64,
    ) {
        let i = moving(shapes[0], turns[0], 1.0);
        let mut j = moving(shapes[1], turns[1], -1.0);
        j.position = (direction * 10f64.powf(exponent)).into();
        hold(&i, &j, deck)?;
    }

    #[test]
    fn needles_and_discs_at_any_distance(
        shapes in prop::array::uniform2(shape()),
        turns in prop::array::uniform2(turn()),
        aligned in any::<bool>(),
        deck in deck(),
        direction in direction(),
        distance in 0.0..1.1f64,
        speed in prop::sample::select(vec![0.0, 1e-9, 1.0, 1e6]),
    ) {
        let i = moving(shapes[0], turns[0], speed);
        let mut j = moving(shapes[1], if aligned { turns[0] } else { turns[1] }, -speed);
        // Between coincident and just apart, along the ray: the distance at which support functions add up.
        let reach = [&i, &j].map(|b| {
            let local = rotation(b.quaternion).inverse() * direction;
            1.0 / (0..3).map(|k| (local[k] / b.semi_axes[k]).powi(2)).sum::<f64>().sqrt()
        });
        j.position = (direction * (distance * (reach[0] + reach[1]))).into();
        hold(&i, &j, deck)?;
    }

    /// Symmetric to the last bit: parallel, concentric, end to end, side by side, crossed at a right angle.
    #[test]
    fn exactly_symmetric_poses(
        shapes in prop::array::uniform2(shape()),
        axis in 0usize..3,
        quarter_turn in 0usize..4,
        fraction in 0.0..1.2f64,
        deck in deck(),
        speed in prop::sample::select(vec![0.0, 1.0]),
    ) {
        let mut i = moving(shapes[0], crate::support::scene::Rotation::identity(), 0.0);
        i.velocity[axis] = speed;
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut j = moving(shapes[1], crate::support::scene::Rotation::identity(), 0.0);
        j.quaternion = [[1.0, 0.0, 0.0, 0.0], [half, half, 0.0, 0.0], [half, 0.0, half, 0.0], [half, 0.0, 0.0, half]]
            [quarter_turn];
        j.position[axis] = fraction * (shapes[0][axis] + shapes[1][axis]);
        hold(&i, &j, deck)?;
    }
}

#[test]
fn two_bodies_at_rest_in_touch_feel_only_the_elastic_force() {
    for deck in [
        "nfd 1e5 0.3 30 50 tangential tfd 0.3",
        "lsd 1e3 3 tangential linear 800 2 0.3",
    ] {
        let laws = laws(&[deck]);
        let turn = rotation([0.9, 0.1, -0.2, 0.3]);
        let i = body([1.0, 0.5, 0.7], Vector::zeros(), turn);
        let j = body(
            [1.0, 0.5, 0.7],
            Vector::new(0.0, 1.1, 0.2),
            rotation([1.0, 0.0, 0.0, 0.0]),
        );
        let f = advance(&laws, &i, &j, 1e-3, &mut Memory::new(&laws)).expect("touching");
        assert_eq!(f.tangential.norm(), 0.0);
        assert_eq!(f.forces.viscous_power, 0.0);
        assert_eq!(f.forces.tangential_power, 0.0);
    }
}

/// A receding contact has lost its area and its stiffness, and remembers a force: `displacement rescaled`, which compares energies, and the
/// springs of `hysteretic`.
struct Receded<'a> {
    law: &'a PairLaw,
    curvature: [f64; 3],
    memory: [f64; 2],
    passes: bool,
}

impl Stage for Receded<'_> {
    fn run<S: Registers>(self, registers: S) {
        let number = |x: f64| Lanes::splat(registers, x);
        let [zero, one] = [0.0, 1.0].map(number);
        let [uu, uv, vv] = self.curvature;
        let exact = hertz_factors::exact(uu + vv, uu * vv - uv * uv, true);
        let factors = Factors {
            phi: number(exact.phi),
            sigma: number(exact.sigma),
        };
        let c = &self.law.constants.tangential;
        let c = TangentialConstants {
            friction: number(c.friction),
            kappa0: number(c.kappa0),
            kappa1: number(c.kappa1),
            tau0: number(c.tau0),
            tau1: number(c.tau1),
            stiffness: number(c.stiffness),
            damping: number(c.damping),
        };
        let curvature = Symmetric2::new(number(uu), number(uv), number(vv));
        let memory = Vector2::new(number(self.memory[0]), number(self.memory[1]));
        let passes = if self.passes { zero } else { one }.less(one);
        let motion = Vector2::new(one * 1e-6, one * -1e-6);
        let kinds = &self.law.kinds.tangential;
        let mut springs = Springs {
            forces: [memory * (one * (1.0 / SPRINGS as f64)); SPRINGS],
            reference: one * 1e-6,
            penetration: one * 1e-6,
        };
        let found = if kinds.displacement == Displacement::Hysteretic {
            force_of_springs(
                kinds,
                &c,
                (zero, zero, zero),
                &factors,
                curvature,
                one * 1e-9,
                &mut springs,
                memory,
                one,
                passes,
                motion,
                motion,
            )
        } else {
            tangential_force(
                kinds,
                &c,
                (zero, zero, zero),
                &factors,
                curvature,
                memory,
                one,
                passes,
                motion,
                motion,
            )
        };
        let mut numbers = vec![found.elastic_energy];
        for v in [found.force, found.elastic_force, found.memory] {
            numbers.extend([v.u, v.v]);
        }
        for force in springs.forces {
            numbers.extend([force.u, force.v]);
        }
        let mut lanes = [0.0; MOST_LANES];
        for (k, x) in numbers.into_iter().enumerate() {
            x.store(&mut lanes);
            assert!(lanes[0].is_finite(), "number {k} is {}", lanes[0]);
        }
        if self.passes {
            for x in [found.elastic_energy, found.force.u, found.force.v] {
                x.store(&mut lanes);
                assert!(lanes[0].abs() < 1e-100, "{}", lanes[0]);
            }
        }
    }
}

#[test]
fn a_contact_without_stiffness_holds_no_energy_whatever_it_remembers() {
    for displacement in ["rescaled", "hysteretic"] {
        let law = pair_law(&format!(
            "nfd 1.53e10 0.49 4.2e2 4e10 tangential tfd 634 displacement {displacement}"
        ));
        for set in InstructionSet::ALL
            .into_iter()
            .filter(|set| set.is_available())
        {
            let mut numbers = Stream::new(7);
            for _ in 0..2000 {
                let curvature = {
                    let (large, small) = (numbers.uniform(1.0, 1e3), numbers.uniform(1e-3, 1.0));
                    let (s, c) = numbers.uniform(-3.0, 3.0).sin_cos();
                    [
                        large * c * c + small * s * s,
                        (large - small) * s * c,
                        large * s * s + small * c * c,
                    ]
                };
                let size = 10f64.powf(numbers.uniform(0.0, 139.0));
                let (s, c) = numbers.uniform(-3.0, 3.0).sin_cos();
                for passes in [true, false] {
                    set.run(Receded {
                        law: &law,
                        curvature,
                        memory: [size * c, size * s],
                        passes,
                    });
                }
            }
        }
    }
}
