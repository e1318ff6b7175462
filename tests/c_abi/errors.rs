// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every error code, values out of range, and that a failing call writes nothing.

use std::collections::BTreeSet;
use std::ffi::c_char;
use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::law::*;
use ellgran::c_api::particles::*;
use ellgran::c_api::plane::*;
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::status::*;

use crate::scene::*;

const HERTZ: &str = "hertz 1e4 0.3";
const HALE: &str = "hertz 1e4 0.3 factors hale conservative no tangential mindlin 0.5";

#[test]
fn codes_are_those_that_were_given_out() {
    let codes = [
        ELLGRAN_SUCCESS,
        ELLGRAN_ERROR_NULL_POINTER,
        ELLGRAN_ERROR_ARGUMENT,
        ELLGRAN_ERROR_TEXT,
        ELLGRAN_ERROR_LAW,
        ELLGRAN_ERROR_HALE,
        ELLGRAN_ERROR_PARTICLE,
        ELLGRAN_ERROR_HISTORY,
        ELLGRAN_ERROR_RESULT,
        ELLGRAN_ERROR_PANIC,
    ];
    assert_eq!(codes, [0, 1, 2, 3, 100, 101, 200, 201, 202, 900]);
    assert_eq!(BTreeSet::from(codes).len(), codes.len());
}

#[test]
fn words_that_are_wrong() {
    for (deck, words) in [
        ("", &["normal law", "missing"][..]),
        ("herz 1e4 0.3", &["herz", "hertz"]),
        ("hertz 1e4", &["hertz", "missing"]),
        ("hertz 1e4 x", &["'x' is not a number"]),
        ("hertz -1e4 0.3", &["Young's modulus", "-10000"]),
        ("hertz 0 0.3", &["Young's modulus"]),
        ("hertz nan 0.3", &["Young's modulus", "NaN"]),
        ("hertz inf 0.3", &["Young's modulus", "inf"]),
        ("hertz 1e4 0.51", &["Poisson's ratio", "0.51"]),
        ("hertz 1e4 -1", &["Poisson's ratio", "-1"]),
        ("nfd 1e4 0.3 -1 1", &["eta1", "-1"]),
        ("nfd 1e4 0.3 1 -2", &["eta2", "-2"]),
        (
            "nfd 1e4 0 1 1 closure brilliantov",
            &["Poisson's ratio", "brilliantov"],
        ),
        ("lsd 0 1", &["kn"]),
        ("lsd 1 -1", &["cn"]),
        ("lsd 1 1 tangential tfd 0.5", &["lsd", "tfd"]),
        ("hertz 1e4 0.3 damping restitution 0", &["restitution", "0"]),
        (
            "hertz 1e4 0.3 damping restitution 1.1",
            &["restitution", "1.1"],
        ),
        ("hertz 1e4 0.3 damping relaxation -1", &["A_n", "-1"]),
        ("nfd 1e4 0.3 1 1 damping relaxation 1", &["damping"]),
        (
            "hertz 1e4 0.3 viscosity memory",
            &["viscosity memory", "nfd", "hertz"],
        ),
        ("lsd 1e4 1 viscosity memory", &["viscosity memory", "nfd"]),
        (
            "nfd 1e4 0.3 1 1 viscosity memory closure surface",
            &["closure surface", "viscosity first_order"],
        ),
        (
            "nfd 1e4 0.3 1 1 unloading first_order viscosity memory",
            &["unloading first_order", "viscosity first_order"],
        ),
        (
            "nfd 1e4 0.3 1 1 viscosity none",
            &["none", "first_order|memory"],
        ),
        ("hertz 1e4 0.3 tangential tfd -0.5", &["mu", "-0.5"]),
        ("hertz 1e4 0.3 tangential linear -1 0 0.5", &["kt", "-1"]),
        ("hertz 1e4 0.3 rolling sds -1 0 0.1", &["k_roll", "-1"]),
        ("hertz 1e4 0.3 rolling sds 1 0 -0.1", &["mu_roll", "-0.1"]),
        ("hertz 1e4 0.3 twisting sds 1 -2 0", &["gamma_twist", "-2"]),
        (
            "hertz 1e4 0.3 tangential tfd 0.5 twisting lubkin",
            &["twisting lubkin", "hysteretic", "twisting marshall"],
        ),
        (
            "hertz 1e4 0.3 twisting marshall",
            &["twisting marshall", "tangential", "twisting sds"],
        ),
        ("hertz 1e4 0.3 tangential linear 1 -1 0.5", &["ct", "-1"]),
        (
            "hertz 1e4 0.3 tangential linear 1 1",
            &["linear", "missing"],
        ),
        (
            "hertz 1e4 0.3 factors hale conservative yes",
            &["hale", "conservative"],
        ),
        ("hertz 1e4 0.3 conservative maybe", &["maybe", "yes|no"]),
        (
            "hertz 1e4 0.3 conservative no conservative no",
            &["conservative", "twice"],
        ),
        ("hertz 1e4 0.3 tangental none", &["tangental"]),
    ] {
        let mut out = Untouched::sized();
        fails(
            parse_status(deck, null_mut(), out.pointer()),
            ELLGRAN_ERROR_LAW,
            words,
        );
        out.check();
    }
}

