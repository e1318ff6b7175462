// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steps through the C interface on the stand-in for a driver, against the library's lists in lanes: loads, histories and motion, with
//! ghosts, and with new neighbour lists for which the engine has brought its grains into another order.

#![allow(unsafe_code)]
// Each block calls functions of the interface with pointers to locals that outlive the call.
#![allow(clippy::undocumented_unsafe_blocks)]

mod engine_arrays;
mod planes;
#[allow(dead_code)]
#[path = "../../../kernels/tests/lanes/scene.rs"]
mod scene;
#[path = "../support/mod.rs"]
mod support;
mod walls;

use ellgran::c_api::particles::EllgranStep;
use ellgran::contact::{HistoryLayout, Laws};
use ellgran::tallies::Tallies;
use ellgran_gpu::arrays::{
    EllgranGpuCounts, EllgranGpuGrains, EllgranGpuHistories, EllgranGpuList, EllgranGpuLoads,
    EllgranGpuMotion, EllgranGpuTallies, ELLGRAN_GPU_ANY_SHAPES, ELLGRAN_GPU_DOUBLE,
    ELLGRAN_GPU_ELLIPSOIDS, ELLGRAN_GPU_MIXED, ELLGRAN_GPU_SPHERES, ELLGRAN_GPU_SPHEROIDS,
};
use ellgran_gpu::c_api::gpu::{ellgran_gpu_free, EllgranGpu};
use ellgran_gpu::c_api::scene::{
    ellgran_gpu_check, ellgran_gpu_counts, ellgran_gpu_histories, ellgran_gpu_new_list,
    ellgran_gpu_read_histories, ellgran_gpu_scene_free, ellgran_gpu_scene_new,
    ellgran_gpu_scene_set_precision, ellgran_gpu_tally_pairs, ellgran_gpu_write_histories,
    EllgranGpuScene,
};
use ellgran_gpu::c_api::step::{
    ellgran_gpu_compute_pairs, ellgran_gpu_finish_step, ellgran_gpu_prepare, ellgran_gpu_start_step,
};
use engine_arrays::{Bodies, Layout, Vectors};
use scene::{Lists, Scene, TIME_STEP};
use support::{new, succeed, with_driver, Array, Engine};

/// Of force, torque and history, relative to the largest of the scene.
const TOLERANCE: f64 = 1e-12;
/// In mixed precision.
const MIXED_TOLERANCE: f64 = 1e-5;
const STEPS: usize = 60;
/// Steps with one neighbour list.
const BETWEEN_LISTS: usize = 15;
const MARGIN: f64 = 0.2;
/// Of the grains of a scene, the last ones are ghosts.
const GHOSTS: usize = 25;

const ELASTIC: &str = "hertz 1e7 0.3";
const ELASTIC_PLAIN: &str = "hertz 1e7 0.3 conservative no";
const MINDLIN: &str = "hertz 1e7 0.3 damping restitution 0.7 tangential mindlin 0.5";
const VISCOELASTIC: &str = "nfd 1e7 0.3 300 200 tangential tfd 0.5 conservative no";
const WHOLE: &str = "nfd 1e7 0.3 300 200 tangential tfd 0.5 conservative yes";
const TOTAL: &str = "nfd 1e7 0.3 300 200 tangential tfd 0.5 displacement total";
const LINEAR: &str = "lsd 1e5 10 tangential linear 5e4 3 0.4";

/// A law for each type, parted by ` | `.
fn laws_on_host(words: &str) -> Laws {
    let own: Vec<_> = words.split(" | ").collect();
    let n = own.len();
    let parsed = |words: &str| {
        let words: Vec<&str> = words.split(' ').collect();
        ellgran::force::syntax::parse(&words).unwrap().0
    };
    let table: Vec<_> = (0..n * n)
        .map(|k| (k % (n + 1) == 0).then(|| parsed(own[k / n])))
        .collect();
    Laws::new(n, &table, true).unwrap()
}

fn near(a: f64, b: f64, scale: f64, tolerance: f64, what: &str, k: usize) {
    assert!(
        (a - b).abs() <= tolerance * scale,
        "{what} of {k}: {a:e} {b:e}, apart by {:e} of {scale:e}",
        (a - b).abs() / scale
    );
}

