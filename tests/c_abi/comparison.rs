// SPDX-License-Identifier: MIT OR Apache-2.0
//! A list computed in one call beside its contacts one at a time, step after step, and each quantity of the one held against the other.
//!
//! What differs is named by quantity, particle, step and laws.

use std::ptr::null;

use ellgran::c_api::contact::*;
use ellgran::c_api::law::ELLGRAN_OPTION_NO_WARM_START;
use ellgran::c_api::neighbour_list::ellgran_write_history;
use ellgran::c_api::particles::{EllgranParticles, EllgranStep};
use ellgran::c_api::tallies::{ellgran_tally_following_half_step, EllgranTallies};

use crate::formulas::{angular_momentum, cross, dot, length, normalise};
use crate::scene::*;

const OWNED: usize = 44;
/// Of the terms of a sum; the search for the normal ends at about this.
const TOLERANCE: f64 = 2e-13;
/// Of the cached normal and of the tangential memory, which feel the normal's error in first order.
const HISTORY_TOLERANCE: f64 = 5e-13;
/// Rounding of the coordinates, a few units in the last place.
const ROUNDING: f64 = 2e-15;

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

/// What is computed both ways.
pub struct Comparison {
    pub decks: [String; 2],
    pub options: u32,
    pub newton: bool,
    pub steps: usize,
    pub bodies: Vec<EllgranBody>,
    /// Angular momenta in place of angular velocities, and contact masses of their own.
    pub momenta: bool,
    /// By how much more than usually the two may differ: where coordinates have fewer digits than the grains.
    pub wider: f64,
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
            wider: 1.0,
            keeps_history: false,
            unchanged: |step| step > 0,
            change: |_, _| (),
        }
    }

    pub fn run(mut self, seen: &mut Seen) {
        let laws = Laws::with_options(&[&self.decks[0], &self.decks[1]], self.options);
        let mut bodies = std::mem::take(&mut self.bodies);
        let list = || List::near(&bodies, OWNED, laws.length());
        let mut run = Run {
            list: list(),
            alone: list(),
            case: &self,
            laws: &laws,
            workspace: WorkspaceHandle::new(),
            tallies: no_tallies(),
            works: [0.0; 2],
            work_scale: 0.0,
            number: 0,
            seen,
        };
        for number in 0..self.steps {
            run.number = number;
            if number > 0 {
                advance(&mut bodies, STEP.time_step);
            }
            (self.change)(number, &mut bodies);
            let listed = run.list_in_one_call(&bodies);
            let alone = run.contacts_one_by_one(&bodies);
            run.histories(&listed, &alone);
            run.forces_and_torques(&listed, &alone);
            run.energies_and_virials(&listed, &alone);
            run.inelastic_loads(&bodies, &listed, &alone);
            run.dissipation(&bodies, listed, &alone);
            run.counts(&alone);
        }
    }
}

/// What a step of the list gave; the arrays that the call had pointers to.
struct Listed {
    arrays: Arrays,
    particles: EllgranParticles,
    energies: Vec<f64>,
    virials: Vec<[f64; 6]>,
    loads: Vec<[[f64; 3]; 4]>,
    solid_masses: Vec<f64>,
    _momenta: Vec<[f64; 3]>,
    /// Whether the histories are those of this step.
    written: bool,
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
    /// Viscous force and moment, frictional force and moment, of each particle.
    loads: Vec<[[f64; 3]; 4]>,
    normal_energy: f64,
    tangential_energy: f64,
    virial: [f64; 6],
    virial_scale: f64,
    touching: f64,
    /// Largest of each number of the histories, and what rounding does to those of each pair.
    history_scale: Vec<f64>,
    history_rounding: Vec<Vec<f64>>,
}

struct Run<'a> {
    case: &'a Comparison,
    laws: &'a Laws,
    workspace: WorkspaceHandle,
    list: List,
    alone: List,
    tallies: EllgranTallies,
    /// Of the viscous and of the frictional loads, all steps so far.
    works: [f64; 2],
    work_scale: f64,
    number: usize,
    seen: &'a mut Seen,
}

