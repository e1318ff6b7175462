// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which laws and motions are tried: Young's modulus 1e3 to 1e13, friction 0 to 1e3, no damping to overdamped, speeds over eight
//! decades, masses that differ by up to 1e9.

use super::families::Drawn;
use crate::support::random::Stream;
use crate::support::scene::Vector;

/// Of all blocks: only what happens in a step matters.
pub const TIME_STEP: f64 = 1e-6;

/// The words of a law.
pub fn deck(stream: &mut Stream) -> String {
    let one_of = |stream: &mut Stream, words: &[&'static str]| {
        words[(stream.uniform(0.0, words.len() as f64) as usize).min(words.len() - 1)]
    };
    let modulus = stream.log_uniform(1e3, 1e13);
    let ratio = one_of(stream, &["0", "0.1", "0.3", "0.45", "0.49"]);
    let friction = if stream.uniform(0.0, 1.0) < 0.1 {
        0.0
    } else {
        stream.log_uniform(1e-3, 1e3)
    };
    // The relaxation time in time steps; bodies move by up to a tenth of their overlap in a step.
    let mut viscosity = || modulus * TIME_STEP * stream.log_uniform(1e-3, 1e7);
    let (shear, bulk, restitution) = (viscosity(), viscosity(), stream.uniform(0.01, 1.0));
    let normal = match stream.uniform(0.0, 8.0) as usize {
        0..3 => format!("hertz {modulus:e} {ratio}"),
        3 => format!("hertz {modulus:e} {ratio} damping restitution {restitution}"),
        4 => format!("lsd {modulus:e} {shear:e}"),
        _ => format!("nfd {modulus:e} {ratio} {shear:e} {bulk:e}"),
    };
    let linear = normal.starts_with("lsd");
    let tangential = match stream.uniform(0.0, 4.0) as usize {
        0 => String::new(),
        _ if linear => format!(" tangential linear {modulus:e} {shear:e} {friction:e}"),
        1 => format!(" tangential mindlin {friction:e}"),
        _ => format!(" tangential tfd {friction:e}"),
    };
    let mut words = normal + &tangential;
    if !tangential.is_empty() {
        let kept = one_of(stream, &["rescaled", "rescaled", "total", "incremental"]);
        words += &format!(" displacement {kept}");
    }
    if words.starts_with("nfd") {
        let unloading = one_of(stream, &["ting", "first_order"]);
        words += &format!(" unloading {unloading}");
    }
    if !linear && stream.uniform(0.0, 1.0) < 0.3 {
        words += " conservative no";
    }
    if stream.uniform(0.0, 1.0) < 0.2 {
        words += " limit_force no";
    }
    words
}

/// Velocities, spins and masses. In a step the surfaces move by 1e-9 to 1e-1 of the overlap.
pub fn set_in_motion(stream: &mut Stream, drawn: &mut Drawn) {
    let ratio = stream.log_uniform(1e-9, 1e9);
    drawn.j.mass = ratio.max(1.0);
    drawn.i.mass = drawn.j.mass / ratio;
    let speed = drawn.depth / TIME_STEP * stream.log_uniform(1e-9, 1e-1);
    for body in [&mut drawn.i, &mut drawn.j] {
        let radius = body.semi_axes.into_iter().fold(0.0, f64::max);
        let any = |stream: &mut Stream, most: f64| {
            let v: Vector = stream.direction() * (most * stream.uniform(0.0, 0.5));
            v.map(|x| x.clamp(-1e24, 1e24)).into()
        };
        body.velocity = any(stream, speed);
        body.angular_velocity = any(stream, speed / radius);
    }
}