/// The order in which the engine has the grains: owned ones first. Another one for each `round`.
fn order(count: usize, owned: usize, round: usize) -> Vec<usize> {
    let mixed = |first: usize, n: usize| -> Vec<usize> {
        // Without a common divisor with 2, 5 and 10, of which the numbers of grains are products.
        let stride = [1, 3, 7, 11, 13][round % 5];
        (0..n).map(|k| first + (k * stride + round) % n).collect()
    };
    let mut all = mixed(0, owned);
    all.extend(mixed(owned, count - owned));
    all
}

/// The engine's arrays on the device.
struct OnDevice {
    engine: Engine,
    /// Which grain of the scene is where.
    order: Vec<usize>,
    owned: usize,
    positions: Vectors<3>,
    velocities: Vectors<3>,
    momenta: Vectors<3>,
    bodies: Bodies,
    changes: Array<[f64; 6]>,
    loads_before: Array<[f64; 6]>,
    masses: Array<f64>,
    types: Array<i32>,
    identifiers: Array<i32>,
    forces: Vectors<3>,
    torques: Vectors<3>,
    starts: Vec<u32>,
    neighbours: Vec<u32>,
    lists: (Array<u32>, Array<u32>),
    of_step: bool,
}

fn sorted<T: Copy>(order: &[usize], values: &[T]) -> Vec<T> {
    order.iter().map(|&k| values[k]).collect()
}

impl OnDevice {
    fn new(
        engine: Engine,
        scene: &Scene,
        owned: usize,
        with_neighbours: bool,
        layout: Layout,
    ) -> OnDevice {
        let order = order(scene.count(), owned, 0);
        let m = &scene.motion;
        let identifiers: Vec<i32> = (1..=scene.count() as i32).collect();
        let mut made = OnDevice {
            positions: Vectors::put(&engine, layout, &sorted(&order, &m.positions)),
            velocities: Vectors::put(&engine, layout, &sorted(&order, &m.velocities)),
            momenta: Vectors::put(&engine, layout, &sorted(&order, &m.angular_momenta)),
            bodies: Bodies::put(
                &engine,
                layout,
                &sorted(&order, &scene.semi_axes),
                &sorted(&order, &m.quaternions),
            ),
            changes: engine.put(&sorted(&order, &m.changes)),
            loads_before: engine.put(&sorted(&order, &m.loads_before)),
            masses: engine.put(&sorted(&order, &scene.masses)),
            types: engine.put(&sorted(&order, &scene.types)),
            identifiers: engine.put(&sorted(&order, &identifiers)),
            forces: Vectors::put(&engine, layout, &vec![[0.0; 3]; owned]),
            torques: Vectors::put(&engine, layout, &vec![[0.0; 3]; owned]),
            starts: Vec::new(),
            neighbours: Vec::new(),
            lists: (engine.put(&[]), engine.put(&[])),
            of_step: scene.of_step,
            engine,
            owned,
            order,
        };
        made.list(scene, with_neighbours);
        made
    }

    fn list(&mut self, scene: &Scene, with_neighbours: bool) {
        self.starts = vec![0];
        self.neighbours.clear();
        for &i in &self.order[..self.owned] {
            let row = (0..self.order.len() as u32)
                .filter(|&j| with_neighbours && scene.are_neighbours(i, self.order[j as usize]));
            self.neighbours.extend(row);
            self.starts.push(self.neighbours.len() as u32);
        }
        self.lists = (
            self.engine.put(&self.starts),
            self.engine.put(&self.neighbours),
        );
    }

    /// Another order of the grains, and a list of where they are now.
    fn begin_anew(&mut self, scene: &Scene, round: usize, with_neighbours: bool) {
        let loads = self.loads();
        self.order = order(scene.count(), self.owned, round);
        self.write_all(scene);
        let identifiers: Vec<i32> = self.order.iter().map(|&k| k as i32 + 1).collect();
        self.engine.write(&self.identifiers, 0, &identifiers);
        let axes = sorted(&self.order, &scene.semi_axes);
        self.bodies.write_semi_axes(&self.engine, &axes);
        let masses = sorted(&self.order, &scene.masses);
        self.engine.write(&self.masses, 0, &masses);
        let types = sorted(&self.order, &scene.types);
        self.engine.write(&self.types, 0, &types);
        for (vectors, first) in [(&self.forces, 0), (&self.torques, 3)] {
            let of = |&k: &usize| std::array::from_fn(|c| loads[k][first + c]);
            let sorted: Vec<[f64; 3]> = self.order[..self.owned].iter().map(of).collect();
            vectors.write(&self.engine, 0, &sorted);
        }
        self.list(scene, with_neighbours);
    }

