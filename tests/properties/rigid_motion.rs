// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a contact notice where the scene is, how it is turned, or how fast it moves as a whole?

use crate::support::scene::{
    advance, difference, laws, plain, position, quaternion, rotation, rounding, rounding_of, size,
    vector as from, Memory, Rotation, Vector,
};
use crate::support::strategies::{deck, touching_pair, turn, vector};
use ellgran::contact::{Body, Laws};
use ellgran::force::SPRINGS;
use proptest::prelude::*;

fn carried(b: &Body, turn: &Rotation, shift: &Vector, drift: &Vector) -> Body {
    let rotate = |v: [f64; 3]| turn * Vector::from(v);
    Body {
        position: (rotate(b.position) + shift).into(),
        quaternion: quaternion(turn * rotation(b.quaternion)),
        velocity: (rotate(b.velocity) + drift).into(),
        angular_velocity: rotate(b.angular_velocity).into(),
        ..*b
    }
}

fn carried_memory(laws: &Laws, m: &Memory, turn: &Rotation) -> Memory {
    let mut m = m.clone();
    let layout = laws.layout();
    let springs = layout
        .springs
        .into_iter()
        .flat_map(|at| (0..SPRINGS).map(move |k| at + 3 * k));
    for at in [layout.normal, layout.memory, layout.rolling]
        .into_iter()
        .flatten()
        .chain(springs)
    {
        let v = turn * Vector::new(m.history[at], m.history[at + 1], m.history[at + 2]);
        m.history[at..at + 3].copy_from_slice(&plain(v).to_array());
    }
    m
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn a_scene_turned_shifted_and_drifting_feels_the_same(
        pair in touching_pair(10.0, 1e-5..0.3),
        deck in deck(),
        turn in turn(),
        shift in vector(3.0),
        drift in vector(3.0),
    ) {
        let laws = laws(&[deck]);
        let time_step = 1e-3 * pair.penetration;
        let mut memory = Memory::new(&laws);
        // A contact with a past, in which it was deeper: beyond its largest penetration the springs of `hysteretic` are grouped anew, and
        // at the same penetration rounding would decide whether they are.
        let deeper = Body {
            position: (position(&pair.j) - pair.normal * (0.01 * pair.penetration)).into(),
            ..pair.j
        };
        advance(&laws, &pair.i, &deeper, time_step, &mut memory).expect("touching");
        let mut there = carried_memory(&laws, &memory, &turn);
        let [i, j] = [&pair.i, &pair.j].map(|b| carried(b, &turn, &shift, &drift));
        let a = advance(&laws, &pair.i, &pair.j, time_step, &mut memory).expect("touching");
        let b = advance(&laws, &i, &j, time_step, &mut there).expect("touching");
        let size = size(&i, &j);
        // The coordinates are larger by the shift.
        let allowed = rounding(size + shift.norm() + position(&j).norm(), a.geometry.penetration, size / pair.radius);
        let back = turn.inverse();
        let error_allowed = rounding_of(deck, allowed);
        let error = difference(&a, back * b.force, back * b.torque_i, back * b.torque_j, size);
        prop_assert!(error <= error_allowed, "{error:e}, allowed {error_allowed:e}");
        let point = back * (b.contact_point - shift);
        prop_assert!((point - a.contact_point).norm() <= allowed * size);
        prop_assert!((back * from(b.geometry.normal) - a.normal).norm() <= allowed);
        let slid = from(a.forces.displacement);
        let difference = (back * from(b.forces.displacement) - slid).norm();
        prop_assert!(difference <= 4.0 * allowed * (slid.norm() + a.geometry.penetration));
    }

    /// A pair that flies and turns as one rigid body slides nowhere.
    #[test]
    fn rigid_motion_makes_no_tangential_displacement(
        pair in touching_pair(10.0, 1e-3..0.3),
        velocity in vector(1.0),
        spin in vector(1.0),
    ) {
        let laws = laws(&["hertz 1e5 0.3 tangential mindlin 0.4 displacement total"]);
        let mut memory = Memory::new(&laws);
        let rigid = |b: &Body| Body {
            velocity: (velocity + spin.cross(&position(b))).into(),
            angular_velocity: spin.into(),
            ..*b
        };
        let f = advance(&laws, &rigid(&pair.i), &rigid(&pair.j), 1e-3, &mut memory).expect("touching");
        // At first touch there is no turn to correct for but that of the spin over half a step.
        let slid = f.forces.displacement.norm();
        prop_assert!(slid <= 1e-3 * 1e-3 * spin.norm() * (velocity.norm() + spin.norm() * 4.0), "{slid:e}");
    }
}
