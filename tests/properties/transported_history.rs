// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a loaded tangential spring turn with the pair? (Objectivity of the history.)

use crate::support::random::Stream;
use crate::support::scene::{
    advance, laws, plain, position, quaternion, rotation, Memory, Rotation, Vector,
};
use crate::support::strategies::TouchingPair;
use ellgran::contact::{Body, Laws};

/// Loads a pair tangentially; the pair, its memory and its tangential force.
fn loaded(laws: &Laws, stream: &mut Stream) -> (Body, Body, Memory, Vector) {
    let shapes = [stream.semi_axes(4.0), stream.semi_axes(4.0)];
    let turns = [stream.rotation(), stream.rotation()];
    let n = stream.direction();
    let mut pair = TouchingPair::new(shapes, turns, n, 0.05);
    let mut memory = Memory::new(laws);
    let any = stream.direction();
    let slide = (any - n * n.dot(&any)).normalize() * (0.1 * pair.penetration);
    advance(laws, &pair.i, &pair.j, 0.0, &mut memory);
    pair.j.velocity = slide.into();
    advance(laws, &pair.i, &pair.j, 1.0, &mut memory);
    pair.j.velocity = [0.0; 3];
    let f = advance(laws, &pair.i, &pair.j, 1.0, &mut memory).expect("touching");
    (pair.i, pair.j, memory, f.tangential)
}

/// Turns the whole pair by `turn` in `steps`, velocities those of the half step; how far the tangential force is from
/// the turned one, relative.
fn error(
    laws: &Laws,
    i: &Body,
    j: &Body,
    memory: &Memory,
    force: Vector,
    turn: Vector,
    steps: usize,
) -> f64 {
    let mut memory = memory.clone();
    let part = turn / steps as f64;
    let pivot = Vector::new(0.3, -0.2, 0.1);
    let carried = |b: &Body, k: f64, velocity: bool| {
        let r = Rotation::from_scaled_axis(part * k);
        let x = pivot + r * (position(b) - pivot);
        let mut b = *b;
        b.position = x.into();
        b.quaternion = quaternion(r * rotation(b.quaternion));
        if velocity {
            // Over one unit of time a step: the displacement of the step, as leap-frog has it.
            let before = pivot
                + Rotation::from_scaled_axis(part * (k - 1.0))
                    * (position(b_original(&b, i, j)) - pivot);
            b.velocity = (x - before).into();
            b.angular_velocity = part.into();
        }
        b
    };
    let mut last = Vector::zeros();
    for k in 1..=steps {
        let (a, b) = (carried(i, k as f64, true), carried(j, k as f64, true));
        last = advance(laws, &a, &b, 1.0, &mut memory)
            .expect("touching")
            .tangential;
    }
    let wanted = Rotation::from_scaled_axis(turn) * force;
    (last - wanted).norm() / wanted.norm()
}

/// The body before it was carried, by its identifier.
fn b_original<'a>(b: &Body, i: &'a Body, j: &'a Body) -> &'a Body {
    if b.identifier == i.identifier {
        i
    } else {
        j
    }
}

#[test]
fn a_rigidly_turning_pair_keeps_its_tangential_force_co_rotating() {
    let mut stream = Stream::new(81);
    for words in [
        "mindlin 10 displacement total",
        "mindlin 10 displacement incremental",
        "mindlin 10 displacement rescaled",
        "tfd 10 displacement total",
        "tfd 10 displacement hysteretic",
    ] {
        let laws = laws(&[&format!("hertz 1e6 0.3 tangential {words}")]);
        let mut worst = [0.0f64; 2];
        for _ in 0..40 {
            let (mut i, mut j, memory, force) = loaded(&laws, &mut stream);
            i.identifier = 1;
            j.identifier = 2;
            assert!(force.norm() > 0.0);
            let turn = stream.direction() * 0.5;
            for (w, steps) in worst.iter_mut().zip([100, 400]) {
                *w = w.max(error(&laws, &i, &j, &memory, force, turn, steps));
            }
        }
        println!(
            "{words}: off by {:.1e} in 100 steps, {:.1e} in 400 for a turn of 0.5",
            worst[0], worst[1]
        );
        assert!(worst[1] < 1e-2);
        assert!(
            worst[0] / worst[1] > 12.0,
            "second order: {}",
            worst[0] / worst[1]
        );
    }
}

#[test]
fn spin_about_the_normal_alone_turns_the_force() {
    let mut stream = Stream::new(82);
    let laws = laws(&["hertz 1e6 0.3 tangential mindlin 10"]);
    for _ in 0..20 {
        let (mut i, mut j, memory, force) = loaded(&laws, &mut stream);
        i.identifier = 1;
        j.identifier = 2;
        let at = laws.layout().normal.expect("a cached normal");
        let n = plain(Vector::new(
            memory.history[at],
            memory.history[at + 1],
            memory.history[at + 2],
        ));
        let turn = crate::support::scene::vector(n) * 0.7;
        let off = error(&laws, &i, &j, &memory, force, turn, 400);
        assert!(off < 1e-3, "{off}");
    }
}
