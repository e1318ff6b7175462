// SPDX-License-Identifier: MIT OR Apache-2.0
//! The energy error of collisions by law and time step, what a step costs, and the largest stable step.
//!
//! Grains of aspect ratio 2 meet obliquely, orientations and first touch at random. The integrator is velocity Verlet with a
//! symplectic free rotation, the forces come from the library's one-contact path.

use std::fmt::Write;
use std::path::Path;

use ellgran::contact::{Body, Laws};

use crate::clock::{since, Clock};
use crate::numbers::{Errors, Random};
use crate::support::motion::{Motion, Partner, Rigid, Velocities};
use crate::support::scene::{body, laws, rotation, wall, Vector};
use crate::{Effort, Outcome};

const AXES: [f64; 3] = [2.0, 1.0, 1.0];
const MASS: f64 = 2.0;
const SPEED: f64 = 1.0;
/// Largest overlap of a head-on collision, in small semi-axes.
const OVERLAP: f64 = 0.02;
const POISSONS_RATIO: f64 = 0.3;
/// Hertz: contact time and angular frequency at the largest overlap, in `overlap/speed` and its inverse (docs/theory.md, section 6).
const CONTACT_TIME: f64 = 2.943_275_184_324_704_7;
const FREQUENCY: f64 = 1.369_306_393_762_915_3;

struct LawOfStudy {
    name: &'static str,
    deck: String,
    /// Its energy after the collision should be that before; else the fine steps tell.
    elastic: bool,
    /// Product of contact time and angular frequency.
    turns: f64,
    /// Which velocities the force sees.
    velocities: Velocities,
}

fn laws_of_study() -> Vec<LawOfStudy> {
    let mass = 0.5 * MASS;
    let stiffness = 1.25 * mass * SPEED * SPEED / OVERLAP.powf(2.5);
    // 4/3 E* sqrt(Re) with Re = 1.
    let e = stiffness * 1.5 * (1.0 - POISSONS_RATIO * POISSONS_RATIO);
    // Restitution 0.9: b = 3/2 A (k/m)^(2/5) v^(1/5) = 0.094, and A_n = 1.275 eta/E for equal viscosities.
    let relaxation = 0.094 / 1.5 / (stiffness / mass).powf(0.4);
    let eta = relaxation * e / 1.275_238;
    let hertz = format!("hertz {e:e} {POISSONS_RATIO}");
    let nfd = format!("nfd {e:e} {POISSONS_RATIO} {eta:e} {eta:e}");
    let linear = mass * (std::f64::consts::PI * SPEED / (CONTACT_TIME * OVERLAP)).powi(2);
    let of_hertz = CONTACT_TIME * FREQUENCY;
    let law = |name, deck, elastic, turns| LawOfStudy {
        name,
        deck,
        elastic,
        turns,
        velocities: Velocities::HalfStep,
    };
    let of_step = |law: LawOfStudy| LawOfStudy {
        velocities: Velocities::Step,
        ..law
    };
    let with_friction = format!("{nfd} tangential tfd 0.5");
    vec![
        law("hertz", format!("{hertz} conservative yes"), true, of_hertz),
        law(
            "hertz conservative no",
            format!("{hertz} conservative no"),
            true,
            of_hertz,
        ),
        law("nfd", nfd.clone(), false, of_hertz),
        law("nfd with friction", with_friction.clone(), false, of_hertz),
        of_step(law("nfd of the step", nfd, false, of_hertz)),
        of_step(law(
            "nfd with friction of the step",
            with_friction,
            false,
            of_hertz,
        )),
        law(
            "lsd",
            format!("lsd {linear:e} 0"),
            true,
            std::f64::consts::PI,
        ),
    ]
}

/// Two grains about to meet.
struct Meeting {
    i: Body,
    j: Body,
}

fn meetings(count: usize) -> Vec<Meeting> {
    let mut random = Random(11);
    (0..count)
        .map(|_| {
            let turns = [random.on_sphere(), random.on_sphere()].map(rotation);
            let n = Vector::from(random.on_sphere::<3>());
            let sideways = Vector::from(random.on_sphere::<3>());
            let support = |q: &crate::support::scene::Rotation| {
                let z = Vector::from(AXES).component_mul(&q.inverse_transform_vector(&n));
                q.transform_vector(&Vector::from(AXES).component_mul(&z)) / z.norm()
            };
            // So far apart that the first touch falls anywhere within a step.
            let gap = OVERLAP * random.between(0.05, 0.25);
            let place = support(&turns[0]) + support(&turns[1]) + n * gap;
            let mut i = body(AXES, Vector::zeros(), turns[0]);
            let mut j = body(AXES, place, turns[1]);
            i.mass = MASS;
            j.mass = MASS;
            j.velocity = ((sideways * 0.3 - n) * SPEED).into();
            Meeting { i, j }
        })
        .collect()
}

/// Kinetic energy after the collision over that before, and the processor time of a step in seconds.
fn collide(
    laws: &Laws,
    meeting: &Meeting,
    step: f64,
    velocities: Velocities,
) -> Option<(f64, f64)> {
    let mut motion = Motion::new(laws, meeting.i, Partner::Body(Rigid::new(meeting.j)), step);
    motion.velocities = velocities;
    let before = motion.kinetic_energy();
    let most = (20.0 * CONTACT_TIME * OVERLAP / SPEED / step) as usize;
    let mut met = false;
    let start = Clock::now();
    for taken in 1..=most.max(20) {
        motion.step();
        match (&motion.felt, met) {
            (None, true) => {
                let time = since(&start).as_secs_f64() / taken as f64;
                return Some((motion.kinetic_energy() / before, time));
            }
            (Some(_), _) => met = true,
            (None, false) => {}
        }
    }
    None
}

