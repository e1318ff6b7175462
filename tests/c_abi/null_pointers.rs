// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every pointer that must not be NULL is checked, named in the message, and nothing is written.

use std::ffi::{c_char, CStr};
use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::law::*;
use ellgran::c_api::neighbour_list::*;
use ellgran::c_api::particles::*;
use ellgran::c_api::plane::*;
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::status::*;

use crate::scene::*;

const FRICTION: &str = "hertz 1e4 0.3 damping restitution 0.5 tangential mindlin 0.5";
const PLANE: EllgranPlane = EllgranPlane {
    size: size_of::<EllgranPlane>(),
    point: [0.0, 0.0, -0.9],
    normal: [0.0, 0.0, 1.0],
    velocity: [0.0; 3],
    velocity_change: [0.0; 3],
};

#[track_caller]
fn is_null(status: i32, name: &str) {
    fails(
        status,
        ELLGRAN_ERROR_NULL_POINTER,
        &[&format!("{name} must not be NULL")],
    );
}

#[test]
fn contact_geometry() {
    let (i, j) = (sphere_at(0.0), sphere_at(1.5));
    let mut out = Untouched::<EllgranContactGeometry>::sized();
    let (n, o) = (null(), out.pointer());
    // SAFETY: pointers are NULL or valid.
    unsafe {
        is_null(ellgran_contact_geometry(null(), null(), &j, n, o), "i");
        is_null(ellgran_contact_geometry(null(), &i, null(), n, o), "j");
        is_null(
            ellgran_contact_geometry(null(), &i, &j, n, null_mut()),
            "geometry",
        );
        is_null(ellgran_contact_geometry_plane(null(), &PLANE, o), "i");
        is_null(ellgran_contact_geometry_plane(&i, null(), o), "plane");
        is_null(
            ellgran_contact_geometry_plane(&i, &PLANE, null_mut()),
            "geometry",
        );
    }
    out.check();
}

#[test]
fn one_contact() {
    let laws = Laws::new(&[FRICTION]);
    let (i, j) = (sphere_at(0.0), sphere_at(1.5));
    let mut geometry = Untouched::<EllgranContactGeometry>::sized();
    let mut force = Untouched::<EllgranContactForce>::sized();
    let mut touching = Untouched::<i32>::new();
    let mut history = Untouched::<[f64; 7]>::new();
    assert_eq!(laws.length(), 7);
    let (l, s) = (laws.0, &STEP);
    let (t, h) = (touching.pointer(), history.pointer().cast());
    let (g, f) = (geometry.pointer(), force.pointer());
    let z = null_mut();
    // SAFETY: pointers are NULL or valid.
    unsafe {
        is_null(ellgran_contact(null(), &i, &j, s, t, h, g, f), "laws");
        is_null(ellgran_contact(l, null(), &j, s, t, h, g, f), "i");
        is_null(ellgran_contact(l, &i, null(), s, t, h, g, f), "j");
        is_null(ellgran_contact(l, &i, &j, null(), t, h, g, f), "step");
        is_null(
            ellgran_contact(l, &i, &j, s, null_mut(), h, g, f),
            "touching",
        );
        is_null(ellgran_contact(l, &i, &j, s, t, z, g, f), "history");
        is_null(ellgran_contact(l, &i, &j, s, t, h, g, null_mut()), "force");
        let p = &PLANE;
        is_null(
            ellgran_contact_plane(null(), &i, p, 1, s, t, h, g, f),
            "laws",
        );
        is_null(ellgran_contact_plane(l, null(), p, 1, s, t, h, g, f), "i");
        is_null(
            ellgran_contact_plane(l, &i, null(), 1, s, t, h, g, f),
            "plane",
        );
        is_null(
            ellgran_contact_plane(l, &i, p, 1, null(), t, h, g, f),
            "step",
        );
        is_null(
            ellgran_contact_plane(l, &i, p, 1, s, null_mut(), h, g, f),
            "touching",
        );
        is_null(ellgran_contact_plane(l, &i, p, 1, s, t, z, g, f), "history");
        is_null(
            ellgran_contact_plane(l, &i, p, 1, s, t, h, g, null_mut()),
            "force",
        );
    }
    geometry.check();
    force.check();
    touching.check();
    history.check();
}

#[test]
fn what_may_be_null_in_one_contact() {
    // Without history there is nothing to remember.
    let laws = Laws::with_options(&["hertz 1e4 0.3"], ELLGRAN_OPTION_NO_WARM_START);
    assert_eq!(laws.length(), 0);
    let (i, j) = (sphere_at(0.0), sphere_at(1.5));
    let mut force = Untouched::<EllgranContactForce>::sized();
    let (t, h, g) = (null_mut(), null_mut(), null_mut());
    // SAFETY: pointers are NULL or valid; the force is written on success.
    unsafe {
        ok(ellgran_contact(
            laws.0,
            &i,
            &j,
            &STEP,
            t,
            h,
            g,
            force.pointer(),
        ));
        assert!((*force.pointer()).force[0] > 0.0);
        ok(ellgran_contact_plane(
            laws.0,
            &i,
            &PLANE,
            1,
            &STEP,
            t,
            h,
            g,
            force.pointer(),
        ));
        assert!((*force.pointer()).force[2] < 0.0);
    }
}

