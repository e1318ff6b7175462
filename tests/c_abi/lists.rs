// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's arrays as engines lay them out: strides, indices, bits in neighbour entries, added forces.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::law::*;
use ellgran::c_api::neighbour_list::*;
use ellgran::c_api::particles::*;
use ellgran::c_api::status::ELLGRAN_ERROR_ARGUMENT;

use crate::formulas::{angular_momentum, normalise};
use crate::scene::*;

const DECKS: [&str; 2] = [
    "nfd 1e4 0.3 40 60 tangential tfd 0.4",
    "nfd 3e4 0.2 90 30 tangential tfd 0.2",
];
const OWNED: usize = 44;

type Vectors = Vec<[f64; 3]>;

/// Forces and torques of a step with the arrays as `change` leaves them.
fn forces(
    arrays: &mut Arrays,
    list: &mut List,
    newton: bool,
    change: impl Fn(&mut EllgranParticles, &mut EllgranNeighbourList),
) -> (Vectors, Vectors) {
    let laws = Laws::new(&DECKS);
    let workspace = WorkspaceHandle::new();
    arrays.forces.fill([0.0; 3]);
    arrays.torques.fill([0.0; 3]);
    let (mut particles, mut view) = (arrays.particles(), list.view(newton));
    change(&mut particles, &mut view);
    ok(laws.pairs(&workspace, &particles, &view, &STEP, null_mut()));
    (arrays.forces.clone(), arrays.torques.clone())
}

fn scene() -> (Arrays, List) {
    let bodies = random_bodies(3);
    let length = Laws::new(&DECKS).length();
    (
        Arrays::new(&bodies, OWNED),
        List::near(&bodies, OWNED, length),
    )
}

/// An entry of an engine's array of shapes: ours among other things.
#[repr(C)]
struct Shape {
    semi_axes: [f64; 3],
    quaternion: [f64; 4],
    moments: [f64; 3],
    owner: i32,
}

#[test]
fn shapes_in_an_array_of_structures() {
    let (mut arrays, mut list) = scene();
    let expected = forces(&mut arrays, &mut list, true, |_, _| ());
    assert!(expected.0.iter().filter(|f| **f != [0.0; 3]).count() > 40);
    // In another order than the particles.
    let count = arrays.positions.len();
    let place = |k: usize| (k * 27 + 5) % count;
    let mut shapes: Vec<Shape> = (0..count)
        .map(|_| Shape {
            semi_axes: [f64::NAN; 3],
            quaternion: [f64::NAN; 4],
            moments: [f64::NAN; 3],
            owner: 0,
        })
        .collect();
    let mut indices = vec![0; count];
    for k in 0..count {
        let shape = &mut shapes[place(k)];
        assert!(shape.owner == 0, "a place for each");
        shape.semi_axes = arrays.semi_axes[k];
        shape.quaternion = arrays.quaternions[k];
        shape.owner = k as i32 + 1;
        indices[k] = place(k) as i32;
    }
    let (mut again, mut fresh) = scene();
    let found = forces(&mut again, &mut fresh, true, |p, _| {
        p.shape_indices = indices.as_ptr();
        // From the whole array: a pointer to one field may not leave it.
        let field = |offset: usize| shapes.as_ptr().wrapping_byte_add(offset).cast();
        p.semi_axes = field(std::mem::offset_of!(Shape, semi_axes));
        p.semi_axes_stride = size_of::<Shape>();
        p.quaternions = field(std::mem::offset_of!(Shape, quaternion));
        p.quaternions_stride = size_of::<Shape>();
    });
    assert_eq!(found, expected);
    assert_eq!(fresh.history, list.history);
    assert!(shapes.iter().all(|s| s.moments[0].is_nan()));
}

#[test]
fn angular_momenta_in_place_of_velocities() {
    let (mut arrays, mut list) = scene();
    arrays.masses[20] = 3.0;
    let expected = forces(&mut arrays, &mut list, true, |_, _| ());
    let momenta: Vectors = (0..arrays.positions.len())
        .map(|k| {
            let (a, q) = (arrays.semi_axes[k], arrays.quaternions[k]);
            angular_momentum(
                arrays.masses[k],
                a,
                normalise(q),
                arrays.angular_velocities[k],
            )
        })
        .collect();
    let (_, mut fresh) = scene();
    let found = forces(&mut arrays, &mut fresh, true, |p, _| {
        p.angular_velocities = null();
        p.angular_momenta = momenta.as_ptr().cast();
    });
    let largest = expected
        .0
        .iter()
        .chain(&expected.1)
        .flatten()
        .fold(0.0f64, |m, x| m.max(x.abs()));
    let apart = (found.0.iter().chain(&found.1).flatten())
        .zip(expected.0.iter().chain(&expected.1).flatten())
        .fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(
        apart > 0.0 && apart < 1e-12 * largest,
        "{apart} of {largest}"
    );
}

