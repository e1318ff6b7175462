// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which energy error has a collision, with how many steps, where viscous forces see velocities of the half step, and where
//! they see those of the step? And up to which step is each stable?

use crate::support::motion::{Motion, Partner, Rigid, Velocities};
use crate::support::random::Stream;
use crate::support::scene::{array, body, laws, wall, Rotation, Vector};
use ellgran::contact::{Body, Laws};

const AXES: [f64; 3] = [2.0, 1.0, 1.0];
const MASS: f64 = 2.0;
/// Largest overlap of a head-on collision at speed 1, in small semi-axes.
const OVERLAP: f64 = 0.02;
/// Of Hertz' collision, in `OVERLAP` at speed 1 (docs/theory.md, section 6).
const CONTACT_TIME: f64 = 2.943_275_184_324_704_7 * OVERLAP;
const POISSONS_RATIO: f64 = 0.3;

/// `4/3 E*` of two equal grains at effective radius 1, so that the overlap is reached.
fn stiffness() -> f64 {
    1.25 * 0.5 * MASS / OVERLAP.powf(2.5)
}

fn modulus() -> f64 {
    stiffness() * 1.5 * (1.0 - POISSONS_RATIO * POISSONS_RATIO)
}

/// Viscosities of a restitution of 0.9, times a factor.
fn nfd(factor: f64) -> String {
    let relaxation = 0.094 / 1.5 / (2.0 * stiffness() / MASS).powf(0.4);
    let eta = factor * relaxation * modulus() / 1.275_238;
    format!("nfd {:e} {POISSONS_RATIO} {eta:e} {eta:e}", modulus())
}

/// Two grains about to meet, first touch anywhere within a step.
fn meetings(count: usize) -> Vec<[Body; 2]> {
    let mut random = Stream::new(11);
    (0..count)
        .map(|_| {
            let turns = [random.rotation(), random.rotation()];
            let n = random.direction();
            let support = |q: &Rotation| {
                let axes = Vector::from(AXES);
                let z = axes.component_mul(&q.inverse_transform_vector(&n));
                q.transform_vector(&axes.component_mul(&z)) / z.norm()
            };
            let gap = OVERLAP * random.uniform(0.05, 0.25);
            let place = support(&turns[0]) + support(&turns[1]) + n * gap;
            let mut i = body(AXES, Vector::zeros(), turns[0]);
            let mut j = body(AXES, place, turns[1]);
            (i.mass, j.mass) = (MASS, MASS);
            j.velocity = array(random.direction() * 0.3 - n);
            [i, j]
        })
        .collect()
}

/// Kinetic energy after the collision over that before.
fn energy(laws: &Laws, [i, j]: [Body; 2], steps: f64, velocities: Velocities) -> f64 {
    let j = Partner::Body(Rigid::new(j));
    let mut motion = Motion::new(laws, i, j, CONTACT_TIME / steps);
    motion.velocities = velocities;
    let before = motion.kinetic_energy();
    assert!(motion.collide((20.0 * steps) as usize), "it does not end");
    motion.kinetic_energy() / before
}

/// Root mean square of the energy errors at each number of steps.
fn errors<const N: usize>(deck: &str, steps: [f64; N], velocities: Velocities) -> [f64; N] {
    let laws = laws(&[deck]);
    let meetings = meetings(12);
    let fine: Vec<f64> = meetings
        .iter()
        .map(|m| energy(&laws, *m, 8000.0, Velocities::Step))
        .collect();
    steps.map(|steps| {
        let squares = meetings
            .iter()
            .zip(&fine)
            .map(|(m, fine)| (energy(&laws, *m, steps, velocities) - fine).powi(2));
        (squares.sum::<f64>() / fine.len() as f64).sqrt()
    })
}

#[test]
fn viscous_collisions_keep_their_energy_better_with_velocities_of_the_step() {
    let steps = [50.0, 100.0, 200.0, 1000.0];
    let conservative = format!("hertz {:e} {POISSONS_RATIO} conservative yes", modulus());
    let with_friction = format!("{} tangential tfd 0.5", nfd(1.0));
    let table = [conservative, nfd(1.0), with_friction].map(|deck| {
        [Velocities::HalfStep, Velocities::Step].map(|velocities| {
            let found = errors(&deck, steps, velocities);
            let law = deck.split(' ').next().unwrap_or_default();
            println!(
                "{law} {velocities:?}: errors of the energy, 1e-6: {found:.3?} at {steps:?} steps",
                found = found.map(|e| 1e6 * e)
            );
            found
        })
    });
    let [[elastic_half, elastic], [normal_half, normal], [friction_half, friction]] = table;
    // Bit for bit: nothing reads the velocities.
    assert_eq!(elastic_half, elastic);
    assert!(normal[1] < 1.5e-5 && normal[3] < 4e-7, "{normal:?}");
    assert!(normal[3] < 0.3 * normal_half[3]);
    assert!(friction[0] < 0.2 * friction_half[0], "{friction:?}");
    assert!(friction[3] < 0.1 * friction_half[3], "{friction:?}");
    // Second order without friction. Where a contact begins or ends to slide within a step an error of the first order is left.
    let order = |errors: [f64; 4]| (errors[0] / errors[3]).ln() / (steps[3] / steps[0]).ln();
    println!("orders {:.2} and {:.2}", order(normal), order(friction));
    assert!(order(normal) > 1.9 && order(friction) > 1.1);
}

/// The largest step, times the angular frequency of the contact, at which a grain pressed onto a wall by a load stays there.
fn stability_limit(deck: &str, velocities: Velocities) -> f64 {
    let laws = laws(&[deck]);
    let wall = wall(Vector::z());
    let place = Vector::new(0.0, 0.0, AXES[2] - OVERLAP);
    let mut grain = body(AXES, place, Rotation::identity());
    grain.mass = MASS;
    let load = {
        let at_rest = Motion::new(&laws, grain, Partner::Wall(wall), 1.0);
        at_rest.felt.expect("it touches").forces.normal_force
    };
    let frequency = (1.5 * load / OVERLAP / MASS).sqrt();
    let kick = 1e-7 * OVERLAP * frequency;
    grain.velocity = [kick, 0.7 * kick, kick];
    grain.angular_velocity = [0.3 * kick, -0.4 * kick, 0.2 * kick];
    let stable = |step: f64| {
        let mut motion = Motion::new(&laws, grain, Partner::Wall(wall), step);
        motion.gravity = Vector::new(0.0, 0.0, -load / MASS);
        motion.velocities = velocities;
        let begin = motion.kinetic_energy();
        (0..1000).all(|_| {
            motion.step();
            motion.felt.is_some() && motion.kinetic_energy() < 100.0 * begin
        })
    };
    let (mut low, mut high) = (0.0, 4.0 / frequency);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low * frequency
}

#[test]
fn the_largest_stable_step_is_no_smaller_with_velocities_of_the_step() {
    for factor in [1.0, 10.0, 100.0, 1000.0] {
        for friction in ["", " tangential tfd 0.5"] {
            let deck = format!("{}{friction}", nfd(factor));
            let limits = [Velocities::HalfStep, Velocities::Step]
                .map(|velocities| stability_limit(&deck, velocities));
            println!("viscosities x {factor}{friction}: {limits:.4?}");
            assert!(limits[1] > 0.98 * limits[0], "{deck}: {limits:?}");
        }
    }
}