#[test]
fn laws() {
    let laws = Laws::new(&[FRICTION]);
    let parameters = parse(FRICTION);
    let mut out = Untouched::<EllgranLawParameters>::sized();
    let mut read = Untouched::<usize>::new();
    let mut made = Untouched::<*mut EllgranLaws>::new();
    let mut target = Untouched::<[f64; 7]>::new();
    let mut text = Untouched::<[c_char; 80]>::new();
    let words = [c"hertz".as_ptr(), c"1e4".as_ptr(), null()];
    let source = [1.0; 7];
    // SAFETY: pointers are NULL or valid.
    unsafe {
        is_null(ellgran_law_parameters_default(null_mut()), "parameters");
        let (r, o) = (read.pointer(), out.pointer());
        is_null(ellgran_law_parameters_parse(3, null(), r, o), "words");
        is_null(
            ellgran_law_parameters_parse(3, words.as_ptr(), r, o),
            "words[2]",
        );
        is_null(parse_status(FRICTION, r, null_mut()), "parameters");
        let m = made.pointer();
        is_null(ellgran_laws_new(1, null(), &1, 0, m), "parameters");
        is_null(ellgran_laws_new(1, &parameters, null(), 0, m), "is_set");
        is_null(ellgran_laws_new(1, &parameters, &1, 0, null_mut()), "laws");
        let one = [0.5];
        is_null(ellgran_laws_with_friction(null(), one.as_ptr(), m), "laws");
        is_null(ellgran_laws_with_friction(laws.0, null(), m), "friction");
        is_null(
            ellgran_laws_with_friction(laws.0, one.as_ptr(), null_mut()),
            "result",
        );
        let (s, t) = (source.as_ptr(), target.pointer().cast());
        is_null(ellgran_history_swap(null(), s, t), "laws");
        is_null(ellgran_history_swap(laws.0, null(), t), "source");
        is_null(ellgran_history_swap(laws.0, s, null_mut()), "target");
        let b = text.pointer().cast();
        is_null(ellgran_laws_describe(null(), 1, 1, b, 80), "laws");
        is_null(
            ellgran_laws_describe(laws.0, 1, 1, null_mut(), 80),
            "buffer",
        );
        is_null(ellgran_workspace_new(null_mut()), "workspace");
    }
    out.check();
    read.check();
    made.check();
    target.check();
    text.check();
}

#[test]
fn queries_and_frees_of_null() {
    // SAFETY: NULL is allowed.
    unsafe {
        assert_eq!(ellgran_laws_history_length(null()), -1);
        assert_eq!(ellgran_laws_memory_offset(null()), -1);
        assert_eq!(ellgran_laws_read_histories_of(null(), null()), -1);
        assert_eq!(ellgran_laws_uses_mass(null()), -1);
        assert_eq!(ellgran_workspace_bytes(null()), 0);
        assert_eq!(ellgran_workspace_deep_contacts_count(null()), 0);
        ellgran_laws_free(null_mut());
        ellgran_workspace_free(null_mut());
    }
}

