// SPDX-License-Identifier: MIT OR Apache-2.0
//! A whole neighbour list and one contact at a time give the same numbers, with every combination of laws.

use std::ptr::null;

use ellgran::c_api::contact::*;
use ellgran::c_api::law::ELLGRAN_OPTION_NO_WARM_START;
use ellgran::c_api::neighbour_list::{ellgran_compute_pairs, ellgran_write_history};
use ellgran::c_api::particles::EllgranStep;
use ellgran::c_api::tallies::ellgran_tally_following_half_step;

use crate::scene::*;

const OWNED: usize = 44;
/// Of the terms of a sum; the search for the normal ends at about this.
const TOLERANCE: f64 = 2e-13;
/// Of the cached normal and of the tangential memory, which feel the normal's error in first order.
const HISTORY_TOLERANCE: f64 = 5e-13;
/// Rounding of the coordinates, a few units in the last place.
const ROUNDING: f64 = 2e-15;

/// Normal laws of two materials, with what goes with them.
fn normal_laws() -> Vec<[String; 2]> {
    let both = |law: &str, one: &str, other: &str, words: &str| {
        [one, other].map(|constants| format!("{law} {constants} {words}"))
    };
    let hertz = |words: &str| both("hertz", "1e4 0.3", "3e4 0.2", words);
    let mut laws = vec![hertz("")];
    laws.push(["0.5", "0.9"].map(|e| format!("{} damping restitution {e}", hertz("")[0])));
    for unloading in ["ting", "first_order"] {
        laws.push(["5e-3", "2e-2"].map(|a| {
            format!(
                "{} damping relaxation {a} unloading {unloading}",
                hertz("")[1]
            )
        }));
        for closure in ["energy", "surface", "brilliantov"] {
            let words = format!("closure {closure} unloading {unloading}");
            laws.push(both("nfd", "1e4 0.3 40 60", "3e4 0.2 90 30", &words));
        }
    }
    laws.push(both("lsd", "2e3 3", "5e3 2", ""));
    laws
}

/// Tangential laws of the same two materials.
fn tangential_laws() -> Vec<[String; 2]> {
    let mut laws = vec![["tangential none", "tangential none"].map(str::to_owned)];
    for (name, one, other) in [
        ("tfd", "0.4", "0.2"),
        ("mindlin", "0.4", "0.2"),
        ("linear", "500 1 0.4", "900 2 0.2"),
    ] {
        for displacement in ["total", "incremental", "rescaled"] {
            laws.push(
                [one, other].map(|c| format!("tangential {name} {c} displacement {displacement}")),
            );
        }
    }
    laws
}

fn combinations() -> Vec<[String; 2]> {
    let mut all = Vec::new();
    for normal in normal_laws() {
        for tangential in tangential_laws() {
            let elastic = ["tfd", "mindlin"].iter().any(|t| tangential[0].contains(t));
            if normal[0].starts_with("lsd") && elastic {
                continue;
            }
            for form in [
                "factors exact conservative yes",
                "factors exact conservative no",
                "factors hale conservative no",
            ] {
                for limit in ["yes", "no"] {
                    all.push([0, 1].map(|k| {
                        format!("{} {} {form} limit_force {limit}", normal[k], tangential[k])
                    }));
                }
            }
        }
    }
    all
}

#[derive(Debug, Default)]
pub struct Seen {
    contacts: usize,
    begun: usize,
    ended: usize,
    tangential: usize,
    /// Largest differences of forces, torques and histories, in units of what is allowed.
    pub worst: [f64; 3],
}

impl Seen {
    /// That the scene was worth comparing.
    #[track_caller]
    pub fn check(&self, contacts: usize) {
        assert!(self.contacts > contacts, "{self:?}");
        assert!(self.tangential > contacts / 2, "{self:?}");
        assert!(
            self.begun > contacts / 1000 && self.ended > contacts / 1000,
            "{self:?}"
        );
    }
}

