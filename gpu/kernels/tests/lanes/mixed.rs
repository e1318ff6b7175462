// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts with their search in single precision, against the same in double precision: scenes, and a sweep over shapes and overlaps.

use crate::scene::{Scene, STEP};
use crate::{compare, compare_to, Counts, ELASTIC, MINDLIN, TOTAL, VISCOELASTIC, WHOLE};
use ellgran::contact::Laws;
use ellgran::geometry::Ellipsoid;
use ellgran::vector::Vector3;
use ellgran_kernels::candidates::Candidate;
use ellgran_kernels::contacts::{self, contact_of_pair, marked_contact_of_pair, TOUCHES};
use ellgran_kernels::mixed::mixed_contact_of_pair;
use ellgran_kernels::preparation::{prepare_grain, EngineGrain};
use ellgran_kernels::shapes::{Ellipsoids, Grain, Kind, Spheroids};
use ellgran_kernels::terms::{component_of_load, ContactLoad};

/// Of force, torque and history of a scene, relative to the largest of it.
const TOLERANCE: f64 = 1e-5;

fn mixed<K: Kind, const FRICTION: bool, const CONSERVATIVE: bool>(
    words: &str,
    scene: fn() -> Scene,
) {
    let double = compare::<K, FRICTION, CONSERVATIVE>(words, scene());
    let mixed = compare_to::<K, FRICTION, CONSERVATIVE>(TOLERANCE, words, scene());
    println!("{words}: {double:?} {mixed:?}");
    let Counts {
        touching, marked, ..
    } = double;
    assert_eq!(mixed.touching, touching);
    // Few more are left to the kernel with all safeguards.
    assert!(mixed.marked <= marked + touching / 100, "{mixed:?}");
}

#[test]
fn scenes() {
    mixed::<Spheroids, false, true>(ELASTIC, Scene::spheroids);
    mixed::<Spheroids, true, true>(MINDLIN, Scene::spheroids);
    mixed::<Spheroids, true, false>(VISCOELASTIC, Scene::spheroids);
    mixed::<Spheroids, true, true>(WHOLE, Scene::spheroids);
    mixed::<Spheroids, true, true>(TOTAL, Scene::spheroids);
    mixed::<Spheroids, true, true>(WHOLE, Scene::spheres_and_spheroids);
    mixed::<Ellipsoids, false, true>(ELASTIC, Scene::ellipsoids);
    mixed::<Ellipsoids, true, true>(MINDLIN, Scene::ellipsoids);
    mixed::<Ellipsoids, true, false>(VISCOELASTIC, Scene::ellipsoids);
    mixed::<Ellipsoids, true, true>(WHOLE, Scene::ellipsoids);
    mixed::<Spheroids, true, true>(WHOLE, Scene::flat_discs);
    mixed::<Ellipsoids, true, true>(WHOLE, Scene::flat_blocks);
}

/// Van der Corput's sequence: evenly spread, the same in every run.
fn spread(mut k: u32, base: u32) -> f64 {
    let (mut share, mut sum) = (1.0, 0.0);
    while k > 0 {
        share /= f64::from(base);
        sum += share * f64::from(k % base);
        k /= base;
    }
    sum
}

fn direction(a: f64, b: f64) -> Vector3 {
    let (z, turn) = (2.0 * a - 1.0, std::f64::consts::TAU * b);
    let r = (1.0 - z * z).sqrt();
    Vector3::new(r * turn.cos(), r * turn.sin(), z)
}

/// A pair whose surfaces overlap by `overlap` times the smallest semi-axis along the normal at two of their points; less than none: a gap.
struct Two {
    grains: [Grain; 2],
}

