// SPDX-License-Identifier: MIT OR Apache-2.0
//! A step of velocity Verlet through the C interface: in an oscillator, on arrays with strides, and with what cannot be.

use ellgran::c_api::motion::{
    ellgran_angular_velocities, ellgran_finish_step, ellgran_start_step, EllgranMotion,
};
use ellgran::c_api::particles::{ellgran_workspace_free, ellgran_workspace_new, EllgranWorkspace};
use ellgran::c_api::status::{
    ellgran_last_error, ELLGRAN_ERROR_ARGUMENT, ELLGRAN_ERROR_NULL_POINTER, ELLGRAN_ERROR_PARTICLE,
    ELLGRAN_SUCCESS,
};
use std::ffi::CStr;

/// As an engine lays them out: shape and attitude in one entry of a list, not in the order of the bodies.
#[repr(C)]
#[derive(Clone, Copy, Default)]
struct Entry {
    before: f64,
    semi_axes: [f64; 3],
    between: i64,
    quaternion: [f64; 4],
}

struct Bodies {
    workspace: *mut EllgranWorkspace,
    x: Vec<[f64; 3]>,
    v: Vec<[f64; 3]>,
    l: Vec<[f64; 3]>,
    f: Vec<[f64; 3]>,
    t: Vec<[f64; 3]>,
    mass: Vec<f64>,
    index: Vec<i32>,
    mask: Vec<i32>,
    tag: Vec<i64>,
    entries: Vec<Entry>,
    /// Velocity changes and loads before, where forces are to see velocities of the step.
    of_step: Option<[Vec<[f64; 6]>; 2]>,
    time_step_before: f64,
}

impl Bodies {
    /// The semi-axes of a body.
    fn shape(&mut self, body: usize) -> &mut [f64; 3] {
        &mut self.entries[self.index[body] as usize].semi_axes
    }

    fn new(n: usize) -> Bodies {
        let mut workspace = core::ptr::null_mut();
        // SAFETY: valid for writes.
        assert_eq!(
            unsafe { ellgran_workspace_new(&mut workspace) },
            ELLGRAN_SUCCESS
        );
        let entry = |k: usize| Entry {
            semi_axes: [1.0, 1.0 + 0.1 * (k % 3) as f64, 2.0],
            quaternion: [0.5, -0.5, 0.5, 0.5],
            ..Entry::default()
        };
        Bodies {
            workspace,
            x: vec![[1.0, 0.0, 0.0]; n],
            v: vec![[0.0, 1.0, 0.0]; n],
            l: vec![[0.1, 0.2, 0.3]; n],
            f: vec![[0.0; 3]; n],
            t: vec![[0.0; 3]; n],
            mass: vec![2.0; n],
            index: (0..n as i32).rev().collect(),
            mask: vec![1; n],
            tag: (0..n as i64).map(|k| 100 + k).collect(),
            entries: (0..n).map(entry).collect(),
            of_step: None,
            time_step_before: 0.0,
        }
    }

    fn motion(&mut self) -> EllgranMotion {
        let first = self.entries.as_mut_ptr();
        let none = core::ptr::null_mut();
        let [velocity_changes, loads_before] = match &mut self.of_step {
            Some(arrays) => arrays.each_mut().map(|array| array.as_mut_ptr().cast()),
            None => [none; 2],
        };
        EllgranMotion {
            size: size_of::<EllgranMotion>(),
            count: self.x.len(),
            positions: self.x.as_mut_ptr().cast(),
            velocities: self.v.as_mut_ptr().cast(),
            angular_momenta: self.l.as_mut_ptr().cast(),
            forces: self.f.as_ptr().cast(),
            torques: self.t.as_ptr().cast(),
            masses: self.mass.as_ptr(),
            shape_indices: self.index.as_ptr(),
            // SAFETY: the first entry is there.
            semi_axes: unsafe { &raw const (*first).semi_axes }.cast(),
            semi_axes_stride: size_of::<Entry>(),
            // SAFETY: as above.
            quaternions: unsafe { &raw mut (*first).quaternion }.cast(),
            quaternions_stride: size_of::<Entry>(),
            masks: self.mask.as_ptr(),
            group_mask: 1,
            identifier_bytes: 8,
            identifiers: self.tag.as_ptr().cast(),
            velocity_changes,
            loads_before,
            time_step_before: self.time_step_before,
        }
    }