    /// All that moves, as the scene has it.
    fn write_all(&self, scene: &Scene) {
        self.write_from(scene, 0);
    }

    /// Of the grains from `first` on.
    fn write_from(&self, scene: &Scene, first: usize) {
        let (e, m) = (&self.engine, &scene.motion);
        let order = &self.order[first..];
        self.positions.write(e, first, &sorted(order, &m.positions));
        self.velocities
            .write(e, first, &sorted(order, &m.velocities));
        self.momenta
            .write(e, first, &sorted(order, &m.angular_momenta));
        let quaternions = sorted(order, &m.quaternions);
        self.bodies.write_quaternions(e, first, &quaternions);
        e.write(&self.changes, first, &sorted(order, &m.changes));
        e.write(&self.loads_before, first, &sorted(order, &m.loads_before));
    }

    fn grains(&self) -> EllgranGpuGrains {
        EllgranGpuGrains {
            owned_count: self.owned,
            count: self.order.len(),
            positions: self.positions.vectors(),
            velocities: self.velocities.vectors(),
            angular_momenta: self.momenta.vectors(),
            velocity_changes: if self.of_step {
                self.changes.pointer()
            } else {
                core::ptr::null()
            },
            masses: self.masses.pointer(),
            semi_axes: self.bodies.semi_axes(),
            quaternions: self.bodies.quaternions(),
            body_places: self.bodies.places(),
            body_count: self.bodies.count,
            types: self.types.pointer(),
            identifiers: self.identifiers.pointer(),
            ..new()
        }
    }

    fn motion(&self) -> EllgranGpuMotion {
        EllgranGpuMotion {
            count: self.owned,
            positions: self.positions.vectors(),
            velocities: self.velocities.vectors(),
            angular_momenta: self.momenta.vectors(),
            quaternions: self.bodies.quaternions(),
            semi_axes: self.bodies.semi_axes(),
            body_places: self.bodies.places(),
            body_count: self.bodies.count,
            masses: self.masses.pointer(),
            forces: self.forces.vectors(),
            torques: self.torques.vectors(),
            velocity_changes: if self.of_step {
                self.changes.pointer()
            } else {
                core::ptr::null_mut()
            },
            loads_before: self.loads_before.pointer(),
            ..new()
        }
    }

    fn neighbour_list(&self) -> EllgranGpuList {
        EllgranGpuList {
            starts: self.lists.0.pointer(),
            neighbours: if self.neighbours.is_empty() {
                core::ptr::null()
            } else {
                self.lists.1.pointer()
            },
            margin: MARGIN,
            ..new()
        }
    }

    fn to_load(&self) -> EllgranGpuLoads {
        EllgranGpuLoads {
            forces: self.forces.vectors(),
            torques: self.torques.vectors(),
            ..new()
        }
    }

    /// Force and torque of the owned grains, in the order of the scene; zeros for ghosts.
    fn loads(&self) -> Vec<[f64; 6]> {
        let forces = self.forces.read(&self.engine);
        let torques = self.torques.read(&self.engine);
        let both = forces.iter().zip(&torques);
        let loads: Vec<[f64; 6]> = both
            .map(|(f, t)| [f[0], f[1], f[2], t[0], t[1], t[2]])
            .collect();
        self.in_order_of_the_scene(&loads)
    }

    fn in_order_of_the_scene<T: Copy + Default>(&self, values: &[T]) -> Vec<T> {
        let mut all = vec![T::default(); self.order.len()];
        for (&k, &value) in self.order[..self.owned].iter().zip(values) {
            all[k] = value;
        }
        all
    }

    /// What moves, against the scene: the same operations, of which lanes fuse some. The scene goes on from what the
    /// device has.
    fn compare_motion(&self, scene: &mut Scene) {
        let e = &self.engine;
        let positions = self.in_order_of_the_scene(&self.positions.read(e));
        let velocities = self.in_order_of_the_scene(&self.velocities.read(e));
        let momenta = self.in_order_of_the_scene(&self.momenta.read(e));
        let quaternions = self.in_order_of_the_scene(&self.bodies.read_quaternions(e));
        let changes = self.in_order_of_the_scene(&e.read(&self.changes));
        let m = &mut scene.motion;
        let largest = |of: &[[f64; 3]]| of.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let scales = [&m.positions, &m.velocities, &m.angular_momenta].map(|of| largest(of));
        for k in 0..self.owned {
            for (own, other, scale) in [
                (positions[k], &mut m.positions[k], scales[0]),
                (velocities[k], &mut m.velocities[k], scales[1]),
                (momenta[k], &mut m.angular_momenta[k], scales[2]),
            ] {
                for c in 0..3 {
                    near(own[c], other[c], scale, 1e-15, "motion", k);
                }
                *other = own;
            }
            if self.of_step {
                for (own, other) in changes[k].iter().zip(m.changes[k]) {
                    near(*own, other, scales[1], 1e-15, "change", k);
                }
                m.changes[k] = changes[k];
            }
            for (own, other) in quaternions[k].iter().zip(m.quaternions[k]) {
                near(*own, other, 1.0, 1e-15, "quaternion", k);
            }
            m.quaternions[k] = quaternions[k];
        }
    }

