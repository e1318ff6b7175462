// SPDX-License-Identifier: MIT OR Apache-2.0
//! A device on the host: its arrays, and its kernels index by index.

use crate::scene::{Lists, Motion, Scene, STEP, TIME_STEP};
use ellgran::contact::{Laws, Particle};
use ellgran::force::PairLaw;
use ellgran::geometry::Plane;
use ellgran::vector::Vector3;
use ellgran::walls;
use ellgran_kernels::arguments::ROWS_NUMBERED;
use ellgran_kernels::candidates::{candidates_of_grain, keeps, Candidate, NewRow};
use ellgran_kernels::contacts::{self, contact_of_pair, marked_contact_of_pair, Load, TOUCHES};
use ellgran_kernels::integration::{finish_step_of_grain, start_step_of_grain, Moving};
use ellgran_kernels::mixed::mixed_contact_of_pair;
use ellgran_kernels::planes::{contact_with_plane, MovingPlane};
use ellgran_kernels::preparation::{prepare_grain, EngineGrain, Fault};
use ellgran_kernels::shapes::{Grain, GrainChange, Kind};
use ellgran_kernels::terms::{
    component_of_load, number_rows, terms_of_grain, Candidates, ContactLoad, Names,
};

pub struct Device {
    grains: Vec<Grain>,
    /// Empty where velocities are those of the half step.
    changes: Vec<GrainChange>,
    types: Vec<u32>,
    inverse_masses: Vec<f64>,
    identifiers: Vec<i32>,
    laws: [PairLaw; 1],
    /// Grains that have a row; the others are ghosts.
    owned: usize,
    starts: Vec<u32>,
    neighbours: Vec<u32>,
    candidates: Vec<Candidate>,
    firsts: Vec<u32>,
    counts: Vec<u32>,
    terms: Vec<Vec<u32>>,
    states: Vec<u32>,
    histories: Vec<f64>,
    pub loads: Vec<Load>,
    /// Contacts with their search in single precision.
    pub mixed: bool,
    marked: usize,
    /// Where the grains were when candidates were selected.
    selected: Motion,
}

/// One grain, prepared.
pub fn prepare_one<K: Kind>(scene: &Scene, k: usize) -> Result<(Grain, GrainChange), Fault> {
    let m = &scene.motion;
    prepare_grain::<K>(&EngineGrain {
        position: m.positions[k],
        velocity: m.velocities[k],
        angular_momentum: m.angular_momenta[k],
        change: scene.changes().get(k).copied().unwrap_or_default(),
        mass: scene.masses[k],
        semi_axes: scene.semi_axes[k],
        quaternion: m.quaternions[k],
        particle_type: scene.types[k] as u32,
        type_count: 1,
    })
}

macro_rules! lent {
    ($device:expr, $laws:expr) => {
        contacts::Scene {
            grains: &$device.grains,
            changes: &$device.changes,
            types: &$device.types,
            inverse_masses: &$device.inverse_masses,
            identifiers: &$device.identifiers,
            laws: &$device.laws,
            type_count: 1,
            layout: $laws.layout(),
            step: STEP,
        }
    };
}

pub fn near(a: f64, b: f64, scale: f64, tolerance: f64, what: &str, k: usize) {
    assert!(
        (a - b).abs() <= tolerance * scale,
        "{what} of {k}: {a:e} {b:e}, apart by {:e} of {scale:e}",
        (a - b).abs() / scale
    );
}

impl Device {
    pub fn new(scene: &Scene, laws: &Laws) -> Device {
        let count = scene.count();
        let mut starts = vec![0];
        let mut neighbours = Vec::new();
        for i in 0..count {
            neighbours.extend((0..count as u32).filter(|&j| scene.are_neighbours(i, j as usize)));
            starts.push(neighbours.len() as u32);
        }
        Device {
            grains: vec![Grain::NONE; count],
            changes: Vec::new(),
            types: vec![1; count],
            inverse_masses: scene.masses.iter().map(|m| 1.0 / m).collect(),
            identifiers: (1..=count as i32).collect(),
            laws: [*laws.get(1, 1)],
            starts,
            owned: count,
            candidates: Vec::new(),
            firsts: vec![0; count],
            counts: vec![0; count],
            terms: Vec::new(),
            states: vec![0; neighbours.len()],
            histories: vec![0.0; neighbours.len() * laws.layout().length],
            neighbours,
            loads: vec![Load::NONE; count],
            mixed: false,
            marked: 0,
            selected: scene.motion.clone(),
        }
    }