#[test]
fn excluded_pairs_are_left_out() {
    const SHIFT: i32 = 30;
    let (mut arrays, mut list) = scene();
    // Every third pair is of a kind with factor 0, the others of kinds with other factors.
    let kind = |i: usize, m: usize| [1, 0, 2][(i + m) % 3];
    for i in 0..list.rows.len() {
        for (m, entry) in list.rows[i].iter_mut().enumerate() {
            *entry |= kind(i, m) << SHIFT;
        }
    }
    let factors = [1.0, 0.0, 0.5, 0.0];
    let found = forces(&mut arrays, &mut list, true, |_, view| {
        view.index_mask = (1 << SHIFT) - 1;
        view.special_shift = SHIFT;
        view.special_factors = factors.as_ptr();
    });
    let mut excluded = 0;
    let (_, kept) = scene();
    let length = Laws::new(&DECKS).length();
    let rows = (0..kept.rows.len())
        .map(|i| {
            let keep = |(m, j): (usize, &i32)| (kind(i, m) != 1).then_some(*j);
            kept.rows[i].iter().enumerate().filter_map(keep).collect()
        })
        .collect();
    let mut kept = List::new(rows, length);
    let expected = forces(&mut arrays, &mut kept, true, |_, _| ());
    assert_eq!(found, expected);
    for i in 0..list.rows.len() {
        for m in 0..list.rows[i].len() {
            if kind(i, m) == 1 {
                excluded += 1;
                assert_eq!(list.touching[i][m], 0);
                assert!(list.history[i][m * length..(m + 1) * length]
                    .iter()
                    .all(|h| *h == 0.0));
            }
        }
    }
    assert!(excluded > 30, "{excluded}");
    // Without factors, no pair is left out whatever its bits.
    let (_, mut plain) = scene();
    let all = forces(&mut arrays, &mut plain, true, |_, _| ());
    list.touching.iter_mut().for_each(|t| t.fill(0));
    list.history.iter_mut().for_each(|h| h.fill(0.0));
    let found = forces(&mut arrays, &mut list, true, |_, view| {
        view.index_mask = (1 << SHIFT) - 1
    });
    assert_eq!(found, all);
    assert_ne!(found, expected);
}

#[test]
fn without_newton_ghosts_get_nothing() {
    let (mut arrays, mut list) = scene();
    let (on, _) = forces(&mut arrays, &mut list, true, |_, _| ());
    let (_, mut fresh) = scene();
    let (off, _) = forces(&mut arrays, &mut fresh, false, |_, _| ());
    assert_eq!(on[..OWNED], off[..OWNED]);
    assert!(on[OWNED..].iter().any(|f| *f != [0.0; 3]));
    assert!(off[OWNED..].iter().all(|f| *f == [0.0; 3]));
}

/// Its pairs would count whole, where each of two ranks counts a half.
#[test]
fn without_newton_the_rows_are_those_of_owned_particles() {
    let laws = Laws::new(&["hertz 1e4 0.3 tangential tfd 0.4"]);
    let bodies = [sphere_at(0.0), sphere_at(1.99)];
    let workspace = WorkspaceHandle::new();
    let mut arrays = Arrays::new(&bodies, 1);
    let mut list = List::new(vec![vec![], vec![0]], laws.length());
    let particles = arrays.particles();
    for (newton, refused) in [(true, false), (false, true)] {
        let mut view = list.view(newton);
        view.unchanged = 0;
        // SAFETY: the arrays are as long as the structs say.
        let status = unsafe {
            ellgran_compute_pairs(laws.0, workspace.0, &particles, &view, &STEP, null_mut())
        };
        if refused {
            fails(status, ELLGRAN_ERROR_ARGUMENT, &["particle 1", "ghost"]);
        } else {
            ok(status);
        }
    }
}