    /// Loads and histories against those of the lists: how many pairs touch. The scene goes on with the loads of the device.
    fn compare(
        &self,
        scene: &mut Scene,
        lists: &Lists,
        layout: &HistoryLayout,
        histories: &EllgranGpuHistories,
        tolerance: f64,
    ) -> usize {
        let largest = |of: &[[f64; 3]]| of.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let force = largest(&scene.forces);
        // Torques are no smaller than what rounding of a force makes of them, in units of length of about 1.
        let torque = largest(&scene.torques).max(force);
        for (k, load) in self.loads().iter().enumerate().take(self.owned) {
            for c in 0..3 {
                near(load[c], scene.forces[k][c], force, tolerance, "force", k);
                let t = scene.torques[k][c];
                near(load[3 + c], t, torque, tolerance, "torque", k);
                scene.forces[k][c] = load[c];
                scene.torques[k][c] = load[3 + c];
            }
        }
        assert_eq!(histories.count, self.neighbours.len());
        assert_eq!(histories.length, layout.length);
        let e = &self.engine;
        let states: Vec<u32> = e.read_at(histories.touching.addr() as u64, histories.count);
        let values: Vec<f64> = e.read_at(
            histories.histories.addr() as u64,
            histories.count * layout.length,
        );
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
        for row in 0..self.owned {
            let i = self.order[row];
            for at in self.starts[row] as usize..self.starts[row + 1] as usize {
                let j = self.order[self.neighbours[at] as usize];
                // A pair of two owned grains is in the row of the one with the lower identifier.
                if i > j && (self.neighbours[at] as usize) < self.owned {
                    assert_eq!(states[at], 0, "{i} {j}");
                    continue;
                }
                let half = place(lists, i.min(j), i.max(j)).unwrap();
                assert_eq!(states[at] as i32, lists.touching[half], "{i} {j}");
                if states[at] == 0 {
                    continue;
                }
                touching += 1;
                let own = &values[at * layout.length..(at + 1) * layout.length];
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
        touching
    }
}

/// Where a pair is in the lists of the host.
fn place(lists: &Lists, low: usize, high: usize) -> Option<usize> {
    (lists.starts[low]..lists.starts[low + 1]).find(|&k| lists.neighbours[k] == high as i32)
}

/// New lists of the host, with what the old ones remember.
fn carried(scene: &Scene, laws: &Laws, old: &Lists) -> Lists {
    let mut new = scene.lists(laws);
    let length = new.length;
    for low in 0..scene.count() {
        for at in new.starts[low]..new.starts[low + 1] {
            let Some(was) = place(old, low, new.neighbours[at] as usize) else {
                continue;
            };
            new.touching[at] = old.touching[was];
            let from = was * length..(was + 1) * length;
            new.histories[at * length..(at + 1) * length].copy_from_slice(&old.histories[from]);
        }
    }
    new
}

fn step_of(time_step: f64) -> EllgranStep {
    EllgranStep {
        advance_history: 1,
        time_step,
        ..new()
    }
}

fn gpu_scene(words: &str, shapes: i32) -> (*mut EllgranGpu, *mut EllgranGpuScene) {
    let gpu = support::open();
    let mut made = core::ptr::null_mut();
    let laws = support::laws(words);
    unsafe {
        succeed(ellgran_gpu_scene_new(gpu, laws, shapes, &mut made));
        ellgran::c_api::law::ellgran_laws_free(laws);
    }
    (gpu, made)
}

/// What is remembered of pairs, on the host.
unsafe fn remembered(made: *const EllgranGpuScene, device: &OnDevice) -> (Vec<u32>, Vec<f64>) {
    let mut held = new::<EllgranGpuHistories>();
    let (mut touching, mut histories);
    unsafe {
        succeed(ellgran_gpu_histories(made, -1, &mut held));
        touching = vec![7; held.count];
        histories = vec![7.0; held.count * held.length];
        let (to, values) = (touching.as_mut_ptr(), histories.as_mut_ptr());
        let stream = device.engine.stream;
        succeed(ellgran_gpu_read_histories(made, -1, to, values, stream));
    }
    (touching, histories)
}

/// Through the host and back, as with a restart; with the claim that all pairs touch, of which those that cannot are forgotten.
unsafe fn through_the_host(made: *mut EllgranGpuScene, device: &OnDevice) {
    let grains = device.grains();
    let written = |touching: &[u32], histories: &[f64]| {
        let (to, values) = (touching.as_ptr(), histories.as_ptr());
        let stream = device.engine.stream;
        unsafe { ellgran_gpu_write_histories(made, &grains, -1, to, values, stream) }
    };
    unsafe {
        let (touching, histories) = remembered(made, device);
        assert!(touching.contains(&1) && !touching.iter().any(|&t| t > 1));
        let all = touching.len();
        let ones: Vec<u32> = (0..all).map(|k| u32::from(kept(device, k))).collect();
        succeed(written(&ones, &vec![1.0; histories.len()]));
        let (claimed, values) = remembered(made, device);
        let length = histories.len() / all;
        let left = claimed.iter().filter(|&&t| t == 1).count();
        let touch = touching.iter().filter(|&&t| t == 1).count();
        let claims = ones.iter().filter(|&&t| t == 1).count();
        assert!(left >= touch && left < claims, "{touch} {left} {claims}");
        for (k, &state) in claimed.iter().enumerate() {
            assert!(state == 1 || touching[k] == 0);
            // A normal is the start of the next search.
            let tail = &values[k * length + length.min(3)..(k + 1) * length];
            let is = |x: f64| tail.iter().all(|&v| v == x);
            assert!(is(if state == 1 { 1.0 } else { 0.0 }) || ones[k] == 0);
        }
        let mut wrong = touching.clone();
        wrong[all - 1] = 2;
        assert_eq!(
            written(&wrong, &histories),
            ellgran::c_api::status::ELLGRAN_ERROR_ARGUMENT
        );
        succeed(written(&touching, &histories));
        let (again, values) = remembered(made, device);
        assert_eq!(again, touching);
        for (k, _) in touching.iter().enumerate().filter(|(_, &t)| t == 1) {
            let of = k * length..(k + 1) * length;
            assert_eq!(values[of.clone()], histories[of]);
        }
    }
}

/// Whether an entry of the list is in the row that keeps its pair.
fn kept(device: &OnDevice, entry: usize) -> bool {
    let row = device
        .starts
        .iter()
        .filter(|&&s| s as usize <= entry)
        .count()
        - 1;
    let other = device.neighbours[entry] as usize;
    other >= device.owned || device.order[row] < device.order[other]
}

fn compare_tallies(
    found: &EllgranGpuTallies,
    energies: &[f64],
    virials: &[[f64; 6]],
    tolerance: f64,
) {
    let energy = found.normal_elastic_energy + found.tangential_elastic_energy;
    let expected: f64 = energies.iter().sum();
    assert!(expected > 0.0);
    near(energy, expected, expected, tolerance, "energy", 0);
    let expected = virials.iter().fold([0.0; 6], |mut sum: [f64; 6], own| {
        sum.iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
        sum
    });
    let largest = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    for (k, (found, expected)) in found.virial.iter().zip(expected).enumerate() {
        near(*found, expected, largest, tolerance, "virial", k);
    }
}

fn compare(words: &str, stated: i32, shapes: i32, scene: Scene) -> EllgranGpuCounts {
    compare_with(Layout::Rows, words, stated, shapes, scene)
}

fn compare_with(
    arrays: Layout,
    words: &str,
    stated: i32,
    shapes: i32,
    scene: Scene,
) -> EllgranGpuCounts {
    compare_in(&[ELLGRAN_GPU_DOUBLE], arrays, words, stated, shapes, scene)
}

/// In these precisions in turns.
fn compare_in(
    precisions: &[i32],
    arrays: Layout,
    words: &str,
    stated: i32,
    shapes: i32,
    mut scene: Scene,
) -> EllgranGpuCounts {
    let tolerance = if precisions.contains(&ELLGRAN_GPU_MIXED) {
        MIXED_TOLERANCE
    } else {
        TOLERANCE
    };
    let laws = laws_on_host(words);
    let layout = laws.layout();
    let owned = scene.count() - GHOSTS;
    let (gpu, made) = gpu_scene(words, stated);
    let mut device = OnDevice::new(Engine::new(), &scene, owned, true, arrays);
    let stream = device.engine.stream;
    let mut lists = scene.lists(&laws);
    let mut unchanged = false;
    let step = step_of(TIME_STEP);
    let mut touching = 0;
    unsafe {
        let (grains, list) = (device.grains(), device.neighbour_list());
        succeed(ellgran_gpu_new_list(made, &grains, &list, stream));
        // A scene keeps its GPU open.
        ellgran_gpu_free(gpu);
        for now in 0..STEPS {
            let precision = precisions[now % precisions.len()];
            succeed(ellgran_gpu_scene_set_precision(made, precision));
            let motion = device.motion();
            device.engine.in_a_step(|| {
                succeed(ellgran_gpu_start_step(made, &motion, TIME_STEP, stream));
            });
            scene.start_step();
            device.compare_motion(&mut scene);
            if now % BETWEEN_LISTS == BETWEEN_LISTS - 1 {
                device.begin_anew(&scene, now / BETWEEN_LISTS + 1, true);
                let (grains, list) = (device.grains(), device.neighbour_list());
                succeed(ellgran_gpu_new_list(made, &grains, &list, stream));
                if now == STEPS - 1 && layout.length > 0 {
                    through_the_host(made, &device);
                }
                lists = carried(&scene, &laws, &lists);
                unchanged = false;
            } else {
                // As ranks tell each other.
                device.write_from(&scene, owned);
                let grains = device.grains();
                device.engine.in_a_step(|| {
                    succeed(ellgran_gpu_prepare(made, &grains, stream));
                });
            }
            let grains = device.grains();
            let mut tallied = new::<EllgranGpuTallies>();
            let status = ellgran_gpu_tally_pairs(made, &grains, &step, &mut tallied, stream);
            succeed(status);
            device.engine.in_a_step(|| {
                let loads = device.to_load();
                succeed(ellgran_gpu_compute_pairs(
                    made, &grains, &step, &loads, stream,
                ));
            });
            let (mut energies, mut virials) =
                (vec![0.0; scene.count()], vec![[0.0; 6]; scene.count()]);
            let mut on_host = Tallies {
                particle_energies: Some(&mut energies),
                particle_virials: Some(&mut virials),
                ..Tallies::default()
            };
            scene.forces_and_tallies(&laws, &mut lists, unchanged, Some(&mut on_host));
            unchanged = true;
            // What owned grains have of it: half of a pair with a ghost.
            compare_tallies(&tallied, &energies[..owned], &virials[..owned], tolerance);
            let mut histories = new::<EllgranGpuHistories>();
            succeed(ellgran_gpu_histories(made, -1, &mut histories));
            touching += device.compare(&mut scene, &lists, &layout, &histories, tolerance);
            let motion = device.motion();
            device.engine.in_a_step(|| {
                succeed(ellgran_gpu_finish_step(made, &motion, TIME_STEP, stream));
            });
            scene.finish_step();
            device.compare_motion(&mut scene);
            succeed(ellgran_gpu_check(made, &grains, stream));
        }
        let mut counts = new::<EllgranGpuCounts>();
        succeed(ellgran_gpu_counts(made, stream, &mut counts));
        ellgran_gpu_scene_free(made);
        assert_eq!(counts.shapes, i64::from(shapes));
        assert!(touching > 50 * STEPS, "{touching}");
        // Most steps are on candidates of an earlier one; each list has some of its own.
        let lists = 1 + (STEPS / BETWEEN_LISTS) as u64;
        assert!(
            counts.selections >= lists && counts.selections < STEPS as u64 / 2,
            "{counts:?}"
        );
        counts
    }
}

const ANY: i32 = ELLGRAN_GPU_ANY_SHAPES;

#[test]
fn spheres() {
    with_driver("spheres", &[], || {
        for words in [ELASTIC, MINDLIN, VISCOELASTIC, LINEAR] {
            compare(words, ANY, ELLGRAN_GPU_SPHERES, Scene::spheres());
        }
    });
}

#[test]
fn spheroids() {
    with_driver("spheroids", &[], || {
        for words in [ELASTIC, ELASTIC_PLAIN, MINDLIN, VISCOELASTIC, WHOLE, TOTAL] {
            let counts = compare(words, ANY, ELLGRAN_GPU_SPHEROIDS, Scene::spheroids());
            // Grains move, and the device finds it.
            assert!(counts.selections > 10, "{counts:?}");
        }
    });
}

#[test]
fn spheres_among_spheroids() {
    with_driver("spheres_among_spheroids", &[], || {
        let scene = Scene::spheres_and_spheroids();
        compare(WHOLE, ANY, ELLGRAN_GPU_SPHEROIDS, scene);
    });
}

#[test]
fn three_semi_axes() {
    with_driver("three_semi_axes", &[], || {
        for words in [ELASTIC, MINDLIN, VISCOELASTIC, WHOLE, LINEAR] {
            compare(words, ANY, ELLGRAN_GPU_ELLIPSOIDS, Scene::ellipsoids());
        }
    });
}

/// Hard grains among soft ones, with another friction; each order of the two in a pair.
#[test]
fn two_types() {
    with_driver("two_types", &[], || {
        for words in [
            "nfd 1e7 0.3 300 200 tangential tfd 0.5 | nfd 4e7 0.2 100 900 tangential tfd 0.9",
            "hertz 1e7 0.3 damping restitution 0.7 tangential mindlin 0.5 | hertz 3e7 0.2 damping restitution 0.4 tangential mindlin 0.1",
        ] {
            let mut scene = Scene::ellipsoids();
            for (k, particle_type) in scene.types.iter_mut().enumerate() {
                *particle_type = 1 + (k % 3 == 0) as i32;
            }
            for (k, mass) in scene.masses.iter_mut().enumerate() {
                *mass = 3.0 + (k % 4) as f64;
            }
            compare(words, ANY, ELLGRAN_GPU_ELLIPSOIDS, scene);
        }
    });
}

/// General kernels serve simpler shapes.
#[test]
fn stated_shapes() {
    with_driver("stated_shapes", &[], || {
        for stated in [ELLGRAN_GPU_SPHEROIDS, ELLGRAN_GPU_ELLIPSOIDS] {
            compare(WHOLE, stated, stated, Scene::spheroids());
        }
    });
}

#[test]
fn velocities_of_the_step() {
    with_driver("velocities_of_the_step", &[], || {
        let of_step = |scene: Scene| Scene {
            of_step: true,
            ..scene
        };
        let scene = of_step(Scene::spheroids());
        compare(MINDLIN, ANY, ELLGRAN_GPU_SPHEROIDS, scene);
        let scene = of_step(Scene::ellipsoids());
        compare(WHOLE, ANY, ELLGRAN_GPU_ELLIPSOIDS, scene);
    });
}

/// Columns, and shapes and attitudes beside them in an order of their own.
#[test]
fn columns() {
    with_driver("columns", &[], || {
        let columns = Layout::Columns;
        let spheres = ELLGRAN_GPU_SPHERES;
        compare_with(columns, MINDLIN, ANY, spheres, Scene::spheres());
        let ellipsoids = Scene {
            of_step: true,
            ..Scene::ellipsoids()
        };
        compare_with(columns, WHOLE, ANY, ELLGRAN_GPU_ELLIPSOIDS, ellipsoids);
    });
}

/// An engine that has images across a boundary says whose they are, and has nothing but their centres: the same bits as with copies of
/// all. And loads are added to what is there.
#[test]
fn images_of_owned_grains() {
    with_driver("images_of_owned_grains", &[], || {
        let mut scene = Scene {
            of_step: true,
            ..Scene::ellipsoids()
        };
        let count = scene.count();
        let owned = count - GHOSTS;
        let owner_of = |grain: usize| {
            if grain < owned {
                grain
            } else {
                (7 * grain) % owned
            }
        };
        for k in owned..count {
            let of = owner_of(k);
            let m = &mut scene.motion;
            m.changes[of] = std::array::from_fn(|c| 1e-3 * (k + c) as f64);
            m.changes[k] = m.changes[of];
            m.velocities[k] = m.velocities[of];
            m.angular_momenta[k] = m.angular_momenta[of];
            m.quaternions[k] = m.quaternions[of];
            scene.semi_axes[k] = scene.semi_axes[of];
            scene.masses[k] = scene.masses[of];
        }
        let step = EllgranStep {
            advance_history: 0,
            ..step_of(TIME_STEP)
        };
        // What there is of images where their owners are told.
        let mut nothing = scene.motion.clone();
        for k in owned..count {
            nothing.velocities[k] = [f64::NAN; 3];
            nothing.angular_momenta[k] = [f64::NAN; 3];
            nothing.quaternions[k] = [f64::NAN; 4];
            nothing.changes[k] = [f64::NAN; 6];
        }
        let nothing = Scene {
            motion: nothing,
            ..Scene::ellipsoids()
        };
        let loads_of = |with_owners: bool, arrays: Layout| {
            let (gpu, made) = gpu_scene(WHOLE, ANY);
            let device = OnDevice::new(Engine::new(), &scene, owned, true, arrays);
            let stream = device.engine.stream;
            let index = |grain| device.order.iter().position(|&k| k == grain).unwrap() as i32;
            let owners: Vec<i32> = device.order.iter().map(|&k| index(owner_of(k))).collect();
            let owners = device.engine.put(&owners);
            let mut grains = device.grains();
            if with_owners {
                grains.owners = owners.pointer();
                device.write_from(&nothing, owned);
                let mut axes = sorted(&device.order, &scene.semi_axes);
                axes[owned..].fill([f64::NAN; 3]);
                device.bodies.write_semi_axes(&device.engine, &axes);
                let none = vec![f64::NAN; GHOSTS];
                device.engine.write(&device.masses, owned, &none);
            }
            let mut loads = device.to_load();
            let compute = |loads: &EllgranGpuLoads| unsafe {
                succeed(ellgran_gpu_compute_pairs(
                    made, &grains, &step, loads, stream,
                ));
                device.loads()
            };
            unsafe {
                let list = device.neighbour_list();
                succeed(ellgran_gpu_new_list(made, &grains, &list, stream));
            }
            let of_list = compute(&loads);
            succeed(unsafe { ellgran_gpu_prepare(made, &grains, stream) });
            let of_step = compute(&loads);
            loads.add = 1;
            // The search goes on from the normal of the last call: another rounding.
            let largest = of_step.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
            for (k, both) in compute(&loads).iter().enumerate() {
                for c in 0..6 {
                    near(both[c], 2.0 * of_step[k][c], largest, TOLERANCE, "sum", k);
                }
            }
            succeed(unsafe { ellgran_gpu_check(made, &grains, stream) });
            unsafe {
                ellgran_gpu_scene_free(made);
                ellgran_gpu_free(gpu);
            }
            [of_list, of_step]
        };
        let expected = loads_of(false, Layout::Rows);
        let numbers = expected[0].iter().flatten();
        assert!(numbers.filter(|x| x.abs() > 0.0).count() > 6 * owned / 2);
        for arrays in [Layout::Rows, Layout::Columns] {
            assert!(loads_of(true, arrays) == expected);
        }
    });
}

#[test]
fn deep_contacts() {
    with_driver("deep_contacts", &[], || {
        let discs = Scene::flat_discs();
        compare(WHOLE, ANY, ELLGRAN_GPU_SPHEROIDS, discs);
        let blocks = Scene::flat_blocks();
        compare(WHOLE, ANY, ELLGRAN_GPU_ELLIPSOIDS, blocks);
    });
}

/// Contacts with their search in single precision, and in turns with it: histories are the same to the tolerance, and the same pairs touch.
#[test]
fn mixed_precision() {
    with_driver("mixed_precision", &[], || {
        let [double, mixed] = [ELLGRAN_GPU_DOUBLE, ELLGRAN_GPU_MIXED];
        let rows = Layout::Rows;
        let spheroids = ELLGRAN_GPU_SPHEROIDS;
        let ellipsoids = ELLGRAN_GPU_ELLIPSOIDS;
        for words in [ELASTIC, MINDLIN, VISCOELASTIC, WHOLE] {
            let scene = Scene::spheroids();
            compare_in(&[mixed], rows, words, ANY, spheroids, scene);
            let scene = Scene {
                of_step: true,
                ..Scene::ellipsoids()
            };
            compare_in(&[mixed], rows, words, ANY, ellipsoids, scene);
        }
        let scene = Scene::ellipsoids();
        compare_in(&[mixed, double], rows, TOTAL, ANY, ellipsoids, scene);
        let discs = Scene::flat_discs();
        compare_in(&[mixed], rows, WHOLE, ANY, spheroids, discs);
        // Two spheres have no search: the kernels are those of double precision.
        let scene = Scene::spheres();
        compare_in(&[mixed], rows, WHOLE, ANY, ELLGRAN_GPU_SPHERES, scene);
    });
}