impl Run<'_> {
    /// The first step is the set-up of a run: nothing advances.
    fn step(&self) -> EllgranStep {
        EllgranStep {
            advance_history: i32::from(self.number > 0),
            ..STEP
        }
    }

    /// Fails if the two ways differ by more than the tolerance times `scale`; the difference in units of that.
    #[track_caller]
    fn close(&self, quantity: &str, of: usize, list: &[f64], alone: &[f64], scale: f64) -> f64 {
        let pairs = || list.iter().zip(alone);
        let tolerance = TOLERANCE * self.case.wider;
        let finite = pairs().all(|(x, y)| x.is_finite() && y.is_finite());
        let apart = pairs().map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(
            finite && apart <= tolerance * scale,
            "{quantity} {of}: the list gives {list:?}, single contacts {alone:?}, apart by {:e} where {tolerance:e} is allowed; {}",
            apart / scale,
            self.described()
        );
        apart / (tolerance * scale).max(f64::MIN_POSITIVE)
    }

    fn described(&self) -> String {
        let case = self.case;
        format!(
            "step {}, laws {:?}, newton {}, options {}, angular momenta {}, history kept {}",
            self.number, case.decks, case.newton, case.options, case.momenta, case.keeps_history
        )
    }

    fn list_in_one_call(&mut self, bodies: &[EllgranBody]) -> Listed {
        let (case, number, step) = (self.case, self.number, self.step());
        let mut arrays = Arrays::new(bodies, OWNED);
        let solid_masses: Vec<f64> = bodies.iter().map(|b| b.mass.min(3.0)).collect();
        let momentum = |(b, m): (&EllgranBody, &f64)| {
            angular_momentum(*m, b.semi_axes, normalise(b.quaternion), b.angular_velocity)
        };
        let momenta: Vec<[f64; 3]> = bodies.iter().zip(&solid_masses).map(momentum).collect();
        let mut particles = arrays.particles();
        if case.momenta {
            particles.contact_masses = particles.masses;
            particles.masses = solid_masses.as_ptr();
            particles.angular_velocities = null();
            particles.angular_momenta = momenta.as_ptr().cast();
        }
        let mut listed = Listed {
            arrays,
            particles,
            energies: vec![0.0; bodies.len()],
            virials: vec![[0.0; 6]; bodies.len()],
            // What is there is overwritten.
            loads: vec![[[7.0; 3]; 4]; bodies.len()],
            solid_masses,
            _momenta: momenta,
            // What is kept is written before the list is another, and now and then.
            written: !case.keeps_history || number % 3 == 2 || !(case.unchanged)(number + 1),
        };
        self.tallies.particle_energies = listed.energies.as_mut_ptr();
        self.tallies.particle_virials = listed.virials.as_mut_ptr().cast();
        self.tallies.inelastic_loads = listed.loads.as_mut_ptr().cast();
        let mut view = self.list.view(case.newton);
        view.unchanged = i32::from((case.unchanged)(number));
        view.keep_history = i32::from(case.keeps_history);
        // All arrays live in what is returned, to the end of the step.
        let (workspace, tallies) = (&self.workspace, &mut self.tallies);
        ok(self
            .laws
            .pairs(workspace, &listed.particles, &view, &step, tallies));
        if case.keeps_history && listed.written {
            // SAFETY: the list is that of the call.
            ok(unsafe { ellgran_write_history(self.workspace.0, &view) });
        }
        listed
    }

    fn contacts_one_by_one(&mut self, bodies: &[EllgranBody]) -> Sums {
        let (count, entries, step) = (bodies.len(), self.laws.length(), self.step());
        let mut sums = Sums {
            forces: vec![[0.0; 3]; count],
            torques: vec![[0.0; 3]; count],
            force_scale: vec![0.0; count],
            torque_scale: vec![0.0; count],
            energies: vec![0.0; count],
            virials: vec![[0.0; 6]; count],
            loads: vec![[[0.0; 3]; 4]; count],
            normal_energy: 0.0,
            tangential_energy: 0.0,
            virial: [0.0; 6],
            virial_scale: 0.0,
            touching: 0.0,
            history_scale: vec![0.0; entries],
            history_rounding: vec![Vec::new(); OWNED],
        };
        for i in 0..OWNED {
            for (m, j) in self.alone.rows[i].iter().map(|j| *j as usize).enumerate() {
                let flag = &mut self.alone.touching[i][m];
                let before = *flag;
                let history = &mut self.alone.history[i][m * entries..(m + 1) * entries];
                let pair = [&bodies[i], &bodies[j]];
                let (g, f) = self.laws.contact(pair, &step, flag, history);
                for (scale, h) in sums.history_scale.iter_mut().zip(history.iter()) {
                    *scale = scale.max(h.abs());
                }
                self.seen.contacts += *flag as usize;
                self.seen.begun += (*flag > before && self.number > 0) as usize;
                self.seen.ended += (*flag < before) as usize;
                self.seen.tangential += (length(f.tangential_force) > 0.0) as usize;
                let reacts = self.case.newton || j < OWNED;
                let rounding = sums.add(bodies, [i, j], &f, &g, f64::from(*flag), reacts);
                sums.history_rounding[i].push(rounding);
            }
        }
        sums
    }

    fn histories(&mut self, listed: &Listed, sums: &Sums) {
        let entries = self.laws.length();
        if entries == 0 || !listed.written {
            return;
        }
        let (list, alone) = (&self.list, &self.alone);
        assert_eq!(
            list.touching,
            alone.touching,
            "flags of touch; {}",
            self.described()
        );
        let springs = self.case.decks[0].contains("hysteretic")
            && !self.case.decks[0].contains("viscosity memory");
        let no_warm_start = self.case.options & ELLGRAN_OPTION_NO_WARM_START != 0;
        let normals = if no_warm_start { 0 } else { 3 };
        let mut worst = self.seen.worst[2];
        for (i, flags) in list.touching.iter().enumerate() {
            // What is remembered of a pair that does not touch is a start for the search, not a result.
            for (m, _) in flags.iter().enumerate().filter(|(_, flag)| **flag != 0) {
                let pair = m * entries..(m + 1) * entries;
                let (a, b) = (&list.history[i][pair.clone()], &alone.history[i][pair]);
                for k in 0..entries {
                    // What slides is as large as the normal force allows, and the stiffness goes with the penetration.
                    let own = match k.checked_sub(normals) {
                        None => 0.0,
                        Some(0..=2) => length([b[normals], b[normals + 1], b[normals + 2]]),
                        // Forces of springs, after the energy, and their torques: the share of a spring is a difference of those of two edges.
                        Some(4..=27) if springs => {
                            let forces = b[normals + 4..normals + 28].chunks_exact(3);
                            forces.map(|f| length([f[0], f[1], f[2]])).sum()
                        }
                        Some(30..=37) if springs && entries >= normals + 38 => {
                            b[normals + 30..normals + 38].iter().map(|t| t.abs()).sum()
                        }
                        Some(_) => b[k].abs(),
                    };
                    let scale = HISTORY_TOLERANCE * sums.history_scale[k]
                        + sums.history_rounding[i][m] * own;
                    let quantity = format!("entry {m} of particle {i}, history");
                    let apart = self.close(&quantity, k, &a[k..=k], &b[k..=k], scale / TOLERANCE);
                    worst = worst.max(apart);
                }
            }
        }
        self.seen.worst[2] = worst;
    }

    fn forces_and_torques(&mut self, listed: &Listed, sums: &Sums) {
        for k in 0..sums.forces.len() {
            let (forces, torques) = (&listed.arrays.forces[k], &listed.arrays.torques[k]);
            let apart = [
                self.close(
                    "force on particle",
                    k,
                    forces,
                    &sums.forces[k],
                    sums.force_scale[k],
                ),
                self.close(
                    "torque on particle",
                    k,
                    torques,
                    &sums.torques[k],
                    sums.torque_scale[k],
                ),
            ];
            for (worst, apart) in self.seen.worst.iter_mut().zip(apart) {
                *worst = worst.max(apart);
            }
        }
    }

    fn energies_and_virials(&self, listed: &Listed, sums: &Sums) {
        let (tallies, scale) = (&self.tallies, sums.virial_scale);
        let energy = sums.normal_energy + sums.tangential_energy;
        for k in 0..sums.energies.len() {
            let (a, b) = (&[listed.energies[k]], &[sums.energies[k]]);
            self.close("energy of particle", k, a, b, energy);
            self.close(
                "virial of particle",
                k,
                &listed.virials[k],
                &sums.virials[k],
                scale,
            );
        }
        let total = |quantity: &str, list: &[f64], alone: &[f64], scale: f64| {
            self.close(quantity, 0, list, alone, scale);
        };
        let (normal, tangential) = (
            tallies.normal_elastic_energy,
            tallies.tangential_elastic_energy,
        );
        total(
            "normal elastic energy",
            &[normal],
            &[sums.normal_energy],
            energy,
        );
        total(
            "tangential elastic energy",
            &[tangential],
            &[sums.tangential_energy],
            energy,
        );
        total("virial", &tallies.virial, &sums.virial, scale);
    }

    /// Those that are handed to the particles, as torques or for angular momenta, and their work in the half step before.
    fn inelastic_loads(&mut self, bodies: &[EllgranBody], listed: &Listed, sums: &Sums) {
        let handed = if self.case.newton {
            bodies.len()
        } else {
            OWNED
        };
        for (k, load) in listed.loads.iter().enumerate() {
            let b = &bodies[k];
            for (part, expected) in sums.loads[k].iter().enumerate() {
                let turns = part % 2 == 1;
                let mut given = load[part];
                if self.case.momenta && turns {
                    given = angular_momentum(
                        listed.solid_masses[k],
                        b.semi_axes,
                        normalise(b.quaternion),
                        given,
                    );
                }
                let scale = [sums.force_scale[k], sums.torque_scale[k]][part % 2];
                let quantity = [
                    "viscous force",
                    "viscous moment",
                    "frictional force",
                    "frictional moment",
                ];
                self.close(
                    &format!("{} on particle", quantity[part]),
                    k,
                    &given,
                    expected,
                    scale,
                );
                if self.number > 0 && k < handed {
                    let motion = at_half_step(b)[part % 2];
                    let half = 0.5 * STEP.time_step;
                    self.works[part / 2] -= half * dot(*expected, motion);
                    self.work_scale += half * scale * length(motion);
                }
            }
        }
    }

    fn dissipation(&mut self, bodies: &[EllgranBody], listed: Listed, sums: &Sums) {
        let (number, step) = (self.number, self.step());
        let t = &self.tallies;
        let given = [t.viscous_dissipation, t.tangential_work];
        // What the memory of the normal force dissipates is no force's work: dissipation.rs closes the balance with it.
        let remembers = self.case.decks[0].contains("viscosity memory");
        let from = usize::from(remembers);
        self.close(
            "viscous dissipation and tangential work",
            0,
            &given[from..],
            &self.works[from..],
            self.work_scale,
        );
        if remembers {
            assert!(given[0] >= 0.0, "{}", self.described());
            self.works[0] = given[0];
        }
        let friction = t.tangential_work - t.tangential_elastic_energy;
        assert_eq!(
            t.frictional_dissipation,
            friction,
            "friction; {}",
            self.described()
        );
        let dissipated = t.viscous_dissipation + friction;
        assert_eq!(
            t.dissipated_energy,
            dissipated,
            "dissipated energy; {}",
            self.described()
        );
        // The half step after, here with the same velocities: as much again by the owned particles.
        // SAFETY: all arrays live to the end of the step.
        unsafe {
            ok(ellgran_tally_following_half_step(
                &listed.particles,
                &step,
                &mut self.tallies,
            ));
        }
        if number > 0 {
            for (b, loads) in bodies.iter().zip(&sums.loads).take(OWNED) {
                for (part, load) in loads.iter().enumerate() {
                    let motion = at_half_step(b)[part % 2];
                    self.works[part / 2] -= 0.5 * STEP.time_step * dot(*load, motion);
                }
            }
        }
        let given = [
            self.tallies.viscous_dissipation,
            self.tallies.tangential_work,
        ];
        let scale = 2.0 * self.work_scale;
        self.close(
            "dissipation and work after both half steps",
            0,
            &given,
            &self.works,
            scale,
        );
    }

    fn counts(&self, sums: &Sums) {
        let pairs: usize = self.list.rows.iter().map(Vec::len).sum();
        let given = (self.tallies.touching_count, self.tallies.pair_count);
        assert_eq!(
            given,
            (sums.touching, pairs as i64),
            "touching, listed; {}",
            self.described()
        );
    }
}

