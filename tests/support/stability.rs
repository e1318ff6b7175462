// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether the motion of two bodies that touch is stable with a time step, seen by integrating it.

use super::motion::Rigid;
use super::random::Stream;
use super::scene::{advance, geometry, Memory, Vector};
use ellgran::contact::{Body, Laws};

/// Two grains, `j` moved along the normal until they overlap by this.
pub fn overlapping(i: Body, mut j: Body, overlap: f64) -> (Body, Body) {
    for _ in 0..3 {
        let found = geometry(&i, &j);
        let shift = found.penetration - overlap;
        let n = found.normal.to_array();
        for (x, n) in j.position.iter_mut().zip(n) {
            *x += shift * n;
        }
    }
    let left = geometry(&i, &j).penetration;
    assert!((left - overlap).abs() < 1e-6 * overlap, "{left}");
    (i, j)
}

/// Whether a small motion about the pressed contact grows.
pub fn grows(laws: &Laws, i: &Body, j: &Body, step: f64) -> bool {
    let mut memory = Memory::new(laws);
    let rest = advance(laws, i, j, 0.0, &mut memory).expect("a contact");
    // So small that what grows a hundred times is small still: an attractive force would be cut off.
    let amplitude = 1e-7 * rest.geometry.penetration / step;
    let mut random = Stream::new(5);
    let mut disturbed = |body: &Body| {
        let mut body = *body;
        let size = body.semi_axes[0];
        for k in 0..3 {
            body.velocity[k] = amplitude * random.uniform(-1.0, 1.0);
            body.angular_velocity[k] = amplitude / size * random.uniform(-1.0, 1.0);
        }
        Rigid::new(body)
    };
    let (mut a, mut b) = (disturbed(i), disturbed(j));
    // Of each body: beside a heavy one the energy of a light one does not show.
    let first = [a.kinetic_energy(), b.kinetic_energy()];
    let none = Vector::zeros();
    let mut excess = [none; 3];
    for _ in 0..300 {
        for half in 0..2 {
            let [force, torque_a, torque_b] = excess;
            a.kick(-force, torque_a, 0.5 * step);
            b.kick(force, torque_b, 0.5 * step);
            if half == 0 {
                a.drift(step);
                b.drift(step);
                // Between the steps: a mode that changes its sign in every step has no velocity at their ends.
                if a.kinetic_energy() > 1e4 * first[0] || b.kinetic_energy() > 1e4 * first[1] {
                    return true;
                }
                let Some(now) = advance(laws, &a.body, &b.body, step, &mut memory) else {
                    return true;
                };
                excess = [
                    now.force - rest.force,
                    now.torque_i - rest.torque_i,
                    now.torque_j - rest.torque_j,
                ];
            }
        }
    }
    false
}
