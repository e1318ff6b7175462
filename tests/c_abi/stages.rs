// SPDX-License-Identifier: MIT OR Apache-2.0
//! A contact in stages: pointers, ranges, and the same numbers as the whole contact.

use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::law::{ellgran_laws_memory_offset, EllgranLaws};
use ellgran::c_api::particles::*;
use ellgran::c_api::plane::EllgranPlane;
use ellgran::c_api::staged::*;
use ellgran::c_api::status::*;

use crate::scene::*;

const FRICTION: &str = "nfd 1e4 0.3 40 60 tangential tfd 0.4";

const HISTORY: EllgranStagedHistory = EllgranStagedHistory {
    size: size_of::<EllgranStagedHistory>(),
    friction: 0.4,
    touched: 0,
    normal: [0.0; 3],
};

struct Staged(*mut EllgranStagedContact);

impl Staged {
    fn new() -> Staged {
        let mut staged = null_mut();
        // SAFETY: valid for writes.
        ok(unsafe { ellgran_staged_new(&mut staged) });
        Staged(staged)
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        // SAFETY: made by ellgran_staged_new and not used again.
        unsafe { ellgran_staged_free(self.0) }
    }
}

const WALL: EllgranWallSurface = EllgranWallSurface {
    size: size_of::<EllgranWallSurface>(),
    point: [0.0, 0.0, -0.9],
    normal: [0.0, 0.0, 2.0],
    direction: [0.0; 3],
    curvatures: [0.0; 2],
    turning_radii: [f64::INFINITY; 2],
    velocity: [0.1, 0.0, 0.2],
    others_share: 0.0,
    others_share_by_position: [0.0; 3],
    others_share_by_rotation: [0.0; 3],
    velocity_change: [0.0; 3],
};

#[track_caller]
fn is_null(status: i32, name: &str) {
    let text = format!("{name} must not be NULL");
    fails(status, ELLGRAN_ERROR_NULL_POINTER, &[&text]);
}