#[test]
fn forces_are_added_to_what_is_there() {
    let (mut arrays, mut list) = scene();
    let laws = Laws::new(&DECKS);
    let workspace = WorkspaceHandle::new();
    let step = EllgranStep {
        advance_history: 0,
        ..STEP
    };
    let (particles, view) = (arrays.particles(), list.view(true));
    let call = || {
        ok(laws.pairs(&workspace, &particles, &view, &step, null_mut()));
    };
    call();
    let once = (arrays.forces.clone(), arrays.torques.clone());
    arrays.forces.fill([1e3; 3]);
    arrays.torques.fill([-1e3; 3]);
    call();
    for (start, now, before) in [
        (1e3, &arrays.forces, &once.0),
        (-1e3, &arrays.torques, &once.1),
    ] {
        for (a, b) in now.iter().flatten().zip(before.iter().flatten()) {
            let rounding = 1e-13 * (f64::abs(start) + b.abs());
            assert!(
                (a - start - b).abs() < rounding,
                "{a} is not {start} and {b}"
            );
        }
    }
}

#[test]
fn an_empty_scene() {
    let laws = Laws::new(&DECKS);
    let workspace = WorkspaceHandle::new();
    let mut arrays = Arrays::new(&[], 0);
    let mut list = List::new(Vec::new(), laws.length());
    let mut tallies = no_tallies();
    tallies.pair_count = 5;
    let (particles, view) = (arrays.particles(), list.view(true));
    ok(laws.pairs(&workspace, &particles, &view, &STEP, &mut tallies));
    assert_eq!(tallies.pair_count, 0);
}

#[test]
fn a_swapped_history_is_that_of_the_other_order() {
    let bodies = random_bodies(3);
    for deck in [
        "nfd 1e4 0.3 40 60 tangential tfd 0.4",
        "hertz 1e4 0.3 tangential mindlin 0.4",
    ] {
        let laws = Laws::new(&[deck, deck]);
        let length = laws.length();
        let (mut seen, mut swapped) = (0, vec![0.0; length]);
        for (i, j) in [(0, 1), (5, 6), (21, 22), (1, 5), (10, 14), (9, 10)] {
            let run = |a: usize, b: usize| {
                let (mut touching, mut history) = (0, vec![0.0; length]);
                let mut moving = bodies.clone();
                for _ in 0..5 {
                    advance(&mut moving, STEP.time_step);
                    let pair = [&moving[a], &moving[b]];
                    laws.contact(pair, &STEP, &mut touching, &mut history);
                }
                (touching, history)
            };
            let ((touching, one), (_, other)) = (run(i, j), run(j, i));
            if touching == 0 {
                continue;
            }
            seen += 1;
            // SAFETY: both have the length of a history.
            ok(unsafe { ellgran_history_swap(laws.0, one.as_ptr(), swapped.as_mut_ptr()) });
            for (a, b) in swapped.iter().zip(&other) {
                assert!(
                    (a - b).abs() <= 1e-11 * (1.0 + b.abs()),
                    "{swapped:?} {other:?}"
                );
            }
        }
        assert!(seen >= 2, "{seen}");
    }
}

/// Large enough for large pages: a row of grains, each of which touches the next.
#[test]
fn a_long_row_is_in_balance() {
    const COUNT: usize = 40_000;
    let laws = Laws::new(&["nfd 1e4 0.3 40 60 tangential tfd 0.4"]);
    let workspace = WorkspaceHandle::new();
    let bodies: Vec<_> = (0..COUNT)
        .map(|k| EllgranBody {
            semi_axes: [1.0, 0.5, 0.7],
            particle_type: 1,
            ..sphere_at(1.99 * k as f64)
        })
        .collect();
    let rows = (0..COUNT)
        .map(|k| {
            if k + 1 < COUNT {
                vec![k as i32 + 1]
            } else {
                vec![]
            }
        })
        .collect();
    let mut list = List::new(rows, laws.length());
    let mut tallies = no_tallies();
    for step in 0..2 {
        let mut arrays = Arrays::new(&bodies, COUNT);
        arrays.forces.fill([0.0; 3]);
        let (particles, mut view) = (arrays.particles(), list.view(true));
        view.unchanged = step;
        ok(laws.pairs(&workspace, &particles, &view, &STEP, &mut tallies));
        assert_eq!(tallies.touching_count, (COUNT - 1) as f64);
        let end = arrays.forces[COUNT - 1][0];
        assert!(end > 1.0, "{end}");
        assert!((arrays.forces[0][0] + end).abs() < 1e-8 * end);
        for force in &arrays.forces[1..COUNT - 1] {
            // The coordinates at the far end are rounded by 1e-9 of the overlap.
            assert!(force[0].abs() < 1e-8 * end, "{force:?}");
        }
    }
}