#[test]
fn reading_ends_where_the_words_are_anothers() {
    let deck = "hertz 1e4 0.3 tangential tfd 0.5 zplane 0 NULL";
    let (mut read, mut out) = (Untouched::new(), Untouched::sized());
    ok(parse_status(deck, read.pointer(), out.pointer()));
    // SAFETY: written on success.
    assert_eq!(unsafe { *read.pointer() }, 6);
    let (mut read, mut out) = (Untouched::new(), Untouched::sized());
    let status = parse_status(
        "hertz 1e4 0.3 tangential none sideways",
        null_mut(),
        out.pointer(),
    );
    fails(status, ELLGRAN_ERROR_LAW, &["sideways"]);
    let status = parse_status(
        "hertz 1e4 0.3 tangential sideways",
        read.pointer(),
        out.pointer(),
    );
    fails(status, ELLGRAN_ERROR_LAW, &["sideways"]);
    read.check();
    out.check();
}

#[test]
fn text_that_is_not_utf_8() {
    let words = [c"hertz".as_ptr(), c"\xff".as_ptr()];
    let mut out = Untouched::sized();
    // SAFETY: the strings end with NUL.
    let status =
        unsafe { ellgran_law_parameters_parse(2, words.as_ptr(), null_mut(), out.pointer()) };
    fails(status, ELLGRAN_ERROR_TEXT, &["words[1]"]);
    out.check();
}

#[track_caller]
fn laws_fail(
    types: i32,
    parameters: &[EllgranLawParameters],
    set: &[u8],
    options: u32,
    code: i32,
    words: &[&str],
) {
    let mut out = Untouched::new();
    // SAFETY: the arrays are as long as types says, where that is a number of types.
    let status = unsafe {
        ellgran_laws_new(
            types,
            parameters.as_ptr(),
            set.as_ptr(),
            options,
            out.pointer(),
        )
    };
    fails(status, code, words);
    out.check();
}

#[test]
fn laws_that_cannot_be() {
    let p = [parse(HERTZ)];
    for types in [0, -1, i32::MIN, 10_000, i32::MAX] {
        laws_fail(
            types,
            &p,
            &[1],
            0,
            ELLGRAN_ERROR_ARGUMENT,
            &["type_count", &types.to_string()],
        );
    }
    for options in [2, 3, u32::MAX] {
        laws_fail(
            1,
            &p,
            &[1],
            options,
            ELLGRAN_ERROR_ARGUMENT,
            &["options", &options.to_string()],
        );
    }
    type Set = fn(&mut EllgranLawParameters, i32);
    let set: [(&str, Set); 9] = [
        ("normal", |p, v| p.normal = v),
        ("damping", |p, v| p.damping = v),
        ("tangential", |p, v| p.tangential = v),
        ("closure", |p, v| p.closure = v),
        ("unloading", |p, v| p.unloading = v),
        ("factors", |p, v| p.factors = v),
        ("displacement", |p, v| p.displacement = v),
        ("conservative", |p, v| p.conservative = v),
        ("limit_force", |p, v| p.limit_force = v),
    ];
    for (name, set) in set {
        for value in [-1, 4, i32::MIN, i32::MAX] {
            let mut p = p;
            set(&mut p[0], value);
            laws_fail(
                1,
                &p,
                &[1],
                0,
                ELLGRAN_ERROR_ARGUMENT,
                &[name, &value.to_string()],
            );
        }
    }
    let mut wrong = p;
    wrong[0].poissons_ratio = f64::NAN;
    laws_fail(
        1,
        &wrong,
        &[1],
        0,
        ELLGRAN_ERROR_LAW,
        &["Poisson's ratio", "NaN"],
    );
    laws_fail(1, &p, &[0], 0, ELLGRAN_ERROR_LAW, &["type 1"]);
    let two = [parse(HERTZ), parse(HERTZ), parse(HERTZ), parse("lsd 1 1")];
    laws_fail(2, &two, &[1, 0, 0, 0], 0, ELLGRAN_ERROR_LAW, &["type 2"]);
    laws_fail(
        2,
        &two,
        &[1, 0, 0, 1],
        0,
        ELLGRAN_ERROR_LAW,
        &["types 1 and 2"],
    );
}