#[test]
fn pointers_of_the_stages() {
    let laws = Laws::new(&[FRICTION]);
    let staged = Staged::new();
    let (i, j) = (sphere_at(0.0), sphere_at(1.5));
    let mut geometry = Untouched::<EllgranStagedGeometry>::sized();
    let mut force = Untouched::<EllgranContactForce>::sized();
    let mut normal = Untouched::<[f64; 3]>::new();
    let mut memory = Untouched::<[f64; 3]>::new();
    let mut radius = Untouched::<f64>::new();
    let (s, l, z) = (staged.0, laws.0, null_mut());
    let mut crowd = Arrays::new(&[i, j], 2);
    let (g, f) = (geometry.pointer(), force.pointer());
    let (n, m) = (normal.pointer().cast(), memory.pointer().cast());
    // SAFETY: pointers are NULL or valid.
    unsafe {
        is_null(ellgran_staged_new(null_mut()), "staged");
        is_null(ellgran_staged_pair(null_mut(), &i, &j, 0.5, n, g), "staged");
        is_null(ellgran_staged_pair(s, null(), &j, 0.5, n, g), "i");
        is_null(ellgran_staged_pair(s, &i, null(), 0.5, n, g), "j");
        is_null(ellgran_staged_pair(s, &i, &j, 0.5, z, g), "cached_normal");
        is_null(
            ellgran_staged_pair(s, &i, &j, 0.5, n, null_mut()),
            "geometry",
        );
        is_null(ellgran_staged_wall(null_mut(), &i, &WALL, 0.5, g), "staged");
        is_null(ellgran_staged_wall(s, null(), &WALL, 0.5, g), "i");
        is_null(ellgran_staged_wall(s, &i, null(), 0.5, g), "wall");
        is_null(
            ellgran_staged_wall(s, &i, &WALL, 0.5, null_mut()),
            "geometry",
        );
        let mut start = [0.0; 3];
        let mut found = Untouched::sized();
        ok(ellgran_staged_pair(
            s,
            &i,
            &j,
            0.5,
            start.as_mut_ptr(),
            found.pointer(),
        ));
        is_null(
            ellgran_staged_equivalent_radius(null(), radius.pointer()),
            "staged",
        );
        is_null(ellgran_staged_equivalent_radius(s, null_mut()), "radius");
        is_null(
            ellgran_staged_section_area(null(), radius.pointer()),
            "staged",
        );
        is_null(ellgran_staged_section_area(s, null_mut()), "area");
        is_null(ellgran_staged_normal(null(), l, 1, 1, 1.0, f), "staged");
        is_null(ellgran_staged_normal(s, null(), 1, 1, 1.0, f), "laws");
        is_null(ellgran_staged_normal(s, l, 1, 1, 1.0, null_mut()), "force");
        type Stage = unsafe extern "C" fn(
            *const EllgranStagedContact,
            *const EllgranLaws,
            i32,
            i32,
            f64,
            *const EllgranStep,
            *const EllgranStagedHistory,
            *mut f64,
            *mut EllgranContactForce,
        ) -> i32;
        for stage in [ellgran_staged_tangential as Stage, ellgran_staged_forces] {
            let call = |s, l, step, b, m, f| stage(s, l, 1, 1, 1.0, step, b, m, f);
            is_null(call(null(), l, &STEP, &HISTORY, m, f), "staged");
            is_null(call(s, null(), &STEP, &HISTORY, m, f), "laws");
            is_null(call(s, l, null(), &HISTORY, m, f), "step");
            is_null(call(s, l, &STEP, null(), m, f), "history");
            is_null(call(s, l, &STEP, &HISTORY, z, f), "memory");
            is_null(call(s, l, &STEP, &HISTORY, m, null_mut()), "force");
        }
        let p = crowd.particles();
        is_null(ellgran_staged_prepare(null_mut(), &p), "staged");
        is_null(ellgran_staged_set_time_step(null_mut(), 1.0), "staged");
        is_null(ellgran_staged_prepare(s, null()), "particles");
        let call = |s, n, g| ellgran_staged_neighbours(s, 0, 1, 0.5, n, g);
        is_null(call(null_mut(), n, g), "staged");
        is_null(call(s, z, g), "cached_normal");
        is_null(call(s, n, null_mut()), "geometry");
        ellgran_staged_free(null_mut());
    }
    geometry.check();
    force.check();
    normal.check();
    memory.check();
    radius.check();
}