impl Two {
    fn of<K: Kind>(k: u32, unit: f64, semi_axes: [[f64; 3]; 2], overlap: f64) -> Two {
        let r = |base| spread(k + 1, base);
        let quaternion = |c: f64, a: f64, b: f64| {
            let axis = direction(a, b);
            let half = std::f64::consts::PI * c;
            let (sin, cos) = half.sin_cos();
            [cos, sin * axis.x, sin * axis.y, sin * axis.z]
        };
        let q = [quaternion(r(2), r(3), r(5)), quaternion(r(7), r(11), r(13))];
        let n = direction(r(17), r(19));
        let axes = semi_axes.map(|axes| axes.map(|a| unit * a));
        let bodies = [0, 1].map(|k| Ellipsoid::new(axes[k], q[k]).unwrap());
        let points = [bodies[0].support(n).point, bodies[1].support(n).point];
        let smallest = bodies[0]
            .smallest_semi_axis()
            .min(bodies[1].smallest_semi_axis());
        let d = points[0] + points[1] + n * (-overlap * smallest);
        // Somewhere in a box of a hundred grains.
        let centre = [100.0, -70.0, 40.0].map(|x| unit * x);
        let place = |at: Vector3, k: usize| {
            let given = EngineGrain {
                position: std::array::from_fn(|c| centre[c] + at.to_array()[c]),
                velocity: [0.0; 3],
                angular_momentum: [0.0; 3],
                change: [0.0; 6],
                mass: 1e-5,
                semi_axes: axes[k],
                quaternion: q[k],
                particle_type: 1,
                type_count: 1,
            };
            prepare_grain::<K>(&given).unwrap().0
        };
        Two {
            grains: [place(Vector3::ZERO, 0), place(d, 1)],
        }
    }
}

/// The load in one precision; `None` where the pair does not touch. And whether it was marked.
fn load<K: Kind>(two: &Two, laws: &Laws, in_single: bool) -> (Option<ContactLoad>, bool) {
    let scene = contacts::Scene {
        grains: &two.grains,
        changes: &[],
        types: &[1, 1],
        inverse_masses: &[1e5, 1e5],
        identifiers: &[1, 2],
        laws: &[*laws.get(1, 1)],
        type_count: 1,
        layout: laws.layout(),
        step: STEP,
    };
    let candidate = Candidate {
        grains: [0, 1],
        ..Candidate::default()
    };
    let (mut state, mut history) = (0, vec![0.0; laws.layout().length]);
    let of_pair = if in_single {
        mixed_contact_of_pair::<K, false, true, true>
    } else {
        contact_of_pair::<K, false, true, true>
    };
    // The second time from the normal of the first, as in a running scene.
    let mut last = (None, false);
    for _ in 0..2 {
        let found = of_pair(&scene, &candidate, &mut state, &mut history);
        let marked = found.is_none();
        let load = found.unwrap_or_else(|| {
            marked_contact_of_pair::<K>(&scene, &candidate, &mut state, &mut history)
        });
        last = ((state & TOUCHES != 0).then_some(load), marked);
    }
    last
}

/// Of a force, or of a torque over a length, as a share of the force.
fn difference(single: &ContactLoad, double: &ContactLoad, length: f64) -> f64 {
    // Of the first grain, and of the second.
    let vector = |load: &ContactLoad, term: u32, from: usize| {
        let component = |c| component_of_load(&[term], |_, n| load.values()[n], from + c);
        Vector3::new(component(0), component(1), component(2))
    };
    let apart = |term, from| (vector(single, term, from) - vector(double, term, from)).norm();
    let torques = apart(0, 3).max(apart(1, 3)) / length;
    apart(0, 0).max(torques) / vector(double, 0, 0).norm()
}

/// What a sweep found.
#[derive(Debug, Default)]
struct Swept {
    touching: usize,
    /// Pairs that touch in one precision alone.
    decided_otherwise: usize,
    /// Marked in single precision, and in double.
    marked: [usize; 2],
    /// The largest difference of a force, and of a torque over the largest semi-axis, as a share of the force.
    largest: f64,
    /// That of nine in ten.
    most: f64,
}

const PAIRS: u32 = 2000;