    /// What the threads of a kernel read.
    pub fn lent(&self, laws: &Laws) -> contacts::Scene<'_> {
        lent!(self, laws)
    }

    /// A grain as the library's walls take it.
    pub fn particle<K: Kind>(&self, k: usize) -> Particle {
        let particle = K::particle(&self.grains[k], 1, self.inverse_masses[k]);
        let law = &self.laws[0].kinds;
        // A law that reads neither rates nor a stiffness over the step is not asked for them.
        let asks = law.normal.relaxation || law.normal.restitution || law.tangential.any();
        let changes = self.changes.get(k).filter(|_| asks);
        Particle {
            change: changes.map(GrainChange::motion),
            ..particle
        }
    }

    pub fn prepare<K: Kind>(&mut self, scene: &Scene) {
        self.changes.clear();
        for (k, grain) in self.grains.iter_mut().enumerate() {
            let (prepared, change) = prepare_one::<K>(scene, k).unwrap();
            *grain = prepared;
            if scene.of_step {
                self.changes.push(change);
            }
        }
    }

    /// The longest way of a point of a grain's surface since the last selection.
    pub fn largest_way(&self, scene: &Scene) -> f64 {
        let now = &scene.motion;
        let way = |k: usize| {
            let (x, y) = (now.positions[k], self.selected.positions[k]);
            let (q, p) = (now.quaternions[k], self.selected.quaternions[k]);
            let moved = (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>().sqrt();
            let cosine = (0..4).map(|c| q[c] * p[c]).sum::<f64>().abs().min(1.0);
            let largest = scene.semi_axes[k].iter().copied().fold(0.0, f64::max);
            moved + 2.0 * cosine.acos() * largest
        };
        (0..scene.count()).map(way).fold(0.0, f64::max)
    }

    pub fn select<K: Kind>(&mut self, scene: &Scene, laws: &Laws, margin: f64) {
        self.selected = scene.motion.clone();
        let length = laws.layout().length;
        let mut places = vec![0; self.neighbours.len()];
        for k in 0..self.owned {
            let (from, to) = (self.starts[k] as usize, self.starts[k + 1] as usize);
            let mut row = NewRow {
                neighbours: &self.neighbours[from..to],
                places: &mut places[from..to],
                states: &mut self.states[from..to],
                histories: &mut self.histories[from * length..to * length],
            };
            let scene = lent!(self, laws);
            let found = candidates_of_grain::<K>(k, &scene, self.owned, margin, &mut row);
            self.counts[k] = found as u32;
        }
        // A device comes to the rows in any order.
        let mut first = 0;
        let rows = (0..self.owned).step_by(ROWS_NUMBERED).rev();
        for rows in rows.map(|from| from..(from + ROWS_NUMBERED).min(self.owned)) {
            let counts = &self.counts[rows.clone()];
            number_rows(counts, first, &mut self.firsts[rows.clone()]);
            first += counts.iter().sum::<u32>();
        }
        self.candidates = vec![Candidate::default(); first as usize];
        let all = Candidates {
            starts: &self.starts,
            neighbours: &self.neighbours,
            places: &places,
            firsts: &self.firsts,
            counts: &self.counts,
        };
        let names = Names {
            identifiers: &self.identifiers,
            types: &self.types,
            type_count: 1,
        };
        self.terms = (0..self.owned)
            .map(|k| {
                let mut terms = vec![0; (self.starts[k + 1] - self.starts[k]) as usize];
                let first = self.firsts[k] as usize;
                let own = &mut self.candidates[first..first + self.counts[k] as usize];
                let found = terms_of_grain(k, &names, &all, own, &mut terms);
                terms.truncate(found);
                terms
            })
            .collect();
    }

    pub fn compute<K: Kind, const FRICTION: bool, const CONSERVATIVE: bool>(
        &mut self,
        laws: &Laws,
    ) {
        let length = laws.layout().length;
        self.marked = 0;
        let mut contacts = Vec::with_capacity(self.candidates.len());
        for candidate in &self.candidates {
            let entry = candidate.entry as usize;
            let scene = lent!(self, laws);
            let state = &mut self.states[entry];
            let history = &mut self.histories[entry * length..(entry + 1) * length];
            let of_pair = if self.mixed {
                mixed_contact_of_pair::<K, FRICTION, true, CONSERVATIVE>
            } else {
                contact_of_pair::<K, FRICTION, true, CONSERVATIVE>
            };
            let found = of_pair(&scene, candidate, state, history);
            let load: ContactLoad = found.unwrap_or_else(|| {
                self.marked += 1;
                marked_contact_of_pair::<K>(&scene, candidate, state, history)
            });
            contacts.push(load);
        }
        let read = |contact: usize, number: usize| contacts[contact].values()[number];
        for (load, terms) in self.loads.iter_mut().zip(&self.terms) {
            let [force, torque] = [0, 3].map(|first| {
                let sum = |c: usize| component_of_load(terms, read, first + c);
                Vector3::new(sum(0), sum(1), sum(2))
            });
            *load = Load { force, torque };
        }
    }

    /// The largest difference of a load from that of the lists, as a share of the largest of the scene.
    pub fn largest_difference(&self, scene: &Scene) -> f64 {
        let largest = |of: &[[f64; 3]]| of.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let force = largest(&scene.forces);
        let torque = largest(&scene.torques).max(force);
        let apart = |own: Vector3, other: [f64; 3], scale: f64| {
            let components = own.to_array().into_iter().zip(other);
            components.fold(0.0f64, |m, (a, b)| m.max((a - b).abs() / scale))
        };
        let all = self.loads.iter().zip(&scene.forces).zip(&scene.torques);
        all.fold(0.0, |m, ((load, f), t)| {
            m.max(apart(load.force, *f, force))
                .max(apart(load.torque, *t, torque))
        })
    }

    /// Loads, states and histories against those of the lists: how many pairs touch, and how many were marked.
    pub fn compare(
        &self,
        scene: &Scene,
        lists: &Lists,
        laws: &Laws,
        tolerance: f64,
    ) -> (usize, usize) {
        let largest = |of: &[[f64; 3]]| of.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let (force, torque) = (largest(&scene.forces), largest(&scene.torques).max(1e-300));
        // Torques are no smaller than what rounding of a force makes of them, in units of length of about 1.
        let torque = torque.max(force);
        for (k, load) in self.loads.iter().enumerate() {
            for c in 0..3 {
                let (f, t) = (load.force.to_array()[c], load.torque.to_array()[c]);
                near(f, scene.forces[k][c], force, tolerance, "force", k);
                near(t, scene.torques[k][c], torque, tolerance, "torque", k);
            }
        }
        let layout = laws.layout();
        let mut largest = vec![0.0f64; layout.length];
        for history in lists.histories.chunks(layout.length.max(1)) {
            for (m, x) in largest.iter_mut().zip(history) {
                *m = m.max(x.abs());
            }
        }
        let memory = layout.memory.map_or(1.0, |at| {
            largest[at..at + 3].iter().fold(0.0, |m, x| x.max(m))
        });
        let mut touching = 0;
        for i in 0..scene.count() {
            for at in self.starts[i] as usize..self.starts[i + 1] as usize {
                let j = self.neighbours[at] as usize;
                let (low, high) = (i.min(j), i.max(j));
                let half = (lists.starts[low]..lists.starts[low + 1])
                    .find(|&k| lists.neighbours[k] == high as i32)
                    .unwrap();
                let touches = self.states[at] & TOUCHES;
                if !keeps(&self.identifiers, self.owned, i, j) {
                    assert_eq!(touches, 0, "{i} {j}");
                    continue;
                }
                assert_eq!(touches as i32, lists.touching[half], "{i} {j}");
                if touches == 0 {
                    continue;
                }
                touching += 1;
                let own = &self.histories[at * layout.length..(at + 1) * layout.length];
                let other = &lists.histories[half * layout.length..(half + 1) * layout.length];
                for k in 0..layout.length {
                    let scale = if layout.normal.is_some_and(|n| (n..n + 3).contains(&k)) {
                        1.0
                    } else if Some(k) == layout.energy {
                        largest[k]
                    } else {
                        memory
                    };
                    near(own[k], other[k], scale, tolerance, "history", k);
                }
            }
        }
        (touching, self.marked)
    }

    /// The first half of a step from `before`, whose end is the scene.
    pub fn check_start(&self, scene: &Scene, before: &Motion) {
        self.check_motion(scene, before, |grain| {
            start_step_of_grain(grain, TIME_STEP).unwrap();
        });
    }

    /// The second half.
    pub fn check_finish(&self, scene: &Scene, before: &Motion) {
        self.check_motion(scene, before, |grain| {
            finish_step_of_grain(grain, TIME_STEP)
        });
    }

    fn check_motion(&self, scene: &Scene, before: &Motion, act: impl Fn(Moving<'_>)) {
        let mut m = before.clone();
        let largest = |of: [&[[f64; 3]]; 2]| {
            let all = of.into_iter().flat_map(|rows| rows.as_flattened());
            all.fold(0.0f64, |most, x| most.max(x.abs()))
        };
        let after = &scene.motion;
        let positions = largest([&before.positions, &after.positions]);
        let velocities = largest([&before.velocities, &after.velocities]);
        let momenta = largest([&before.angular_momenta, &after.angular_momenta]);
        let changes = velocities.max(momenta);
        for k in 0..scene.count() {
            act(Moving {
                position: &mut m.positions[k],
                velocity: &mut m.velocities[k],
                angular_momentum: &mut m.angular_momenta[k],
                quaternion: &mut m.quaternions[k],
                semi_axes: scene.semi_axes[k],
                mass: scene.masses[k],
                load: Load {
                    force: Vector3::from_array(scene.forces[k]),
                    torque: Vector3::from_array(scene.torques[k]),
                },
                extrapolation: scene.of_step.then_some((
                    &mut m.changes[k],
                    &mut m.loads_before[k],
                    1.0,
                )),
            });
            let reached = &scene.motion;
            assert_eq!(m.loads_before[k], reached.loads_before[k]);
            // The same operations, of which the lanes fuse some: of each quantity, a rounding of the largest that there is.
            for c in 0..6 {
                let (own, other) = (m.changes[k][c], reached.changes[k][c]);
                near(own, other, changes, 1e-15, "change", k);
            }
            for (own, other, largest) in [
                (&m.positions, &reached.positions, positions),
                (&m.velocities, &reached.velocities, velocities),
                (&m.angular_momenta, &reached.angular_momenta, momenta),
            ] {
                for c in 0..3 {
                    near(own[k][c], other[k][c], largest, 1e-15, "motion", k);
                }
            }
            for c in 0..4 {
                let (own, other) = (m.quaternions[k][c], reached.quaternions[k][c]);
                near(own, other, 1.0, 1e-15, "quaternion", k);
            }
        }
    }
}

/// Contacts with a plane through the scene, against those of one contact at a time.
pub fn planes<K: Kind, const FRICTION: bool, const CONSERVATIVE: bool>(
    laws: &Laws,
    mut scene: Scene,
    tolerance: f64,
) {
    let features = laws.features();
    assert_eq!(
        (features.friction, features.conservative),
        (FRICTION, CONSERVATIVE)
    );
    let mut device = Device::new(&scene, laws);
    let layout = laws.layout();
    let wall = MovingPlane {
        plane: Plane {
            point: Vector3::new(0.0, 0.0, 0.05),
            normal: Vector3::new(0.1, -0.2, 1.0).normalised(),
        },
        velocity: Vector3::new(0.3, 0.1, -0.2),
        velocity_change: Vector3::new(-0.02, 0.03, 0.05),
        wall_type: 1,
    };
    let same_wall = walls::MovingPlane {
        plane: wall.plane,
        velocity: wall.velocity,
        velocity_change: wall.velocity_change,
    };
    let count = scene.count();
    let mut states = vec![0u32; count];
    let mut histories = vec![0.0; count * layout.length];
    let mut other_states = vec![false; count];
    let mut other_histories = histories.clone();
    let mut touching = 0;
    for _ in 0..20 {
        scene.start_step();
        device.prepare::<K>(&scene);
        for k in 0..count {
            let part = k * layout.length..(k + 1) * layout.length;
            let load = contact_with_plane::<K, FRICTION, true, CONSERVATIVE>(
                k,
                &lent!(device, laws),
                &wall,
                &mut states[k],
                &mut histories[part.clone()],
            );
            let particle = K::particle(&device.grains[k], 1, device.inverse_masses[k]);
            let found = walls::one_contact_with_plane(
                laws,
                &particle,
                &same_wall,
                1,
                &STEP,
                &mut other_states[k],
                &mut other_histories[part.clone()],
            )
            .unwrap();
            assert_eq!(states[k] != 0, other_states[k]);
            let Some((_, f)) = found else {
                assert_eq!(load, Load::NONE);
                continue;
            };
            touching += 1;
            let size = f.force.norm();
            let apart = (load.force + f.force).norm() + (load.torque - f.torque_i).norm();
            near(apart, 0.0, size, tolerance, "load", k);
            for (own, other) in histories[part.clone()].iter().zip(&other_histories[part]) {
                near(*own, *other, 1.0 + size, tolerance, "history", k);
            }
        }
    }
    assert!(touching > 100, "{touching}");
}