#[test]
fn defaults_lack_their_constants() {
    let mut p = Untouched::sized();
    // SAFETY: written on success.
    let p = unsafe {
        ok(ellgran_law_parameters_default(p.pointer()));
        *p.pointer()
    };
    laws_fail(1, &[p], &[1], 0, ELLGRAN_ERROR_LAW, &["Young's modulus"]);
}

#[test]
fn a_description_is_cut_to_its_buffer() {
    let laws = Laws::new(&[HERTZ]);
    let describe = |capacity: usize| {
        let mut text = [1 as c_char; 400];
        // SAFETY: the capacity is within the buffer.
        ok(unsafe { ellgran_laws_describe(laws.0, 1, 1, text.as_mut_ptr(), capacity) });
        assert!(
            text[capacity..].iter().all(|c| *c == 1),
            "wrote past {capacity}"
        );
        let bytes: Vec<u8> = text
            .iter()
            .take_while(|c| **c != 0)
            // Signed on some machines only.
            .flat_map(|c| c.to_ne_bytes())
            .collect();
        String::from_utf8(bytes).unwrap()
    };
    let whole = describe(400);
    assert!(whole.len() > 10 && whole.contains("hertz"), "{whole}");
    assert_eq!(describe(10), whole[..9]);
    assert_eq!(describe(1), "");
    // SAFETY: no byte is written.
    ok(unsafe { ellgran_laws_describe(laws.0, 1, 1, null_mut(), 0) });
    for (i, j, name) in [
        (0, 1, "type_i"),
        (2, 1, "type_i"),
        (1, -3, "type_j"),
        (1, 2, "type_j"),
    ] {
        let mut text = Untouched::<[c_char; 40]>::new();
        // SAFETY: the buffer has 40 bytes.
        let status = unsafe { ellgran_laws_describe(laws.0, i, j, text.pointer().cast(), 40) };
        fails(status, ELLGRAN_ERROR_ARGUMENT, &[name]);
        text.check();
    }
}

/// What makes a body impossible, and the words of the message.
type Spoil = (&'static [&'static str], fn(&mut EllgranBody));

const BODIES: [Spoil; 14] = [
    (&["position", "NaN"], |b| b.position[1] = f64::NAN),
    (&["position", "inf"], |b| b.position[2] = f64::INFINITY),
    (&["velocity", "NaN"], |b| b.velocity[0] = f64::NAN),
    (&["angular velocity", "NaN"], |b| {
        b.angular_velocity[0] = f64::NAN
    }),
    (&["semi-axis", "0"], |b| b.semi_axes[0] = 0.0),
    (&["semi-axis", "-2.5"], |b| b.semi_axes[1] = -2.5),
    (&["semi-axis", "NaN"], |b| b.semi_axes[2] = f64::NAN),
    (&["semi-axis", "inf"], |b| b.semi_axes[2] = f64::INFINITY),
    (&["quaternion", "(0 0 0 0)"], |b| b.quaternion = [0.0; 4]),
    (&["quaternion", "NaN"], |b| b.quaternion[3] = f64::NAN),
    (&["type 0"], |b| b.particle_type = 0),
    (&["type -1"], |b| b.particle_type = -1),
    (&["type 2"], |b| b.particle_type = 2),
    (&["type 2147483647"], |b| b.particle_type = i32::MAX),
];