#[test]
fn values_of_the_stages() {
    let laws = Laws::new(&[FRICTION]);
    let staged = Staged::new();
    let (i, j) = (sphere_at(0.0), sphere_at(1.5));
    let mut geometry = Untouched::<EllgranStagedGeometry>::sized();
    let mut force = Untouched::<EllgranContactForce>::sized();
    let mut memory = Untouched::<[f64; 3]>::new();
    let mut radius = Untouched::<f64>::new();
    let mut start = [0.0; 3];
    let (s, l) = (staged.0, laws.0);
    let (g, f) = (geometry.pointer(), force.pointer());
    let argument = ELLGRAN_ERROR_ARGUMENT;
    // SAFETY: all pointers are valid.
    unsafe {
        // Nothing was found yet.
        let status = ellgran_staged_equivalent_radius(s, radius.pointer());
        fails(status, argument, &["do not touch"]);
        let status = ellgran_staged_section_area(s, radius.pointer());
        fails(status, argument, &["do not touch"]);
        fails(
            ellgran_staged_normal(s, l, 1, 1, 1.0, f),
            argument,
            &["do not touch"],
        );
        for share in [-0.1, 1.1, f64::NAN] {
            let words = ["share_i", &share.to_string()];
            let status = ellgran_staged_pair(s, &i, &j, share, start.as_mut_ptr(), g);
            fails(status, argument, &words);
            fails(
                ellgran_staged_wall(s, &i, &WALL, share, g),
                argument,
                &words,
            );
        }
        let mut wrong = i;
        wrong.semi_axes[1] = -1.0;
        for (a, b) in [(&wrong, &j), (&i, &wrong)] {
            let status = ellgran_staged_pair(s, a, b, 0.5, start.as_mut_ptr(), g);
            fails(
                status,
                ELLGRAN_ERROR_PARTICLE,
                &["particle 7", "semi-axis", "-1"],
            );
        }
        let mut crowd = Arrays::new(&[i, wrong], 2);
        let status = ellgran_staged_prepare(s, &crowd.particles());
        fails(
            status,
            ELLGRAN_ERROR_PARTICLE,
            &["particle 7", "semi-axis", "-1"],
        );
        // Nothing is prepared after a failure.
        let status = ellgran_staged_neighbours(s, 0, 1, 0.5, start.as_mut_ptr(), g);
        fails(status, argument, &["particles 0 and 1", "among the 0"]);
        let mut crowd = Arrays::new(&[i, j], 2);
        // Any type is right, and masses are not read.
        crowd.types = vec![1, 3];
        crowd.masses = vec![f64::NAN; 2];
        ok(ellgran_staged_prepare(s, &crowd.particles()));
        for (a, b) in [(0, 2), (2, 0), (usize::MAX, 1)] {
            let words = [&format!("particles {a} and {b}")[..], "among the 2"];
            let status = ellgran_staged_neighbours(s, a, b, 0.5, start.as_mut_ptr(), g);
            fails(status, argument, &words);
        }
        let status = ellgran_staged_neighbours(s, 0, 1, 2.0, start.as_mut_ptr(), g);
        fails(status, argument, &["share_i", "2"]);
        let changes: [fn(&mut EllgranWallSurface); 8] = [
            |w| w.normal = [0.0; 3],
            |w| w.normal[0] = f64::NAN,
            |w| w.point[0] = f64::NAN,
            |w| w.velocity[0] = f64::INFINITY,
            |w| w.curvatures[1] = f64::NAN,
            |w| w.turning_radii[0] = f64::NAN,
            |w| w.others_share = f64::NAN,
            |w| w.others_share = 1.5,
        ];
        for change in changes {
            let mut wall = WALL;
            change(&mut wall);
            fails(
                ellgran_staged_wall(s, &i, &wall, 0.5, g),
                argument,
                &["wall"],
            );
        }
        let mut wall = WALL;
        wall.curvatures = [-0.1, 0.0];
        wall.direction = wall.normal;
        fails(
            ellgran_staged_wall(s, &i, &wall, 0.5, g),
            argument,
            &["direction"],
        );
        assert_eq!(start, [0.0; 3]);
        for time_step in [-1.0, f64::NAN, 2e15] {
            let status = ellgran_staged_set_time_step(s, time_step);
            fails(status, argument, &["time_step", "at most 1e15"]);
        }

        let mut found = Untouched::sized();
        ok(ellgran_staged_pair(
            s,
            &i,
            &j,
            0.5,
            start.as_mut_ptr(),
            found.pointer(),
        ));
        for (a, b, name) in [(0, 1, "type_i"), (1, 2, "type_j")] {
            fails(ellgran_staged_normal(s, l, a, b, 1.0, f), argument, &[name]);
        }
        let m: *mut f64 = memory.pointer().cast();
        let call = |l, a, b, friction, step: &EllgranStep| {
            let history = EllgranStagedHistory {
                friction,
                ..HISTORY
            };
            ellgran_staged_tangential(s, l, a, b, 1.0, step, &history, m, f)
        };
        for (a, b, name) in [(0, 1, "type_i"), (1, 2, "type_j")] {
            fails(call(l, a, b, 0.4, &STEP), argument, &[name]);
        }
        for friction in [-0.1, f64::NAN, f64::INFINITY] {
            fails(
                call(l, 1, 1, friction, &STEP),
                argument,
                &["friction", &friction.to_string()],
            );
        }
        let backwards = EllgranStep {
            time_step: -1.0,
            ..STEP
        };
        fails(
            call(l, 1, 1, 0.4, &backwards),
            argument,
            &["time_step", "-1"],
        );
        // No stage resists rolling and twisting: nobody gets less than the law says.
        let resisted = Laws::new(&["hertz 1e4 0.3 tangential tfd 0.4 rolling sds 1e3 0 0.1"]);
        fails(
            call(resisted.0, 1, 1, 0.4, &STEP),
            ELLGRAN_ERROR_LAW,
            &["rolling none"],
        );
        // Nor do they keep the memory of the normal force.
        let with_memory = Laws::new(&["nfd 1e4 0.3 40 60 viscosity memory"]);
        fails(
            call(with_memory.0, 1, 1, 0.4, &STEP),
            ELLGRAN_ERROR_LAW,
            &["viscosity first_order"],
        );
        let with_springs = Laws::new(&["hertz 1e4 0.3 tangential tfd 0.4 displacement hysteretic"]);
        fails(
            call(with_springs.0, 1, 1, 0.4, &STEP),
            ELLGRAN_ERROR_LAW,
            &["displacement rescaled"],
        );
    }
    geometry.check();
    force.check();
    memory.check();
    radius.check();
}

