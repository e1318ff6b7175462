// SPDX-License-Identifier: MIT OR Apache-2.0
//! A single grain on a plane whose motion has a closed form: impulse of a rebound, frequency of rocking, end of sliding. The closed
//! forms are of rigid bodies; a soft one differs by the order of its penetration, which must be seen to fall with the penetration.

use super::frames::Frame;
use super::scene::{Grain, Scene};
use super::shapes::{
    about, add, angular_velocity, cross, dot, hertz_stiffness, inertia, length, scale, sub,
    surface_point, Quaternion, Vector, IDENTITY,
};

const UP: Vector = [0.0, 0.0, 1.0];
const DOWN: Vector = [0.0, 0.0, -1.0];
const POISSON: f64 = 0.3;
const GRAVITY: f64 = 9.81;
/// Contact time of an elastic Hertz collision, in units of the greatest penetration over the speed.
const HERTZ_TIME: f64 = 2.9432751843247047;

/// A grain above the plane z = 0, and how it is run; SI units.
pub struct Setting {
    pub scene: Scene,
    /// E, nu, eta1, eta2 of grain and plane.
    pub material: [f64; 4],
    pub friction: f64,
    pub gravity: f64,
    pub time_step: f64,
    pub steps: u64,
    pub dump_every: u64,
}

/// Runs a setting of this name in an engine.
pub type Run<'a> = &'a dyn Fn(&str, &Setting) -> Vec<Frame>;

fn grain(semi_axes: Vector, pose: Quaternion, penetration: f64) -> Grain {
    let low = surface_point(semi_axes, pose, DOWN);
    Grain {
        density: 2500.0,
        ..Grain::new(semi_axes, [0.0, 0.0, -low[2] - penetration]).turned(pose)
    }
}

/// k of F = k delta^(3/2) against the plane, for Young's modulus 1 of both.
fn unit_stiffness(semi_axes: Vector, pose: Quaternion) -> f64 {
    let modulus = 1.0 / (2.0 * (1.0 - POISSON * POISSON));
    hertz_stiffness(modulus, (semi_axes, pose), ([1e6; 3], IDENTITY), DOWN)
}

fn spin(grain: &Grain) -> Vector {
    angular_velocity(
        grain.mass(),
        grain.semi_axes,
        grain.quaternion,
        grain.angular_momentum,
    )
}

/// What an impulse along `along` at the point `arm` from the centre adds to the velocity of that point along `of`.
fn mobility(grain: &Grain, arm: Vector, of: Vector, along: Vector) -> f64 {
    let turning = angular_velocity(
        grain.mass(),
        grain.semi_axes,
        grain.quaternion,
        cross(arm, along),
    );
    dot(of, along) / grain.mass() + dot(of, cross(turning, arm))
}

/// A collision that lasts until no force is left: the errors of velocity, over the impact speed, and of angular momentum, over the
/// moment of the impulse about a point at the distance of the largest semi-axis.
fn collision_error(
    run: Run,
    name: &str,
    grain: &Grain,
    friction: f64,
    penetration: f64,
    steps: f64,
) -> [f64; 2] {
    let arm = surface_point(grain.semi_axes, grain.quaternion, DOWN);
    let at_contact = add(grain.velocity, cross(spin(grain), arm));
    let (normal, sliding) = (
        dot(at_contact, UP),
        sub(at_contact, scale(dot(at_contact, UP), UP)),
    );
    assert!(
        normal < 0.0,
        "{name}: the point of contact does not approach"
    );
    // The force of friction is along one line in the collisions here: that of the motion in a plane of symmetry.
    let push = if friction > 0.0 {
        sub(UP, scale(friction / length(sliding), sliding))
    } else {
        UP
    };
    // The force depends on the penetration alone, so that the point leaves as fast as it came.
    let answer = mobility(grain, arm, UP, push);
    let impulse = scale(-2.0 * normal / answer, push);
    let velocity = add(grain.velocity, scale(1.0 / grain.mass(), impulse));
    let momentum = add(grain.angular_momentum, cross(arm, impulse));
    if friction > 0.0 {
        let left = dot(sliding, sliding)
            + length(impulse) / length(push) * mobility(grain, arm, sliding, push);
        assert!(left > 0.0, "{name}: the point of contact comes to rest");
    }
    let stiffness = 1.25 * normal * normal / (answer * penetration.powf(2.5));
    let time_step = HERTZ_TIME * penetration / -normal / steps;
    let setting = Setting {
        scene: Scene::open(0.2, vec![grain.clone()]),
        material: [
            stiffness / unit_stiffness(grain.semi_axes, grain.quaternion),
            POISSON,
            0.0,
            0.0,
        ],
        friction,
        gravity: 0.0,
        time_step,
        steps: (1.3 * steps) as u64,
        dump_every: 0,
    };
    let frames = run(name, &setting);
    let last = &frames.last().unwrap().states[0];
    assert_eq!(last.force, [0.0; 3], "{name}: still in contact");
    let reach = grain.semi_axes.iter().fold(0.0f64, |a, b| a.max(*b));
    [
        length(sub(last.velocity, velocity)) / -normal,
        length(sub(last.angular_momentum, momentum)) / (reach * length(impulse)),
    ]
}