const STEPS: [f64; 9] = [5.0, 10.0, 20.0, 30.0, 50.0, 100.0, 200.0, 500.0, 1000.0];

pub fn run(directory: &Path, effort: &Effort) -> Outcome {
    let meetings = meetings(if effort.quick { 4 } else { 24 });
    let fine = if effort.quick { 4000.0 } else { 16000.0 };
    let contact_time = CONTACT_TIME * OVERLAP / SPEED;
    let mut table = String::from(
        "law,steps_per_contact,energy_error_rms,energy_error_largest,ns_per_step,ns_per_contact\n",
    );
    let mut limits = String::from("law,limit_times_frequency,limit_over_contact_time\n");
    for law in laws_of_study() {
        let table_of_laws = laws(&[&law.deck]);
        let wanted: Vec<f64> = meetings
            .iter()
            .map(|meeting| {
                if law.elastic {
                    Some(1.0)
                } else {
                    collide(&table_of_laws, meeting, contact_time / fine, law.velocities)
                        .map(|found| found.0)
                }
            })
            .collect::<Option<_>>()
            .ok_or("a collision of fine steps did not end")?;
        for steps in STEPS {
            let mut times = Vec::new();
            let mut errors = Vec::new();
            // Short collisions are repeated: the clock is not finer than they are.
            for round in 0..(200.0 / steps).ceil() as usize {
                for (meeting, wanted) in meetings.iter().zip(&wanted) {
                    let step = contact_time / steps;
                    let found = collide(&table_of_laws, meeting, step, law.velocities);
                    let (energy, time) = found.unwrap_or((f64::NAN, f64::NAN));
                    times.push(time);
                    if round == 0 {
                        errors.push(energy - wanted);
                    }
                }
            }
            let errors = Errors::of(errors);
            let time = 1e9 * Errors::of(times).median;
            writeln!(
                table,
                "{},{steps},{:.3e},{:.3e},{time:.1},{:.1}",
                law.name,
                errors.rms,
                errors.largest,
                time * steps
            )?;
        }
        let limit = stability_limit(&table_of_laws, law.name == "lsd", law.velocities);
        writeln!(limits, "{},{limit:.4},{:.4}", law.name, limit / law.turns)?;
    }
    // Rayleigh's wave over a sphere of the grain's volume, the usual bound of the literature.
    let radius = (AXES[0] * AXES[1] * AXES[2]).cbrt();
    let density = MASS / (4.0 / 3.0 * std::f64::consts::PI * radius.powi(3));
    let stiffness = 1.25 * 0.5 * MASS * SPEED * SPEED / OVERLAP.powf(2.5);
    let e = stiffness * 1.5 * (1.0 - POISSONS_RATIO * POISSONS_RATIO);
    let shear = 0.5 * e / (1.0 + POISSONS_RATIO);
    let rayleigh = std::f64::consts::PI * radius * (density / shear).sqrt()
        / (0.1631 * POISSONS_RATIO + 0.8766);
    writeln!(limits, "rayleigh,,{:.4}", rayleigh / contact_time)?;
    std::fs::write(directory.join("time-step.csv"), table)?;
    std::fs::write(directory.join("time-step-limits.csv"), limits)?;
    Ok(())
}

/// The largest step at which a grain that rests on a wall, its flat side down and pressed to the overlap, stays there after a
/// tiny kick in all directions, times the angular frequency of the contact's normal oscillation.
fn stability_limit(laws: &Laws, linear: bool, velocities: Velocities) -> f64 {
    let wall = wall(Vector::z());
    let mut grain = body(
        AXES,
        Vector::new(0.0, 0.0, AXES[2] - OVERLAP),
        rotation([1.0, 0.0, 0.0, 0.0]),
    );
    grain.mass = MASS;
    let at_rest = Motion::new(laws, grain, Partner::Wall(wall), 1.0);
    let load = at_rest
        .felt
        .as_ref()
        .map_or(0.0, |felt| felt.forces.normal_force);
    let stiffness = load / OVERLAP * if linear { 1.0 } else { 1.5 };
    let frequency = (stiffness / MASS).sqrt();
    let stable = |step: f64| {
        let kick = 1e-7 * OVERLAP * frequency;
        let mut grain = grain;
        grain.velocity = [kick, 0.7 * kick, kick];
        grain.angular_velocity = [0.3 * kick, -0.4 * kick, 0.2 * kick];
        let mut motion = Motion::new(laws, grain, Partner::Wall(wall), step);
        motion.gravity = Vector::new(0.0, 0.0, -load / MASS);
        motion.velocities = velocities;
        let begin = motion.kinetic_energy();
        for _ in 0..2000 {
            motion.step();
            if motion.felt.is_none() || motion.kinetic_energy() > 100.0 * begin {
                return false;
            }
        }
        true
    };
    let (mut low, mut high) = (0.01 / frequency, 4.0 / frequency);
    for _ in 0..16 {
        let middle = 0.5 * (low + high);
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low * frequency
}