const MASSES: [Spoil; 3] = [
    (&["mass", "0"], |b| b.mass = 0.0),
    (&["mass", "-1"], |b| b.mass = -1.0),
    (&["mass", "NaN"], |b| b.mass = f64::NAN),
];

const PLANE: EllgranPlane = EllgranPlane {
    size: size_of::<EllgranPlane>(),
    point: [-0.9, 0.0, 0.0],
    normal: [1.0, 0.0, 0.0],
    velocity: [0.0; 3],
    velocity_change: [0.0; 3],
};

/// The outputs of a call for one contact.
struct Outputs {
    touching: Untouched<i32>,
    history: Untouched<[f64; 7]>,
    geometry: Untouched<EllgranContactGeometry>,
    force: Untouched<EllgranContactForce>,
}

impl Outputs {
    fn new() -> Outputs {
        Outputs {
            touching: Untouched::new(),
            history: Untouched::new(),
            geometry: Untouched::sized(),
            force: Untouched::sized(),
        }
    }

    fn pair(&mut self, laws: &Laws, i: &EllgranBody, j: &EllgranBody, step: &EllgranStep) -> i32 {
        let (t, h) = (self.touching.pointer(), self.history.pointer().cast());
        // SAFETY: all pointers are valid.
        unsafe {
            ellgran_contact(
                laws.0,
                i,
                j,
                step,
                t,
                h,
                self.geometry.pointer(),
                self.force.pointer(),
            )
        }
    }

    fn plane(
        &mut self,
        laws: &Laws,
        i: &EllgranBody,
        plane: &EllgranPlane,
        kind: i32,
        step: &EllgranStep,
    ) -> i32 {
        let (t, h) = (self.touching.pointer(), self.history.pointer().cast());
        let (g, f) = (self.geometry.pointer(), self.force.pointer());
        // SAFETY: all pointers are valid.
        unsafe { ellgran_contact_plane(laws.0, i, plane, kind, step, t, h, g, f) }
    }

    #[track_caller]
    fn check(&self) {
        self.touching.check();
        self.history.check();
        self.geometry.check();
        self.force.check();
    }
}