fn add(sum: &mut [f64], term: &[f64], sign: f64) {
    for (s, t) in sum.iter_mut().zip(term) {
        *s += sign * t;
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn size(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[track_caller]
fn close(a: &[f64], b: &[f64], scale: f64, what: &str) -> f64 {
    let apart = a
        .iter()
        .zip(b)
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f64::max);
    assert!(
        apart <= TOLERANCE * scale,
        "{what}: {a:?} and {b:?} differ by {:e}",
        apart / scale
    );
    assert!(
        a.iter().chain(b).all(|x| x.is_finite()),
        "{what}: {a:?} {b:?}"
    );
    if apart > 0.0 {
        apart / (TOLERANCE * scale)
    } else {
        0.0
    }
}

/// Sums over contacts one by one, as the list is to give them.
struct Sums {
    forces: Vec<[f64; 3]>,
    torques: Vec<[f64; 3]>,
    /// Sums of magnitudes, what rounding is measured against.
    force_scale: Vec<f64>,
    torque_scale: Vec<f64>,
    energies: Vec<f64>,
    virials: Vec<[f64; 6]>,
    normal_energy: f64,
    tangential_energy: f64,
    virial: [f64; 6],
    virial_scale: f64,
    touching: f64,
}

/// What is computed both ways.
pub struct Comparison {
    pub decks: [String; 2],
    pub options: u32,
    pub newton: bool,
    pub steps: usize,
    pub bodies: Vec<EllgranBody>,
    /// Angular momenta in place of angular velocities, and contact masses of their own.
    pub momenta: bool,
    /// Whether histories stay in the workspace.
    pub keeps_history: bool,
    /// Whether the list of a step is said to be that of the step before.
    pub unchanged: fn(usize) -> bool,
    /// What happens to the particles in a step, beside their motion.
    pub change: fn(usize, &mut [EllgranBody]),
}

impl Comparison {
    /// Ten steps of a list that stays.
    pub fn new(decks: &[String; 2], bodies: Vec<EllgranBody>) -> Comparison {
        Comparison {
            decks: decks.clone(),
            options: 0,
            newton: true,
            steps: 10,
            bodies,
            momenta: false,
            keeps_history: false,
            unchanged: |step| step > 0,
            change: |_, _| (),
        }
    }
}

fn compare(decks: &[String; 2], options: u32, newton: bool, steps: usize, seen: &mut Seen) {
    let comparison = Comparison {
        options,
        newton,
        steps,
        ..Comparison::new(decks, random_bodies(5))
    };
    comparison.run(seen);
}

impl Comparison {
    pub fn run(self, seen: &mut Seen) {
        let Comparison {
            decks,
            options,
            newton,
            steps,
            mut bodies,
            ..
        } = self;
        let what = format!(
            "{decks:?} newton {newton} options {options} momenta {} keeps {}",
            self.momenta, self.keeps_history
        );
        let laws = Laws::with_options(&[&decks[0], &decks[1]], options);
        let length = laws.length();
        let normals = if options & ELLGRAN_OPTION_NO_WARM_START == 0 {
            3
        } else {
            0
        };
        let workspace = WorkspaceHandle::new();
        let count = bodies.len();
        let mut list = List::near(&bodies, OWNED, length);
        let mut alone = List::near(&bodies, OWNED, length);
        let mut tallies = no_tallies();
        let mut works = [0.0; 2];
        let mut work_scale = 0.0;
        for n in 0..steps {
            // The first is the set-up of a run: nothing advances.
            let step = EllgranStep {
                advance_history: (n > 0) as i32,
                ..STEP
            };
            if n > 0 {
                advance(&mut bodies, step.time_step);
            }
            (self.change)(n, &mut bodies);
            let mut arrays = Arrays::new(&bodies, OWNED);
            let mut energies = vec![0.0; count];
            let mut virials = vec![[0.0; 6]; count];
            tallies.particle_energies = energies.as_mut_ptr();
            tallies.particle_virials = virials.as_mut_ptr().cast();
            // What is there is overwritten.
            let mut loads = vec![[7.0; 12]; count];
            tallies.inelastic_loads = loads.as_mut_ptr().cast();
            let (mut particles, mut view) = (arrays.particles(), list.view(newton));
            let solid: Vec<f64> = bodies.iter().map(|b| b.mass.min(3.0)).collect();
            let momenta: Vec<[f64; 3]> = bodies
                .iter()
                .zip(&solid)
                .map(|(b, m)| angular_momentum(b.semi_axes, b.quaternion, *m, b.angular_velocity))
                .collect();
            if self.momenta {
                particles.contact_masses = particles.masses;
                particles.masses = solid.as_ptr();
                particles.angular_velocities = null();
                particles.angular_momenta = momenta.as_ptr().cast();
            }
            view.unchanged = i32::from((self.unchanged)(n));
            view.keep_history = i32::from(self.keeps_history);
            // What is kept is written before the list is another, and now and then.
            let written = !self.keeps_history || n % 3 == 2 || !(self.unchanged)(n + 1);
            // SAFETY: all arrays live to the end of the step.
            unsafe {
                ok(ellgran_compute_pairs(
                    laws.0,
                    workspace.0,
                    &particles,
                    &view,
                    &step,
                    &mut tallies,
                ));
                if self.keeps_history && written {
                    ok(ellgran_write_history(workspace.0, &view));
                }
            }

            let mut sums = Sums {
                forces: vec![[0.0; 3]; count],
                torques: vec![[0.0; 3]; count],
                force_scale: vec![0.0; count],
                torque_scale: vec![0.0; count],
                energies: vec![0.0; count],
                virials: vec![[0.0; 6]; count],
                normal_energy: 0.0,
                tangential_energy: 0.0,
                virial: [0.0; 6],
                virial_scale: 0.0,
                touching: 0.0,
            };
            let mut alone_loads = vec![[[0.0; 3]; 4]; count];
            let mut memory_scale = vec![0.0f64; length];
            let mut roundings = vec![Vec::new(); OWNED];
            for i in 0..OWNED {
                for (m, j) in alone.rows[i].iter().map(|j| *j as usize).enumerate() {
                    let mut force = Untouched::<EllgranContactForce>::sized();
                    let mut geometry = Untouched::<EllgranContactGeometry>::sized();
                    let flag = &mut alone.touching[i][m];
                    let before = *flag;
                    let history = &mut alone.history[i][m * length..(m + 1) * length];
                    // SAFETY: all arguments are valid.
                    let (f, penetration, contact_point) = unsafe {
                        ok(ellgran_contact(
                            laws.0,
                            &bodies[i],
                            &bodies[j],
                            &step,
                            flag,
                            history.as_mut_ptr(),
                            geometry.pointer(),
                            force.pointer(),
                        ));
                        (
                            *force.pointer(),
                            (*geometry.pointer()).penetration,
                            (*geometry.pointer()).contact_point,
                        )
                    };
                    for (scale, h) in memory_scale.iter_mut().zip(history.iter()) {
                        *scale = scale.max(h.abs());
                    }
                    seen.contacts += *flag as usize;
                    seen.begun += (*flag > before && n > 0) as usize;
                    seen.ended += (*flag < before) as usize;
                    seen.tangential += (size(&f.tangential_force) > 0.0) as usize;
                    let reacts = newton || j < OWNED;
                    let weight = if reacts { 1.0 } else { 0.5 };
                    let d: [f64; 3] =
                        std::array::from_fn(|k| bodies[j].position[k] - bodies[i].position[k]);
                    let virial = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
                        .map(|(a, b)| d[a] * f.force[b]);
                    // Of a small overlap of large bodies, rounding is the larger part.
                    let rounding = ROUNDING * size(&d) / penetration.abs();
                    let amplified = 1.0 + rounding / TOLERANCE;
                    // The elastic force, where the viscous one takes it away.
                    let elastic = 2.5 * f.elastic_energy / penetration.max(f64::MIN_POSITIVE);
                    let terms = size(&f.force).max(elastic);
                    let energy = 0.5 * (f.elastic_energy + f.tangential_energy);
                    // A viscous force that takes the elastic one away leaves its rounding.
                    let left = if f.normal_force > 0.0 {
                        (elastic / f.normal_force).max(1.0)
                    } else {
                        1.0
                    };
                    roundings[i].push(rounding * left);
                    for (k, sign, torque) in [(i, -1.0, f.torque_i), (j, 1.0, f.torque_j)] {
                        if k == j && !reacts {
                            continue;
                        }
                        add(&mut sums.forces[k], &f.force, sign);
                        add(&mut sums.torques[k], &torque, 1.0);
                        sums.force_scale[k] += amplified * terms;
                        sums.torque_scale[k] += amplified * (size(&torque) + terms);
                        sums.energies[k] += energy;
                        add(&mut sums.virials[k], &virial, 0.5);
                        let arm = std::array::from_fn(|c| contact_point[c] - bodies[k].position[c]);
                        for (part, force) in
                            [f.viscous_force, f.frictional_force].iter().enumerate()
                        {
                            add(&mut alone_loads[k][2 * part], force, sign);
                            add(&mut alone_loads[k][2 * part + 1], &cross(arm, *force), sign);
                        }
                    }
                    sums.normal_energy += weight * f.elastic_energy;
                    sums.tangential_energy += weight * f.tangential_energy;
                    add(&mut sums.virial, &virial, weight);
                    sums.virial_scale += size(&virial);
                    sums.touching += weight * f64::from(*flag);
                }
            }

            let at = format!("{what} step {n}");
            if length > 0 && written {
                assert_eq!(list.touching, alone.touching, "{at}");
            }
            // What is remembered of a pair that does not touch is a start for the search, not a result.
            for (i, flags) in list.touching.iter().enumerate() {
                for (m, _) in flags
                    .iter()
                    .enumerate()
                    .filter(|(_, f)| **f != 0 && written)
                {
                    let pair = m * length..(m + 1) * length;
                    let (a, b) = (&list.history[i][pair.clone()], &alone.history[i][pair]);
                    for k in 0..length {
                        // What slides is as large as the normal force allows, and the stiffness goes with the penetration.
                        let own = match k.checked_sub(normals) {
                            None => 0.0,
                            Some(0..3) => size(&b[normals..normals + 3]),
                            Some(_) => b[k].abs(),
                        };
                        let apart = close(
                            &a[k..=k],
                            &b[k..=k],
                            (HISTORY_TOLERANCE * memory_scale[k] + roundings[i][m] * own)
                                / TOLERANCE,
                            &format!("{at}: history {k}"),
                        );
                        seen.worst[2] = seen.worst[2].max(apart);
                    }
                }
            }
            let energy = sums.normal_energy + sums.tangential_energy;
            for k in 0..count {
                let at = format!("{at}: particle {k}");
                let apart = [
                    close(&arrays.forces[k], &sums.forces[k], sums.force_scale[k], &at),
                    close(
                        &arrays.torques[k],
                        &sums.torques[k],
                        sums.torque_scale[k],
                        &at,
                    ),
                ];
                for (worst, apart) in seen.worst.iter_mut().zip(apart) {
                    *worst = worst.max(apart);
                }
                close(&[energies[k]], &[sums.energies[k]], energy, &at);
                close(&virials[k], &sums.virials[k], sums.virial_scale, &at);
            }
            close(
                &[tallies.normal_elastic_energy],
                &[sums.normal_energy],
                energy,
                &at,
            );
            close(
                &[tallies.tangential_elastic_energy],
                &[sums.tangential_energy],
                energy,
                &at,
            );
            close(&tallies.virial, &sums.virial, sums.virial_scale, &at);
            // Who the loads are handed to, as torques or for angular momenta, and their work in the half step before.
            let handed = if newton { count } else { OWNED };
            for (k, load) in loads.iter().enumerate() {
                let b = &bodies[k];
                for (part, expected) in alone_loads[k].iter().enumerate() {
                    let mut given: [f64; 3] = std::array::from_fn(|c| load[3 * part + c]);
                    if self.momenta && part % 2 == 1 {
                        given = angular_momentum(b.semi_axes, b.quaternion, solid[k], given);
                    }
                    let scale = if part % 2 == 0 {
                        sums.force_scale[k]
                    } else {
                        sums.torque_scale[k]
                    };
                    close(
                        &given,
                        expected,
                        scale,
                        &format!("{at}: load {part} of {k}"),
                    );
                    if n > 0 && k < handed {
                        let motion = if part % 2 == 0 {
                            b.velocity
                        } else {
                            b.angular_velocity
                        };
                        let half = 0.5 * step.time_step;
                        works[part / 2] -= half * dot(*expected, motion);
                        work_scale += half * scale * size(&motion);
                    }
                }
            }
            let given = [tallies.viscous_dissipation, tallies.tangential_work];
            close(&given, &works, work_scale, &at);
            let friction = tallies.tangential_work - tallies.tangential_elastic_energy;
            assert_eq!(tallies.frictional_dissipation, friction, "{at}");
            let dissipated = tallies.viscous_dissipation + friction;
            assert_eq!(tallies.dissipated_energy, dissipated, "{at}");
            // The half step after, here with the same velocities: as much again by the owned particles.
            // SAFETY: all arrays live to the end of the step.
            unsafe {
                ok(ellgran_tally_following_half_step(
                    &particles,
                    &step,
                    &mut tallies,
                ));
            }
            if n > 0 {
                for (k, loads) in alone_loads.iter().enumerate().take(OWNED) {
                    let b = &bodies[k];
                    let half = 0.5 * step.time_step;
                    for (part, load) in loads.iter().enumerate() {
                        let motion = [b.velocity, b.angular_velocity][part % 2];
                        works[part / 2] -= half * dot(*load, motion);
                    }
                }
            }
            let given = [tallies.viscous_dissipation, tallies.tangential_work];
            close(&given, &works, 2.0 * work_scale, &at);
            assert_eq!(tallies.touching_count, sums.touching, "{at}");
            let pairs: usize = list.rows.iter().map(Vec::len).sum();
            assert_eq!(tallies.pair_count, pairs as i64, "{at}");
        }
    }
}

#[test]
fn every_combination_of_laws_with_newton_on() {
    let mut seen = Seen::default();
    let all = combinations();
    assert_eq!(all.len(), 624);
    for decks in &all {
        compare(decks, 0, true, 10, &mut seen);
    }
    seen.check(100_000);
}

#[test]
fn every_combination_of_laws_with_newton_off_and_ghosts() {
    let mut seen = Seen::default();
    for decks in &combinations() {
        compare(decks, 0, false, 10, &mut seen);
    }
    seen.check(100_000);
}

#[test]
fn a_longer_history() {
    let mut seen = Seen::default();
    let nfd = ["nfd 1e4 0.3 40 60", "nfd 3e4 0.2 90 30"];
    for tangential in tangential_laws() {
        let decks = [0, 1].map(|k| format!("{} {}", nfd[k], tangential[k]));
        for newton in [true, false] {
            compare(&decks, 0, newton, 40, &mut seen);
        }
    }
    seen.check(10_000);
}

#[test]
fn without_the_cached_normal() {
    let mut seen = Seen::default();
    for tangential in tangential_laws() {
        let decks = [0, 1].map(|k| {
            format!(
                "{} {}",
                ["hertz 1e4 0.3", "hertz 3e4 0.2"][k],
                tangential[k]
            )
        });
        for newton in [true, false] {
            compare(&decks, ELLGRAN_OPTION_NO_WARM_START, newton, 20, &mut seen);
        }
    }
    seen.check(10_000);
}
