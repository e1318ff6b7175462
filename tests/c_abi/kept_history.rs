// SPDX-License-Identifier: MIT OR Apache-2.0
//! Histories that stay in the workspace: the forces are the same, and what is written on demand is what would have been
//! written in every step.

use std::ptr::null_mut;

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::law::ellgran_laws_new;
use ellgran::c_api::neighbour_list::{ellgran_forget_history, ellgran_write_history};
use ellgran::c_api::status::{ELLGRAN_ERROR_ARGUMENT, ELLGRAN_SUCCESS};

use crate::scene::*;

const OWNED: usize = 44;
const STEPS: usize = 50;
/// Steps between two looks at the history.
const LOOK: usize = 7;

/// History of 6 doubles, of 7, of 3, one contact at a time, and with what relaxes.
const DECKS: [[&str; 2]; 5] = [
    [
        "nfd 1e4 0.3 40 60 tangential tfd 0.4",
        "nfd 3e4 0.2 90 30 tangential tfd 0.2",
    ],
    [
        "hertz 1e4 0.3 tangential mindlin 0.4 displacement rescaled",
        "hertz 3e4 0.2 tangential mindlin 0.2 displacement rescaled",
    ],
    ["nfd 1e4 0.3 40 60", "nfd 3e4 0.2 90 30"],
    [
        "hertz 1e4 0.3 tangential mindlin 0.4 factors hale",
        "hertz 3e4 0.2 tangential mindlin 0.2 factors hale",
    ],
    [
        "nfd 1e4 0.3 40 60 viscosity memory tangential tfd 0.4",
        "nfd 3e4 0.2 90 30 viscosity memory tangential tfd 0.2",
    ],
];

struct Run {
    laws: Laws,
    workspace: WorkspaceHandle,
    list: List,
    keep: bool,
}

impl Run {
    fn new(decks: &[&str; 2], bodies: &[EllgranBody], keep: bool) -> Run {
        let laws = Laws::new(decks);
        let list = List::near(bodies, OWNED, laws.length());
        Run {
            laws,
            workspace: WorkspaceHandle::new(),
            list,
            keep,
        }
    }

    /// Status, forces and torques.
    fn step(&mut self, bodies: &[EllgranBody], unchanged: bool) -> (i32, [Vec<[f64; 3]>; 2]) {
        let mut arrays = Arrays::new(bodies, OWNED);
        arrays.forces.fill([0.0; 3]);
        arrays.torques.fill([0.0; 3]);
        let (particles, mut view) = (arrays.particles(), self.list.view(true));
        view.unchanged = i32::from(unchanged);
        view.keep_history = i32::from(self.keep);
        let status = self
            .laws
            .pairs(&self.workspace, &particles, &view, &STEP, null_mut());
        (status, [arrays.forces, arrays.torques])
    }

    fn write(&mut self) {
        let view = self.list.view(true);
        // SAFETY: the list is that of the last call.
        ok(unsafe { ellgran_write_history(self.workspace.0, &view) });
    }

    fn history(&self) -> (Vec<Vec<i32>>, Vec<Vec<f64>>) {
        (self.list.touching.clone(), self.list.history.clone())
    }
}

/// Bit by bit: what is kept is never rounded.
fn compare(scene: impl Fn() -> Vec<EllgranBody>, decks: &[&str; 2]) -> usize {
    let mut bodies = scene();
    let mut kept = Run::new(decks, &bodies, true);
    let mut written = Run::new(decks, &bodies, false);
    let mut behind = 0;
    for step in 0..STEPS {
        advance(&mut bodies, 3e-3);
        let (status, a) = kept.step(&bodies, step > 0);
        ok(status);
        let (status, b) = written.step(&bodies, step > 0);
        ok(status);
        assert_eq!(a, b, "step {step} of {decks:?}");
        if step % LOOK == LOOK - 1 {
            behind += usize::from(kept.history() != written.history());
            kept.write();
            assert_eq!(kept.history(), written.history(), "step {step}");
            // Once more, with nothing left to write.
            kept.write();
            assert_eq!(kept.history(), written.history(), "step {step}");
        }
    }
    let touching: i32 = kept.list.touching.iter().flatten().sum();
    assert!(touching > 10, "{touching}");
    behind
}

#[test]
fn what_is_kept_is_what_is_written() {
    for decks in &DECKS {
        let behind = compare(|| random_bodies(11), decks);
        let one_at_a_time = decks[0].contains("hale");
        assert_eq!(behind > 3, !one_at_a_time, "{behind} {decks:?}");
    }
}

#[test]
fn of_spheres_too() {
    let spheres = || {
        let mut bodies = random_bodies(12);
        for body in &mut bodies {
            let radius = body.semi_axes.iter().sum::<f64>() / 3.0;
            body.semi_axes = [radius; 3];
        }
        bodies
    };
    assert!(compare(spheres, &DECKS[0]) > 3);
}