/// A change of the particles' pointers and the name that a message must give.
type Loss = (&'static str, fn(&mut EllgranParticles));

const PARTICLE_POINTERS: [Loss; 9] = [
    ("positions", |p| p.positions = null()),
    ("velocities", |p| p.velocities = null()),
    ("angular_momenta (or angular_velocities)", |p| {
        p.angular_velocities = null()
    }),
    ("masses (or contact_masses)", |p| p.masses = null()),
    ("types", |p| p.types = null()),
    ("semi_axes", |p| p.semi_axes = null()),
    ("quaternions", |p| p.quaternions = null()),
    ("forces", |p| p.forces = null_mut()),
    ("torques", |p| p.torques = null_mut()),
];

/// Two touching spheres, and everything that a call may write filled with what it must find again.
struct Pair {
    laws: Laws,
    workspace: WorkspaceHandle,
    arrays: Arrays,
    list: List,
}

impl Pair {
    fn new() -> Pair {
        let laws = Laws::new(&[FRICTION]);
        let mut list = List::new(vec![vec![1]], laws.length());
        list.history[0].fill(0.25);
        let mut arrays = Arrays::new(&[sphere_at(0.0), sphere_at(1.5)], 2);
        arrays.forces.fill([0.5; 3]);
        arrays.torques.fill([0.5; 3]);
        Pair {
            laws,
            workspace: WorkspaceHandle::new(),
            arrays,
            list,
        }
    }

    #[track_caller]
    fn check(&self) {
        assert_eq!(self.arrays.forces, [[0.5; 3]; 2]);
        assert_eq!(self.arrays.torques, [[0.5; 3]; 2]);
        assert_eq!(self.list.touching, [[0]]);
        assert!(self.list.history[0].iter().all(|h| *h == 0.25));
    }
}

#[test]
fn a_neighbour_list() {
    let mut x = Pair::new();
    let p = x.arrays.particles();
    let view = x.list.view(true);
    let (l, w, s) = (x.laws.0, x.workspace.0, &STEP);
    let t = null_mut();
    // SAFETY: pointers are NULL or valid.
    unsafe {
        is_null(ellgran_compute_pairs(null(), w, &p, &view, s, t), "laws");
        is_null(
            ellgran_compute_pairs(l, null_mut(), &p, &view, s, t),
            "workspace",
        );
        is_null(
            ellgran_compute_pairs(l, w, null(), &view, s, t),
            "particles",
        );
        is_null(ellgran_compute_pairs(l, w, &p, null(), s, t), "list");
        is_null(ellgran_compute_pairs(l, w, &p, &view, null(), t), "step");
        for (name, lose) in PARTICLE_POINTERS {
            let mut p = p;
            lose(&mut p);
            is_null(ellgran_compute_pairs(l, w, &p, &view, s, t), name);
        }
        let mut momenta = p;
        momenta.angular_momenta = p.angular_velocities;
        momenta.angular_velocities = null();
        momenta.contact_masses = p.masses;
        momenta.masses = null();
        is_null(ellgran_compute_pairs(l, w, &momenta, &view, s, t), "masses");
        type Lose = fn(&mut EllgranNeighbourList);
        let losses: [(&str, Lose); 5] = [
            ("central", |list| list.central = null()),
            ("neighbour_counts", |list| list.neighbour_counts = null()),
            ("neighbours", |list| list.neighbours = null()),
            ("touching", |list| list.touching = null()),
            ("history", |list| list.history = null()),
        ];
        for (name, lose) in losses {
            let mut view = view;
            lose(&mut view);
            is_null(ellgran_compute_pairs(l, w, &p, &view, s, t), name);
        }
        // The pointers to rows are read where a row has entries.
        let (row, flags, history) = ([null()], [null_mut()], [null_mut()]);
        let mut empty = view;
        empty.neighbours = row.as_ptr();
        is_null(
            ellgran_compute_pairs(l, w, &p, &empty, s, t),
            "neighbours[0]",
        );
        let mut empty = view;
        empty.touching = flags.as_ptr();
        is_null(ellgran_compute_pairs(l, w, &p, &empty, s, t), "touching[0]");
        let mut empty = view;
        empty.history = history.as_ptr();
        is_null(ellgran_compute_pairs(l, w, &p, &empty, s, t), "history[0]");
        x.check();
        // And with all of them it works.
        let mut kept = view;
        kept.keep_history = 1;
        ok(ellgran_compute_pairs(l, w, &p, &kept, s, t));
        is_null(ellgran_write_history(null_mut(), &view), "workspace");
        is_null(ellgran_write_history(w, null()), "list");
        let losses: [(&str, Lose); 3] = [
            ("neighbour_counts", |list| list.neighbour_counts = null()),
            ("touching", |list| list.touching = null()),
            ("history", |list| list.history = null()),
        ];
        // One at a time histories are written in every call: nothing is left to write, and nothing of the list is read.
        let one_by_one = CStr::from_ptr(ellgran_workspace_instruction_set(w)) == c"scalar";
        for (name, lose) in losses.into_iter().filter(|_| !one_by_one) {
            let mut view = view;
            lose(&mut view);
            is_null(ellgran_write_history(w, &view), name);
        }
        ok(ellgran_write_history(w, &view));
    }
    assert_ne!(x.arrays.forces[0], [0.5; 3]);
}

#[test]
fn walls() {
    let mut x = Pair::new();
    let p = x.arrays.particles();
    let (l, w, s) = (x.laws.0, x.workspace.0, &STEP);
    let wall = WallHandle::plane(PLANE.point, PLANE.normal);
    let mut memory = wall.histories(&x.laws, 2);
    let m = memory.as_mut_ptr();
    let (n, z) = (null(), null_mut());
    // SAFETY: pointers are NULL or valid.
    unsafe {
        let call = |l, w, wall, p, m, s| {
            ellgran_compute_wall(l, w, wall, p, null(), 0, 1, n, m, s, null_mut(), z)
        };
        is_null(call(null(), w, wall.0, &p, m, s), "laws");
        is_null(call(l, null_mut(), wall.0, &p, m, s), "workspace");
        is_null(call(l, w, null_mut(), &p, m, s), "wall");
        is_null(call(l, w, wall.0, null(), m, s), "particles");
        is_null(call(l, w, wall.0, &p, null_mut(), s), "histories");
        is_null(call(l, w, wall.0, &p, m, null()), "step");
        for (name, lose) in PARTICLE_POINTERS {
            let mut p = p;
            lose(&mut p);
            is_null(call(l, w, wall.0, &p, m, s), name);
        }
    }
    x.check();
    assert!(memory.iter().all(|m| *m == 0.0));
}