/// The collision at two penetrations, the second a tenth of the first, over the least semi-axis.
fn converges(run: Run, what: &str, grain: &Grain, friction: f64) {
    let least = grain.semi_axes.iter().fold(f64::MAX, |a, b| a.min(*b));
    let [soft, stiff] = [1e-3, 1e-4].map(|penetration| {
        let name = format!("{what} {penetration:e}").replace([' ', ',', ':'], "_");
        collision_error(run, &name, grain, friction, penetration * least, 1000.0)
    });
    println!(
        "{what}: velocity off by {:.1e} and {:.1e}, angular momentum by {:.1e} and {:.1e}, at penetrations of 1e-3 and 1e-4",
        soft[0], stiff[0], soft[1], stiff[1]
    );
    for (soft, stiff) in soft.into_iter().zip(stiff) {
        assert!(stiff < 2e-4, "{what}: {stiff:e}");
        // First order in the penetration, or what the step leaves.
        assert!(
            stiff < 0.12 * soft || soft < 1e-8,
            "{what}: {soft:e}, {stiff:e}"
        );
    }
}

const TRIAXIAL: Vector = [1.5e-2, 1e-2, 0.7e-2];
const NEEDLE: Vector = [5e-2, 1e-2, 1e-2];
const DISC: Vector = [1e-2, 1e-2, 0.2e-2];

/// Without friction, at any tilt, with a spin.
pub fn smooth_rebound(run: Run) {
    for (what, axes) in [("triaxial", TRIAXIAL), ("needle", NEEDLE), ("disc", DISC)] {
        for tilt in [0.0, 15.0, 45.0, 75.0, 90.0f64] {
            let pose = about([0.3, 1.0, 0.2], tilt.to_radians());
            let falling = grain(axes, pose, 0.0)
                .moving([0.02, -0.01, -0.1])
                .spinning([0.3, 0.2, -0.4]);
            converges(run, &format!("smooth {what}, tilt {tilt}"), &falling, 0.0);
        }
    }
}

/// With friction, sliding all the time, in a plane of symmetry.
pub fn sliding_rebound(run: Run) {
    let friction = 0.2;
    for (what, axes) in [
        ("sphere", [1e-2; 3]),
        ("triaxial", TRIAXIAL),
        ("needle", NEEDLE),
        ("disc", DISC),
    ] {
        for tilt in [0.0, 20.0, 70.0, -20.0, -70.0f64] {
            if what == "sphere" && tilt != 0.0 {
                continue;
            }
            let pose = about([0.0, 1.0, 0.0], tilt.to_radians());
            let falling = grain(axes, pose, 0.0).moving([1.5, 0.0, -0.1]);
            converges(
                run,
                &format!("sliding {what}, tilt {tilt}"),
                &falling,
                friction,
            );
        }
    }
}

/// Penetration of a grain at rest under its weight, for this modulus.
fn rest_penetration(grain: &Grain, modulus: f64) -> f64 {
    let stiffness = modulus * unit_stiffness(grain.semi_axes, grain.quaternion);
    (grain.mass() * GRAVITY / stiffness).powf(2.0 / 3.0)
}

/// The modulus for this penetration at rest.
fn modulus_for(grain: &Grain, penetration: f64) -> f64 {
    grain.mass() * GRAVITY
        / (penetration.powf(1.5) * unit_stiffness(grain.semi_axes, grain.quaternion))
}