fn size(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[track_caller]
fn close(a: [f64; 3], b: [f64; 3], scale: f64) {
    let apart = size([0, 1, 2].map(|k| a[k] - b[k]));
    assert!(apart <= 1e-12 * scale, "{a:?} and {b:?}");
}

#[test]
fn stages_of_a_pair_add_up_to_the_contact() {
    let laws = Laws::new(&[FRICTION, FRICTION]);
    let staged = Staged::new();
    let mut seen = 0;
    for k in 0..20 {
        let bodies = random_bodies(40 + k);
        let (mut i, mut j) = (bodies[k as usize], bodies[k as usize + 1]);
        // Half of them with velocities of the step, contacts that begin within it among them.
        if k % 2 == 1 {
            for body in [&mut i, &mut j] {
                body.velocities_of_step = 1;
                body.velocity_change = body.velocity.map(|v| 0.1 * v);
                body.angular_velocity_change = body.angular_velocity.map(|w| -0.2 * w);
            }
        }
        let (mut start, mut beside) = ([0.0; 3], [0.0; 3]);
        let (mut memory, mut memory_of_both) = ([0.0; 4], [0.0; 4]);
        let mut remembered = HISTORY;
        let mut touching = 0;
        let mut history = vec![0.0; laws.length()];
        for _ in 0..10 {
            let mut whole = Untouched::<EllgranContactForce>::sized();
            let mut geometry = Untouched::<EllgranStagedGeometry>::sized();
            let mut by_index = Untouched::<EllgranStagedGeometry>::sized();
            let (mut normal, mut tangential) = (Untouched::sized(), Untouched::sized());
            let mut both = Untouched::<EllgranContactForce>::sized();
            let mut arrays = Arrays::new(&[i, j], 2);
            // SAFETY: all pointers are valid; what is read was written on success.
            unsafe {
                ok(ellgran_contact(
                    laws.0,
                    &i,
                    &j,
                    &STEP,
                    &mut touching,
                    history.as_mut_ptr(),
                    null_mut(),
                    whole.pointer(),
                ));
                ok(ellgran_staged_pair(
                    staged.0,
                    &i,
                    &j,
                    0.5,
                    start.as_mut_ptr(),
                    geometry.pointer(),
                ));
                ok(ellgran_staged_set_time_step(staged.0, STEP.time_step));
                ok(ellgran_staged_prepare(staged.0, &arrays.particles()));
                ok(ellgran_staged_neighbours(
                    staged.0,
                    0,
                    1,
                    0.5,
                    beside.as_mut_ptr(),
                    by_index.pointer(),
                ));
                assert_eq!((*geometry.pointer()).touching, touching);
                assert_eq!((*by_index.pointer()).touching, touching);
                assert_eq!(start, beside);
                remembered.touched = remembered.touched.min(touching);
                if touching == 1 {
                    let (g, h) = (*geometry.pointer(), *by_index.pointer());
                    assert_eq!(
                        (g.penetration, g.normal, g.contact_point),
                        (h.penetration, h.normal, h.contact_point)
                    );
                    ok(ellgran_staged_normal(
                        staged.0,
                        laws.0,
                        1,
                        1,
                        1.0,
                        normal.pointer(),
                    ));
                    ok(ellgran_staged_tangential(
                        staged.0,
                        laws.0,
                        1,
                        1,
                        1.0,
                        &STEP,
                        &remembered,
                        memory.as_mut_ptr(),
                        tangential.pointer(),
                    ));
                    ok(ellgran_staged_forces(
                        staged.0,
                        laws.0,
                        1,
                        1,
                        1.0,
                        &STEP,
                        &remembered,
                        memory_of_both.as_mut_ptr(),
                        both.pointer(),
                    ));
                    let (a, b): (EllgranContactForce, EllgranContactForce) =
                        (*normal.pointer(), *tangential.pointer());
                    let (c, w) = (*both.pointer(), *whole.pointer());
                    let sum = |x: [f64; 3], y: [f64; 3]| [0, 1, 2].map(|k| x[k] + y[k]);
                    let scale = size(w.force);
                    close(sum(a.force, b.force), w.force, scale);
                    close(sum(a.torque_i, b.torque_i), w.torque_i, scale);
                    close(sum(a.torque_j, b.torque_j), w.torque_j, scale);
                    close(b.displacement, w.displacement, 1.0);
                    close(c.force, w.force, scale);
                    close(c.torque_i, w.torque_i, scale);
                    close(c.torque_j, w.torque_j, scale);
                    let first = |m: [f64; 4]| [m[0], m[1], m[2]];
                    close(first(memory), first(memory_of_both), size(first(memory)));
                    let kept = &history[ellgran_laws_memory_offset(laws.0) as usize..];
                    close(
                        first(memory),
                        [kept[0], kept[1], kept[2]],
                        size(first(memory)),
                    );
                    for energy in [memory_of_both[3], kept[3]] {
                        assert!((memory[3] - energy).abs() <= 1e-12 * energy);
                    }
                    remembered.normal = g.normal;
                    seen += 1;
                }
                remembered.touched = touching;
            }
            let mut both = [i, j];
            advance(&mut both, STEP.time_step);
            [i, j] = both;
        }
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn a_wall_in_stages_is_a_plane() {
    let laws = Laws::new(&["nfd 1e4 0.3 40 60"]);
    let staged = Staged::new();
    let plane = EllgranPlane {
        size: size_of::<EllgranPlane>(),
        point: WALL.point,
        normal: WALL.normal,
        velocity: WALL.velocity,
        velocity_change: WALL.velocity_change,
    };
    let mut i = random_bodies(1)[0];
    (i.position, i.particle_type) = ([0.0; 3], 1);
    i.semi_axes = [1.0, 1.2, 1.4];
    let mut geometry = Untouched::<EllgranStagedGeometry>::sized();
    let mut force = Untouched::<EllgranContactForce>::sized();
    let mut whole = Untouched::<EllgranContactForce>::sized();
    let (mut touching, mut history) = (0, vec![0.0; laws.length()]);
    let mut radius = 0.0;
    // SAFETY: all pointers are valid; what is read was written on success.
    unsafe {
        ok(ellgran_staged_wall(
            staged.0,
            &i,
            &WALL,
            0.5,
            geometry.pointer(),
        ));
        ok(ellgran_staged_normal(
            staged.0,
            laws.0,
            1,
            1,
            1.0,
            force.pointer(),
        ));
        ok(ellgran_staged_equivalent_radius(staged.0, &mut radius));
        ok(ellgran_contact_plane(
            laws.0,
            &i,
            &plane,
            1,
            &STEP,
            &mut touching,
            history.as_mut_ptr(),
            null_mut(),
            whole.pointer(),
        ));
        let (f, w) = (*force.pointer(), *whole.pointer());
        assert!(touching == 1 && w.normal_force > 0.0);
        close(f.force, w.force, size(w.force));
        close(f.torque_i, w.torque_i, size(w.force));
        assert!(radius > 0.5 && radius < 2.0, "{radius}");
        let (mut area, mut known) = (0.0, Untouched::<EllgranContactGeometry>::sized());
        ok(ellgran_staged_section_area(staged.0, &mut area));
        ok(ellgran_contact_geometry_plane(&i, &plane, known.pointer()));
        let k = *known.pointer();
        let section = std::f64::consts::PI * k.penetration / (k.curvature_a * k.curvature_b).sqrt();
        assert!((area - section).abs() < 1e-12 * section, "{area} {section}");
    }
}