    fn start(&mut self, time_step: f64) -> i32 {
        let motion = self.motion();
        // SAFETY: the arrays are as stated.
        unsafe { ellgran_start_step(self.workspace, &motion, time_step) }
    }

    fn finish(&mut self, time_step: f64) -> i32 {
        let motion = self.motion();
        // SAFETY: the arrays are as stated.
        unsafe { ellgran_finish_step(self.workspace, &motion, time_step) }
    }
}

impl Drop for Bodies {
    fn drop(&mut self) {
        // SAFETY: it came from `ellgran_workspace_new`.
        unsafe { ellgran_workspace_free(self.workspace) }
    }
}

fn message() -> String {
    // SAFETY: never NULL, ends in 0.
    unsafe { CStr::from_ptr(ellgran_last_error()) }
        .to_string_lossy()
        .into_owned()
}

/// A spring to the origin: velocity Verlet on a circle, with its own known frequency.
#[test]
fn an_oscillator_has_the_frequency_of_velocity_verlet() {
    let (n, time_step) = (37, 0.05);
    let mut bodies = Bodies::new(n);
    let spring = 2.0; // with mass 2: omega = 1
    let pull = |b: &mut Bodies| {
        for k in 0..n {
            b.f[k] = b.x[k].map(|x| -spring * x);
        }
    };
    pull(&mut bodies);
    let steps = 200;
    for _ in 0..steps {
        assert_eq!(bodies.start(time_step), ELLGRAN_SUCCESS, "{}", message());
        pull(&mut bodies);
        assert_eq!(bodies.finish(time_step), ELLGRAN_SUCCESS, "{}", message());
    }
    // cos(w dt) = 1 - (omega dt)^2/2, and the velocity at start is 1 where the circle's is sqrt(1 - (omega dt)^2/4).
    let w = (1.0 - 0.5 * time_step * time_step).acos() / time_step;
    let circle = (1.0 - 0.25 * time_step * time_step).sqrt();
    let angle = w * time_step * steps as f64;
    for x in &bodies.x {
        assert!((x[0] - angle.cos()).abs() < 1e-11, "{x:?}");
        assert!((x[1] - angle.sin() / circle).abs() < 1e-11, "{x:?}");
    }
}

/// A sphere on a spring in a viscous fluid, its step changing from one to the next; largest error of position and angular
/// momentum after a time. `x'' + 2 d x' + x = 0`, `L' = -d L`.
fn error_in_a_fluid(steps: usize, of_step: bool) -> f64 {
    let (n, damping, time) = (19, 0.2, 5.0);
    let mut bodies = Bodies::new(n);
    for entry in &mut bodies.entries {
        entry.semi_axes = [1.0; 3];
    }
    let unknown = [f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0];
    if of_step {
        bodies.of_step = Some([vec![[0.0; 6]; n], vec![unknown; n]]);
    }
    let resist = |b: &mut Bodies| {
        for k in 0..n {
            for axis in 0..3 {
                b.f[k][axis] = -b.mass[k] * (b.x[k][axis] + 2.0 * damping * b.v[k][axis]);
                b.t[k][axis] = -damping * b.l[k][axis];
            }
        }
    };
    resist(&mut bodies);
    for step in 0..steps {
        let time_step = time / steps as f64 * if step % 4 < 2 { 0.8 } else { 1.2 };
        assert_eq!(bodies.start(time_step), ELLGRAN_SUCCESS, "{}", message());
        resist(&mut bodies);
        assert_eq!(bodies.finish(time_step), ELLGRAN_SUCCESS, "{}", message());
        bodies.time_step_before = time_step;
    }
    let w = (1.0 - damping * damping).sqrt();
    let (sin, cos) = (w * time).sin_cos();
    let decay = (-damping * time).exp();
    let exact = [
        decay * (cos + damping / w * sin),
        decay * sin / w,
        0.0,
        0.1 * decay,
        0.2 * decay,
        0.3 * decay,
    ];
    let of = |k: usize| [bodies.x[k], bodies.l[k]].concat();
    (0..n).fold(0.0, |worst: f64, k| {
        let gaps = of(k).into_iter().zip(exact).map(|(a, b)| (a - b).abs());
        gaps.fold(worst, f64::max)
    })
}