/// Small swings of an ellipsoid about the lowest position of its centre: sliding without friction, rolling with it.
pub fn rocking(run: Run) {
    // The period grows by the order of (angle a/c)^2.
    let amplitude = 2e-4;
    for (what, axes) in [("triaxial", TRIAXIAL), ("needle", NEEDLE), ("disc", DISC)] {
        let level = grain(axes, IDENTITY, 0.0);
        let moment = inertia(level.mass(), axes)[1];
        let (a, c) = (axes[0], axes[2]);
        // The centre is at c + (a^2 - c^2) angle^2/(2 c) above the plane.
        let stiffness = level.mass() * GRAVITY * (a * a - c * c) / c;
        for friction in [0.0, 1.0] {
            let inertia = moment
                + if friction > 0.0 {
                    level.mass() * c * c
                } else {
                    0.0
                };
            let period = 2.0 * std::f64::consts::PI * (inertia / stiffness).sqrt();
            let [soft, stiff] = [1e-3, 1e-4].map(|relative: f64| {
                let penetration = relative * c;
                let modulus = modulus_for(&level, penetration);
                // Through the lowest position, where no force of friction acts: one that set in at once would make its spring swing.
                let spin = amplitude * 2.0 * std::f64::consts::PI / period;
                let along = if friction > 0.0 { spin * c } else { 0.0 };
                let passing = grain(axes, IDENTITY, penetration)
                    .moving([along, 0.0, 0.0])
                    .spinning([0.0, spin, 0.0]);
                let bounce =
                    2.0 * std::f64::consts::PI * (2.0 * penetration / (3.0 * GRAVITY)).sqrt();
                let time_step = bounce / 60.0;
                let every = ((period / 200.0 / time_step) as u64).max(1);
                let setting = Setting {
                    scene: Scene::open(0.5, vec![passing]),
                    material: [modulus, POISSON, 0.0, 0.0],
                    friction,
                    gravity: GRAVITY,
                    time_step,
                    steps: (1.4 * period / time_step) as u64,
                    dump_every: every,
                };
                let name = format!("rocking {what} {friction} {relative:e}").replace(' ', "_");
                let frames = run(&name, &setting);
                measured_period(&frames, time_step) / period - 1.0
            });
            println!(
                "rocking {what}, friction {friction}: period off by {soft:+.1e} and {stiff:+.1e}, at penetrations of 1e-3 and 1e-4"
            );
            assert!(stiff.abs() < 1e-4, "{what}, friction {friction}");
            assert!(
                stiff.abs() < 0.3 * soft.abs() || soft.abs() < 1e-4,
                "{what}, friction {friction}"
            );
        }
    }
}

/// The time from the first to the third zero of the angular momentum about y.
fn measured_period(frames: &[Frame], time_step: f64) -> f64 {
    let spins: Vec<(f64, f64)> = frames
        .iter()
        .map(|f| (f.step as f64 * time_step, f.states[0].angular_momentum[1]))
        .collect();
    let zeros: Vec<f64> = spins
        .windows(2)
        .filter(|w| w[0].1 * w[1].1 < 0.0)
        .map(|w| w[0].0 + (w[1].0 - w[0].0) * w[0].1 / (w[0].1 - w[1].1))
        .collect();
    assert!(zeros.len() >= 3, "it does not swing: {} zeros", zeros.len());
    zeros[2] - zeros[0]
}

/// A spheroid set down on its equator with speed v0 and no spin rolls about its axis from t = 2 v0/(7 mu g) on, at 5 v0/7: its moment
/// of inertia about that axis is that of the sphere of its equator, whatever its length.
pub fn sliding_into_rolling(run: Run) {
    let (friction, speed, radius) = (0.3, 0.2, 1e-2);
    for (what, half_length) in [("sphere", 1.0), ("prolate", 2.0), ("oblate", 0.5)] {
        let axes = [radius, half_length * radius, radius];
        // So stiff that the lever arm is the radius.
        let modulus = 1e9;
        let level = grain(axes, IDENTITY, 0.0);
        let penetration = rest_penetration(&level, modulus);
        let mut set_down = grain(axes, IDENTITY, penetration).moving([speed, 0.0, 0.0]);
        set_down.position[0] = -0.05;
        // Without damping the tangential spring would swing for long after the grain has begun to roll.
        let relaxation = 1e-4;
        let expected = 2.0 * speed / (7.0 * friction * GRAVITY);
        let (steps, every) = (60_000, 100);
        let time_step = 2.0 * expected / steps as f64;
        let moment = inertia(level.mass(), axes)[1];
        let setting = Setting {
            scene: Scene::open(0.1, vec![set_down]),
            material: [
                modulus,
                POISSON,
                relaxation * modulus / (1.0 + POISSON),
                relaxation * modulus / (3.0 * (1.0 - 2.0 * POISSON)),
            ],
            friction,
            gravity: GRAVITY,
            time_step,
            steps,
            dump_every: every,
        };
        let frames = run(&format!("rolling {what}").replace(' ', "_"), &setting);
        let slip = |f: &Frame| {
            let state = &f.states[0];
            state.velocity[0] - radius * state.angular_momentum[1] / moment
        };
        let at = |t: f64| &frames[(t * expected / time_step).round() as usize / every as usize];
        let (a, b) = (at(0.3), at(0.6));
        let rate = (slip(b) - slip(a)) / ((b.step - a.step) as f64 * time_step);
        let end = (a.step as f64 * time_step - slip(a) / rate) / expected - 1.0;
        let last = frames.last().unwrap();
        let rolls = last.states[0].velocity[0] / (5.0 * speed / 7.0) - 1.0;
        println!(
            "sliding into rolling, {what}: penetration {:.1e} R; end of sliding off by {end:+.1e}, speed by {rolls:+.1e}, slip left {:+.1e} of v0",
            penetration / radius,
            slip(last) / speed
        );
        assert!(end.abs() < 3e-4 && rolls.abs() < 3e-4, "{what}");
        assert!(slip(last).abs() < 3e-4 * speed, "{what}");
    }
}