#[test]
fn a_call_that_keeps_nothing_writes_all() {
    let mut bodies = random_bodies(13);
    let mut run = Run::new(&DECKS[0], &bodies, true);
    let mut other = Run::new(&DECKS[0], &bodies, false);
    for step in 0..10 {
        advance(&mut bodies, 3e-3);
        run.keep = step < 9;
        ok(run.step(&bodies, step > 0).0);
        ok(other.step(&bodies, step > 0).0);
    }
    assert_eq!(run.history(), other.history());
}

#[test]
fn a_list_that_changes_too_early_is_refused() {
    let mut bodies = random_bodies(14);
    let mut run = Run::new(&DECKS[0], &bodies, true);
    for step in 0..3 {
        advance(&mut bodies, 3e-3);
        ok(run.step(&bodies, step > 0).0);
    }
    let (status, forces) = run.step(&bodies, false);
    assert_eq!(status, ELLGRAN_ERROR_ARGUMENT);
    assert!(message().contains("ellgran_write_history"), "{}", message());
    assert!(forces.iter().flatten().flatten().all(|f| *f == 0.0));
    run.write();
    assert_eq!(run.step(&bodies, false).0, ELLGRAN_SUCCESS);
}

/// Types change what kinds of laws stand side by side, in an unchanged list too.
#[test]
fn types_may_change() {
    // Unlike types have a law of another kind.
    let (like, unlike) = ("nfd 1e4 0.3 40 60 tangential tfd 0.4", "hertz 3e4 0.2");
    let parameters = [like, unlike, unlike, like].map(parse);
    let laws = || {
        let mut laws = null_mut();
        // SAFETY: four parameters of two types.
        ok(unsafe { ellgran_laws_new(2, parameters.as_ptr(), [1; 4].as_ptr(), 0, &mut laws) });
        Laws(laws)
    };
    let mut bodies = random_bodies(15);
    let mut kept = Run::new(&[like, like], &bodies, true);
    let mut fresh = Run::new(&[like, like], &bodies, false);
    kept.laws = laws();
    fresh.laws = laws();
    for step in 0..20 {
        advance(&mut bodies, 1e-3);
        if step % 5 == 4 {
            for (k, body) in bodies.iter_mut().enumerate() {
                if k % 3 == step / 5 % 3 {
                    body.particle_type = 3 - body.particle_type;
                }
            }
        }
        let (status, a) = kept.step(&bodies, step > 0);
        ok(status);
        fresh.workspace = WorkspaceHandle::new();
        let (status, b) = fresh.step(&bodies, false);
        ok(status);
        let largest = b[0].iter().flatten().fold(0.0f64, |m, f| m.max(f.abs()));
        assert!(largest > 0.0);
        for (a, b) in a
            .iter()
            .flatten()
            .flatten()
            .zip(b.iter().flatten().flatten())
        {
            assert!((a - b).abs() <= 1e-11 * largest, "step {step}: {a} and {b}");
        }
    }
}

/// A caller that has given up its list loses what was kept of it, and nothing else: the new list is taken as it is, also
/// where it is said to be unchanged.
#[test]
fn what_is_kept_can_be_forgotten() {
    for unchanged in [false, true] {
        let mut bodies = random_bodies(5);
        let mut run = Run::new(&DECKS[0], &bodies, true);
        for step in 0..5 {
            advance(&mut bodies, 3e-3);
            ok(run.step(&bodies, step > 0).0);
        }
        let before = run.history();
        // The arrays of the list are gone; those of another one start from nothing.
        run.list = List::near(&bodies, OWNED, run.laws.length());
        let new = run.history();
        let words = ["unchanged = 0", "ellgran_forget_history"];
        let refused = run.step(&bodies, false).0;
        crate::scene::fails(refused, ELLGRAN_ERROR_ARGUMENT, &words);
        // SAFETY: the workspace is valid.
        ok(unsafe { ellgran_forget_history(run.workspace.0) });
        // Nothing is left to write.
        run.write();
        assert_eq!(run.history(), new);
        assert_ne!(before, new);
        let (status, forces) = run.step(&bodies, unchanged);
        ok(status);
        let mut fresh = Run::new(&DECKS[0], &bodies, true);
        let (status, expected) = fresh.step(&bodies, false);
        ok(status);
        // The two workspaces look at other candidates: the forces are the same but for rounding.
        let largest = |v: &[Vec<[f64; 3]>; 2]| {
            v.iter()
                .flatten()
                .flatten()
                .fold(0.0, |m: f64, x| x.abs().max(m))
        };
        let mut apart = forces.clone();
        for (a, b) in apart.iter_mut().flatten().zip(expected.iter().flatten()) {
            for (a, b) in a.iter_mut().zip(b) {
                *a -= b;
            }
        }
        assert!(largest(&apart) < 1e-12 * largest(&expected));
    }
    // SAFETY: NULL is refused.
    let status = unsafe { ellgran_forget_history(null_mut()) };
    crate::scene::fails(
        status,
        ellgran::c_api::status::ELLGRAN_ERROR_NULL_POINTER,
        &["workspace"],
    );
}