fn sweep<K: Kind>(unit: f64, semi_axes: [[f64; 3]; 2], overlap: f64) -> Swept {
    let laws = crate::laws(ELASTIC);
    let mut swept = Swept::default();
    let mut differences = Vec::new();
    let length = unit * semi_axes.as_flattened().iter().copied().fold(0.0, f64::max);
    for k in 0..PAIRS {
        let two = Two::of::<K>(k, unit, semi_axes, overlap);
        let (single, double) = (load::<K>(&two, &laws, true), load::<K>(&two, &laws, false));
        swept.marked[0] += usize::from(single.1);
        swept.marked[1] += usize::from(double.1);
        match (single.0, double.0) {
            (None, None) => {}
            (Some(single), Some(double)) => {
                swept.touching += 1;
                differences.push(difference(&single, &double, length));
            }
            _ => swept.decided_otherwise += 1,
        }
    }
    differences.sort_by(f64::total_cmp);
    if let Some(last) = differences.last() {
        swept.largest = *last;
        swept.most = differences[differences.len() * 9 / 10];
    }
    swept
}

/// Needles, discs and blades of an aspect ratio.
fn shapes(ratio: f64, unit: f64, overlap: f64) -> [(&'static str, Swept); 3] {
    let root = ratio.sqrt();
    [
        (
            "needles",
            sweep::<Spheroids>(unit, [[ratio, 1.0, 1.0]; 2], overlap),
        ),
        (
            "discs",
            sweep::<Spheroids>(unit, [[ratio, ratio, 1.0]; 2], overlap),
        ),
        (
            "blades",
            sweep::<Ellipsoids>(unit, [[ratio, root, 1.0]; 2], overlap),
        ),
    ]
}

/// Of the smallest semi-axis.
const OVERLAPS: [f64; 6] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1];

/// The numbers of docs/gpu.md. `cargo test -p ellgran-kernels shapes_and_overlaps -- --nocapture` prints all.
#[test]
fn shapes_and_overlaps() {
    for (ratio, largest, more) in [
        (1.2, 1e-6, 0),
        (2.0, 1e-6, 0),
        (5.0, 1e-6, 0),
        (10.0, 5e-6, 0),
        (30.0, 5e-5, PAIRS as usize / 20),
    ] {
        for overlap in OVERLAPS {
            for (name, swept) in shapes(ratio, 1e-3, overlap) {
                println!("{name} {ratio} {overlap:e} {swept:?}");
                assert_eq!(swept.decided_otherwise, 0, "{name} {ratio} {overlap:e}");
                assert!(swept.touching > PAIRS as usize / 2, "{swept:?}");
                assert!(
                    swept.largest < largest,
                    "{name} {ratio} {overlap:e} {swept:?}"
                );
                assert!(swept.marked[0] <= swept.marked[1] + more, "{swept:?}");
            }
        }
    }
}

/// Bodies that only just touch, and that only just do not, are found to do so.
#[test]
fn touches_and_gaps() {
    for ratio in [1.2, 3.0, 30.0, 300.0, 1000.0] {
        for overlap in [1e-9, -1e-9, 1e-7, -1e-7, -1e-5] {
            for (name, swept) in shapes(ratio, 1e-3, overlap) {
                println!("{name} {ratio} {overlap:e} {swept:?}");
                assert_eq!(swept.decided_otherwise, 0, "{name} {ratio} {overlap:e}");
                assert_eq!(
                    swept.touching > 0,
                    overlap > 0.0,
                    "{name} {ratio} {overlap:e}"
                );
            }
        }
    }
}

/// Powers of lengths that single precision does not have, and sizes that differ by much.
#[test]
fn units_and_sizes() {
    for unit in [1e-17, 1e-6, 1e6, 1e17] {
        for (name, swept) in shapes(5.0, unit, 1e-4) {
            println!("{name} {unit:e} {swept:?}");
            assert_eq!(swept.decided_otherwise, 0, "{name} {unit:e}");
            assert!(swept.largest < 1e-6, "{name} {unit:e} {swept:?}");
        }
    }
    for (size, largest) in [(10.0, 5e-6), (1e3, 1e-3), (1e6, 1e-3)] {
        let axes = [[2.0, 1.0, 1.0], [2.0 * size, size, size]];
        let swept = sweep::<Spheroids>(1e-3, axes, 1e-3);
        println!("{size:e} {swept:?}");
        assert_eq!(swept.decided_otherwise, 0, "{size:e}");
        assert!(swept.largest < largest, "{size:e} {swept:?}");
    }
}