#[test]
fn forces_that_see_velocities_of_the_step_make_the_motion_second_order() {
    for (of_step, order) in [(false, 1.0), (true, 2.0)] {
        let errors = [200, 400, 800].map(|steps| error_in_a_fluid(steps, of_step));
        println!("of the step: {of_step}, errors {errors:?}");
        for pair in errors.windows(2) {
            let found = (pair[0] / pair[1]).log2();
            assert!((found - order).abs() < 0.1, "{of_step}: order {found}");
        }
        assert!(errors[0] < if of_step { 2e-4 } else { 1e-2 });
    }
}

/// Between steps velocities are those of the step, and the changes lead to what the forces saw; a load that turns round is
/// not extrapolated.
#[test]
fn velocity_changes_are_those_that_the_interface_states() {
    let mut bodies = Bodies::new(1);
    bodies.of_step = Some([
        vec![[0.0; 6]],
        vec![[f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0]],
    ]);
    let (step, mass) = (0.01, 2.0);
    let mut expected_half = [0.0, 1.0, 0.0];
    // Forces along x: steady, growing, turned round.
    let mut before = 4.0;
    for (force, extrapolated) in [(4.0, 4.0), (6.0, 8.0), (-3.0, 0.0), (-3.0, -3.0)] {
        bodies.f[0] = [force, 0.0, 0.0];
        assert_eq!(bodies.start(step), ELLGRAN_SUCCESS, "{}", message());
        expected_half[0] += 0.5 * step * force / mass;
        let change = 0.5 * step * extrapolated / mass;
        let [changes, loads] = bodies.of_step.as_ref().expect("given");
        assert!(
            (changes[0][0] - change).abs() < 1e-16,
            "{force} after {before}"
        );
        assert_eq!(loads[0], [force, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!((bodies.v[0][0] - expected_half[0] - change).abs() < 1e-16);
        let seen = bodies.v[0][0];
        assert_eq!(bodies.finish(step), ELLGRAN_SUCCESS, "{}", message());
        expected_half[0] += 0.5 * step * force / mass;
        assert!((bodies.v[0][0] - expected_half[0]).abs() < 1e-16);
        let [changes, _] = bodies.of_step.as_ref().expect("given");
        assert!((bodies.v[0][0] + changes[0][0] - seen).abs() < 1e-16);
        before = force;
    }
}

#[test]
fn torques_kick_angular_momenta_and_only_the_group_moves() {
    let mut bodies = Bodies::new(21);
    for k in 0..21 {
        bodies.mask[k] = if k % 2 == 0 { 5 } else { 2 };
        bodies.t[k] = [1.0, 2.0, -3.0];
    }
    let before: Vec<_> = bodies.entries.iter().map(|e| e.quaternion).collect();
    assert_eq!(bodies.start(0.01), ELLGRAN_SUCCESS, "{}", message());
    assert_eq!(bodies.finish(0.01), ELLGRAN_SUCCESS, "{}", message());
    for k in 0..21 {
        let moves = k % 2 == 0;
        let expected = if moves {
            [0.11, 0.22, 0.27]
        } else {
            [0.1, 0.2, 0.3]
        };
        for (l, expected) in bodies.l[k].iter().zip(expected) {
            assert!((l - expected).abs() < 1e-15, "body {k}");
        }
        let entry = bodies.index[k] as usize;
        assert_eq!(
            bodies.entries[entry].quaternion != before[entry],
            moves,
            "body {k}"
        );
        assert_eq!(bodies.x[k] != [1.0, 0.0, 0.0], moves, "body {k}");
    }
}

#[test]
fn what_cannot_move_is_an_error_that_names_it() {
    type Change = fn(&mut Bodies);
    let cases: [(Change, &str); 9] = [
        (|b| b.index[7] = -1, "particle 107: it has no shape"),
        (|b| b.mass[7] = 0.0, "particle 107: mass = 0"),
        (|b| b.mass[7] = f64::NAN, "particle 107: mass = NaN"),
        (
            |b| b.l[7] = [1e9, 0.0, 0.0],
            "particle 107: it would turn by",
        ),
        (
            |b| b.t[7] = [f64::INFINITY, 0.0, 0.0],
            "particle 107: it would turn by",
        ),
        (
            |b| {
                let entry = b.index[7] as usize;
                b.entries[entry].quaternion = [0.0; 4];
            },
            "particle 107: its quaternion has length 0",
        ),
        (|b| b.shape(7)[2] = 1e276, "particle 107: semi-axis = 1e276"),
        (
            |b| b.shape(7)[0] = f64::NAN,
            "particle 107: semi-axis = NaN",
        ),
        (
            |b| *b.shape(7) = [1.0, 1.0, 1e-30],
            "particle 107: semi-axis = 1e-30",
        ),
    ];
    for (change, said) in cases {
        let mut bodies = Bodies::new(19);
        change(&mut bodies);
        assert_eq!(bodies.start(0.01), ELLGRAN_ERROR_PARTICLE, "{said}");
        assert!(message().contains(said), "{} is not {said}", message());
    }
    // At the very ends of the range.
    for length in [1e-20, 1e20] {
        let mut bodies = Bodies::new(19);
        *bodies.shape(7) = [length; 3];
        bodies.l[7] = [0.0; 3];
        assert_eq!(bodies.start(0.01), ELLGRAN_SUCCESS, "{}", message());
    }
    let mut bodies = Bodies::new(3);
    assert_eq!(bodies.start(-1.0), ELLGRAN_ERROR_ARGUMENT);
    assert!(message().contains("time_step = -1"), "{}", message());
    assert_eq!(bodies.finish(f64::NAN), ELLGRAN_ERROR_ARGUMENT);
    let mut motion = bodies.motion();
    motion.torques = core::ptr::null();
    // SAFETY: the arrays are as stated, but for one that is refused.
    let status = unsafe { ellgran_start_step(bodies.workspace, &motion, 0.1) };
    assert_eq!(status, ELLGRAN_ERROR_NULL_POINTER);
    assert!(message().contains("torques"), "{}", message());
    for (semi_axes_stride, quaternions_stride, said) in [
        (0, 32, "semi_axes_stride = 0 must be at least 24"),
        (24, 31, "quaternions_stride = 31 must be at least 32"),
    ] {
        let overlapping = EllgranMotion {
            semi_axes_stride,
            quaternions_stride,
            ..bodies.motion()
        };
        // SAFETY: as above.
        let status = unsafe { ellgran_start_step(bodies.workspace, &overlapping, 0.1) };
        assert_eq!(status, ELLGRAN_ERROR_ARGUMENT);
        assert!(message().contains(said), "{}", message());
    }
    // No bodies need no arrays.
    let none = EllgranMotion {
        count: 0,
        positions: core::ptr::null_mut(),
        ..motion
    };
    // SAFETY: no array is read.
    assert_eq!(
        unsafe { ellgran_start_step(bodies.workspace, &none, 0.1) },
        ELLGRAN_SUCCESS
    );
}

#[test]
fn angular_velocities_go_with_angular_momenta() {
    let mut bodies = Bodies::new(6);
    bodies.mask[4] = 2;
    let motion = EllgranMotion {
        group_mask: 1,
        ..bodies.motion()
    };
    // Of any length.
    bodies.entries[bodies.index[1] as usize].quaternion = [1.0, -1.0, 1.0, 1.0];
    let mut omega = [[7.0; 3]; 6];
    // SAFETY: the arrays have these lengths.
    let status =
        unsafe { ellgran_angular_velocities(bodies.workspace, &motion, omega.as_mut_ptr().cast()) };
    assert_eq!(status, ELLGRAN_SUCCESS, "{}", message());
    assert_eq!(omega[4], [7.0; 3], "a body that does not move");
    for k in [0, 1, 2, 3, 5] {
        let entry = &bodies.entries[bodies.index[k] as usize];
        let [a, b, c] = entry.semi_axes.map(|x| x * x);
        let moments = [b + c, c + a, a + b].map(|x| bodies.mass[k] / 5.0 * x);
        // This quaternion turns the body's x, y, z to -z, -x, y of the world.
        let columns = [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        for axis in 0..3 {
            let own = dot(columns[axis], omega[k]) * moments[axis];
            let expected = dot(columns[axis], bodies.l[k]);
            assert!((own - expected).abs() < 1e-15, "body {k}: {own} {expected}");
        }
    }

    bodies.entries[bodies.index[3] as usize].quaternion = [0.0; 4];
    let motion = bodies.motion();
    // SAFETY: as above.
    let status =
        unsafe { ellgran_angular_velocities(bodies.workspace, &motion, omega.as_mut_ptr().cast()) };
    assert_eq!(status, ELLGRAN_ERROR_PARTICLE);
    assert!(
        message().contains("particle 103: its quaternion has length 0"),
        "{}",
        message()
    );
    // SAFETY: NULL is an error.
    let status =
        unsafe { ellgran_angular_velocities(bodies.workspace, &motion, core::ptr::null_mut()) };
    assert_eq!(status, ELLGRAN_ERROR_NULL_POINTER);
}