impl Sums {
    /// What rounding does to the history of the contact, relative.
    fn add(
        &mut self,
        bodies: &[EllgranBody],
        [i, j]: [usize; 2],
        f: &EllgranContactForce,
        g: &EllgranContactGeometry,
        touching: f64,
        reacts: bool,
    ) -> f64 {
        let weight = if reacts { 1.0 } else { 0.5 };
        let d: [f64; 3] = std::array::from_fn(|k| bodies[j].position[k] - bodies[i].position[k]);
        let virial =
            [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|(a, b)| d[a] * f.force[b]);
        // Of a small overlap of large bodies, rounding is the larger part.
        let rounding = ROUNDING * length(d) / g.penetration.abs();
        let amplified = 1.0 + rounding / TOLERANCE;
        // The elastic force, where the viscous one takes it away.
        let elastic = 2.5 * f.elastic_energy / g.penetration.max(f64::MIN_POSITIVE);
        let terms = length(f.force).max(elastic);
        let energy = 0.5 * (f.elastic_energy + f.tangential_energy);
        for (k, sign, torque) in [(i, -1.0, f.torque_i), (j, 1.0, f.torque_j)] {
            if k == j && !reacts {
                continue;
            }
            add(&mut self.forces[k], &f.force, sign);
            add(&mut self.torques[k], &torque, 1.0);
            self.force_scale[k] += amplified * terms;
            self.torque_scale[k] += amplified * (length(torque) + terms);
            self.energies[k] += energy;
            add(&mut self.virials[k], &virial, 0.5);
            let arm = std::array::from_fn(|c| g.contact_point[c] - bodies[k].position[c]);
            for (part, force) in [f.viscous_force, f.frictional_force].iter().enumerate() {
                add(&mut self.loads[k][2 * part], force, sign);
                add(&mut self.loads[k][2 * part + 1], &cross(arm, *force), sign);
            }
            // The couple is given as on i.
            for (part, couple) in [f.viscous_couple, f.frictional_couple].iter().enumerate() {
                add(&mut self.loads[k][2 * part + 1], couple, -sign);
            }
        }
        self.normal_energy += weight * f.elastic_energy;
        self.tangential_energy += weight * f.tangential_energy;
        add(&mut self.virial, &virial, weight);
        self.virial_scale += virial.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.touching += weight * touching;
        // A viscous force that takes the elastic one away leaves its rounding.
        let left = if f.normal_force > 0.0 {
            (elastic / f.normal_force).max(1.0)
        } else {
            1.0
        };
        rounding * left
    }
}

/// Velocity and angular velocity of the half step, in which loads do their work.
fn at_half_step(b: &EllgranBody) -> [[f64; 3]; 2] {
    let mut motion = [b.velocity, b.angular_velocity];
    if b.velocities_of_step != 0 {
        for (of, change) in motion
            .iter_mut()
            .zip([b.velocity_change, b.angular_velocity_change])
        {
            *of = std::array::from_fn(|k| of[k] - change[k]);
        }
    }
    motion
}

fn add(sum: &mut [f64], term: &[f64], sign: f64) {
    for (s, t) in sum.iter_mut().zip(term) {
        *s += sign * t;
    }
}