fn wrong_planes() -> [(EllgranPlane, &'static str); 4] {
    [
        (
            EllgranPlane {
                normal: [0.0; 3],
                ..PLANE
            },
            "normal",
        ),
        (
            EllgranPlane {
                normal: [f64::NAN; 3],
                ..PLANE
            },
            "NaN",
        ),
        (
            EllgranPlane {
                point: [f64::NAN; 3],
                ..PLANE
            },
            "NaN",
        ),
        (
            EllgranPlane {
                velocity: [f64::INFINITY; 3],
                ..PLANE
            },
            "inf",
        ),
    ]
}

fn wrong_steps() -> [EllgranStep; 3] {
    [-1.0, f64::NAN, f64::INFINITY].map(|time_step| EllgranStep { time_step, ..STEP })
}

#[test]
fn one_contact() {
    let laws = Laws::new(&[HALE]);
    let (i, j) = (sphere_at(0.0), sphere_at(1.5));
    let mut out = Outputs::new();
    for (words, spoil) in BODIES.into_iter().chain(MASSES) {
        let mut wrong = i;
        wrong.identifier = 123_456_789_012;
        spoil(&mut wrong);
        let words = [&["particle 123456789012"], words].concat();
        fails(
            out.pair(&laws, &wrong, &j, &STEP),
            ELLGRAN_ERROR_PARTICLE,
            &words,
        );
        fails(
            out.pair(&laws, &i, &wrong, &STEP),
            ELLGRAN_ERROR_PARTICLE,
            &words,
        );
        fails(
            out.plane(&laws, &wrong, &PLANE, 1, &STEP),
            ELLGRAN_ERROR_PARTICLE,
            &words,
        );
    }
    for step in wrong_steps() {
        let words = ["time_step", &step.time_step.to_string()];
        fails(
            out.pair(&laws, &i, &j, &step),
            ELLGRAN_ERROR_ARGUMENT,
            &words,
        );
        fails(
            out.plane(&laws, &i, &PLANE, 1, &step),
            ELLGRAN_ERROR_ARGUMENT,
            &words,
        );
    }
    for (plane, word) in wrong_planes() {
        fails(
            out.plane(&laws, &i, &plane, 1, &STEP),
            ELLGRAN_ERROR_ARGUMENT,
            &["plane", word],
        );
        let g = out.geometry.pointer();
        // SAFETY: all pointers are valid.
        let status = unsafe { ellgran_contact_geometry_plane(&i, &plane, g) };
        fails(status, ELLGRAN_ERROR_ARGUMENT, &["plane", word]);
    }
    for kind in [0, -1, 2] {
        let words = ["wall_type", &kind.to_string()];
        fails(
            out.plane(&laws, &i, &PLANE, kind, &STEP),
            ELLGRAN_ERROR_ARGUMENT,
            &words,
        );
    }
    out.check();
}

/// Long enough for Hale's form to break against its like, side by side, and against a plane.
fn needle_at(x: f64) -> EllgranBody {
    EllgranBody {
        semi_axes: [1.0, 1.0, 1000.0],
        ..sphere_at(x)
    }
}

#[test]
fn one_contact_where_hales_form_breaks() {
    let laws = Laws::new(&[HALE]);
    let (i, j) = (needle_at(0.0), needle_at(1.99));
    let mut out = Outputs::new();
    // SAFETY: any flag and history will do.
    unsafe {
        *out.touching.pointer() = 0;
        *out.history.pointer() = [0.0; 7];
    }
    fails(
        out.pair(&laws, &i, &j, &STEP),
        ELLGRAN_ERROR_HALE,
        &["particle 7", "factors exact"],
    );
    fails(
        out.plane(&laws, &i, &PLANE, 1, &STEP),
        ELLGRAN_ERROR_HALE,
        &["particle 7", "wall", "factors exact"],
    );
    out.geometry.check();
    out.force.check();
    // SAFETY: set above.
    unsafe {
        assert_eq!(*out.touching.pointer(), 0);
        assert_eq!(*out.history.pointer(), [0.0; 7]);
    }
}

/// Three bodies in a row, the first two and the last two touching; all that can be written holds a mark.
struct Row {
    laws: Laws,
    workspace: WorkspaceHandle,
    arrays: Arrays,
    list: List,
    memory: Vec<f64>,
}

impl Row {
    fn new(deck: &str, bodies: &[EllgranBody; 3]) -> Row {
        let laws = Laws::new(&[deck]);
        let mut list = List::new(vec![vec![1], vec![2]], laws.length());
        let mut arrays = Arrays::new(bodies, 3);
        arrays.forces.fill([0.5; 3]);
        arrays.torques.fill([0.5; 3]);
        list.history.iter_mut().for_each(|h| h.fill(0.0));
        Row {
            laws,
            workspace: WorkspaceHandle::new(),
            arrays,
            list,
            memory: vec![],
        }
    }

    fn pairs(&mut self, change: impl Fn(&mut EllgranParticles), step: &EllgranStep) -> i32 {
        let mut particles = self.arrays.particles();
        change(&mut particles);
        let view = self.list.view(true);
        self.laws
            .pairs(&self.workspace, &particles, &view, step, null_mut())
    }

    /// Against a plane at `x`, by its right.
    fn plane(
        &mut self,
        change: impl Fn(&mut EllgranParticles),
        x: f64,
        kind: i32,
        step: &EllgranStep,
    ) -> i32 {
        let wall = WallHandle::plane([x, 0.0, 0.0], [1.0, 0.0, 0.0]);
        self.memory = wall.histories(&self.laws, 3);
        let mut particles = self.arrays.particles();
        change(&mut particles);
        // SAFETY: all pointers are valid.
        unsafe {
            ellgran_compute_wall(
                self.laws.0,
                self.workspace.0,
                wall.0,
                &particles,
                null(),
                0,
                kind,
                null(),
                self.memory.as_mut_ptr(),
                step,
                null_mut(),
                null_mut(),
            )
        }
    }

    #[track_caller]
    fn check(&self) {
        assert_eq!(self.arrays.forces, [[0.5; 3]; 3]);
        assert_eq!(self.arrays.torques, [[0.5; 3]; 3]);
        assert_eq!(self.list.touching, [[0], [0]]);
        assert!(self.list.history.iter().flatten().all(|h| *h == 0.0));
        assert!(self.memory.iter().all(|m| *m == 0.0));
    }
}

fn row() -> [EllgranBody; 3] {
    [0.0, 1.5, 3.0].map(sphere_at)
}

#[test]
fn a_bad_particle_of_a_list() {
    const WITH_MASS: &str = "hertz 1e4 0.3 damping restitution 0.5 tangential mindlin 0.5";
    for (words, spoil) in BODIES.into_iter().chain(MASSES) {
        let mut bodies = row();
        // The last: all before it are good.
        spoil(&mut bodies[2]);
        bodies[2].identifier = 123_456_789_012;
        let words = [&["particle 123456789012"], words].concat();
        let mut row = Row::new(WITH_MASS, &bodies);
        fails(row.pairs(|_| (), &STEP), ELLGRAN_ERROR_PARTICLE, &words);
        // Particles that a wall cannot reach are not looked at: this one reaches into it.
        fails(
            row.plane(|_| (), 2.1, 1, &STEP),
            ELLGRAN_ERROR_PARTICLE,
            &words,
        );
        row.check();
    }
}

#[test]
fn masses_are_not_read_where_no_law_needs_them() {
    let mut bodies = row();
    bodies[2].mass = f64::NAN;
    let mut row = Row::new(HERTZ, &bodies);
    ok(row.pairs(|p| p.masses = null(), &STEP));
}

#[test]
fn identifiers_in_messages() {
    let mut bodies = row();
    bodies[1].semi_axes[0] = -1.0;
    let mut row = Row::new(HERTZ, &bodies);
    let short = [5, -77, 6];
    let long = [5, i64::MIN, 6];
    let narrow = |p: &mut EllgranParticles| {
        p.identifiers = short.as_ptr().cast();
        p.identifier_bytes = 4;
    };
    fails(
        row.pairs(narrow, &STEP),
        ELLGRAN_ERROR_PARTICLE,
        &["particle -77:"],
    );
    let wide = |p: &mut EllgranParticles| p.identifiers = long.as_ptr().cast();
    fails(
        row.pairs(wide, &STEP),
        ELLGRAN_ERROR_PARTICLE,
        &["particle -9223372036854775808:"],
    );
    let none = |p: &mut EllgranParticles| p.identifiers = null();
    fails(
        row.pairs(none, &STEP),
        ELLGRAN_ERROR_PARTICLE,
        &["particle 2:"],
    );
    for bytes in [0, -4, 5, 16] {
        let other = |p: &mut EllgranParticles| p.identifier_bytes = bytes;
        let words = ["identifier_bytes", &bytes.to_string()];
        fails(row.pairs(other, &STEP), ELLGRAN_ERROR_ARGUMENT, &words);
        fails(
            row.plane(other, -0.9, 1, &STEP),
            ELLGRAN_ERROR_ARGUMENT,
            &words,
        );
    }
    row.check();
}

#[test]
fn arguments_of_a_list() {
    let mut row = Row::new("hertz 1e4 0.3 tangential mindlin 0.5", &row());
    for step in wrong_steps() {
        let words = ["time_step", &step.time_step.to_string()];
        fails(row.pairs(|_| (), &step), ELLGRAN_ERROR_ARGUMENT, &words);
        fails(
            row.plane(|_| (), -0.9, 1, &step),
            ELLGRAN_ERROR_ARGUMENT,
            &words,
        );
    }
    fails(
        row.pairs(|p| p.owned_count = 4, &STEP),
        ELLGRAN_ERROR_ARGUMENT,
        &["owned_count", "4", "3"],
    );
    for kind in [0, -1, 2] {
        let words = ["wall_type", &kind.to_string()];
        fails(
            row.plane(|_| (), -0.9, kind, &STEP),
            ELLGRAN_ERROR_ARGUMENT,
            &words,
        );
    }
    let no_shape = [0, -1, 2];
    let indices = |p: &mut EllgranParticles| p.shape_indices = no_shape.as_ptr();
    fails(
        row.pairs(indices, &STEP),
        ELLGRAN_ERROR_PARTICLE,
        &["particle 7", "shape"],
    );
    let momentum = [[0.0; 3], [0.0; 3], [f64::NAN; 3]];
    let momenta = |p: &mut EllgranParticles| {
        p.angular_velocities = null();
        p.angular_momenta = momentum.as_ptr().cast();
    };
    fails(
        row.pairs(momenta, &STEP),
        ELLGRAN_ERROR_PARTICLE,
        &["angular momentum", "NaN"],
    );
    let still = [[0.0; 3]; 3];
    let infinite = [1.0, 1.0, f64::INFINITY];
    let masses = |p: &mut EllgranParticles| {
        p.angular_velocities = null();
        p.angular_momenta = still.as_ptr().cast();
        p.masses = infinite.as_ptr();
    };
    fails(
        row.pairs(masses, &STEP),
        ELLGRAN_ERROR_PARTICLE,
        &["mass = inf"],
    );
    row.check();
}

/// A stride that was left zero would give every particle the shape of the first.
#[test]
fn entries_that_overlap() {
    type Change = fn(&mut EllgranParticles, usize);
    let of_semi_axes: Change = |p, stride| p.semi_axes_stride = stride;
    let of_quaternions: Change = |p, stride| p.quaternions_stride = stride;
    let mut row = Row::new(HERTZ, &row());
    for (change, name, entry) in [
        (of_semi_axes, "semi_axes_stride", 24),
        (of_quaternions, "quaternions_stride", 32),
    ] {
        for stride in [0, 8, entry - 1] {
            let words = [
                &format!("{name} = {stride} ")[..],
                &format!("at least {entry}"),
            ];
            let in_pairs = row.pairs(|p| change(p, stride), &STEP);
            fails(in_pairs, ELLGRAN_ERROR_ARGUMENT, &words);
            let at_a_wall = row.plane(|p| change(p, stride), -0.9, 1, &STEP);
            fails(at_a_wall, ELLGRAN_ERROR_ARGUMENT, &words);
        }
    }
    row.check();
}

/// Bits that select a factor and belong to the index too: pairs would be left out by their index.
#[test]
fn factors_whose_bits_the_index_has() {
    let mut row = Row::new(HERTZ, &row());
    let particles = row.arrays.particles();
    let mut view = row.list.view(true);
    let factors = [1.0, 0.0, 0.0, 0.0];
    view.special_factors = factors.as_ptr();
    for (mask, shift) in [(-1, 0), (-1, 30), (0x3fff_ffff, 29), (0x7fff_ffff, 30)] {
        (view.index_mask, view.special_shift) = (mask, shift);
        let workspace = WorkspaceHandle::new();
        let status = (row.laws).pairs(&workspace, &particles, &view, &STEP, null_mut());
        let words = ["index_mask = 0x", &format!("special_shift = {shift}")];
        fails(status, ELLGRAN_ERROR_ARGUMENT, &words);
    }
    row.check();
}

#[test]
fn a_list_where_hales_form_breaks() {
    // The good contacts come first, and must not be written either.
    let mut bodies = [sphere_at(0.0), needle_at(1.9), needle_at(3.89)];
    bodies[1].identifier = 8;
    bodies[2].identifier = 9;
    let mut row = Row::new(HALE, &bodies);
    let words = ["particle 8", "particle 9", "factors exact"];
    fails(row.pairs(|_| (), &STEP), ELLGRAN_ERROR_HALE, &words);
    ok(row.plane(|_| (), -10.0, 1, &STEP));
    let mut bodies = [sphere_at(0.0), needle_at(0.05), needle_at(3.89)];
    bodies[1].identifier = 8;
    row.arrays = Row::new(HALE, &bodies).arrays;
    fails(
        row.plane(|_| (), -0.9, 1, &STEP),
        ELLGRAN_ERROR_HALE,
        &["particle 8", "wall"],
    );
    row.check();
}
