// SPDX-License-Identifier: MIT OR Apache-2.0
//! `ellgran_start_step`, `ellgran_finish_step`, `ellgran_angular_velocities`: rigid bodies of any shape under any forces; and
//! `ellgran_servo_follow` under any load.

use std::ptr;

use ellgran::c_api::motion::*;
use ellgran::c_api::servo::*;

use super::histories::numbers;
use super::neighbour_list::bodies;
use super::scene::*;

pub fn run(bytes: &[u8]) {
    let u = &mut Bytes::new(bytes);
    let _ = steps(u);
    let _ = servo(u);
}

fn steps(u: &mut Bytes) -> arbitrary::Result<()> {
    let workspace = Workspace::read(u)?;
    let bodies = bodies(u, 1, 12)?;
    let count = bodies.len();
    let mut positions: Vec<_> = bodies.iter().map(|b| b.position).collect();
    let mut velocities: Vec<_> = bodies.iter().map(|b| b.velocity).collect();
    let mut momenta: Vec<_> = bodies.iter().map(|b| b.angular_velocity).collect();
    let masses: Vec<_> = bodies.iter().map(|b| b.mass).collect();
    let semi_axes: Vec<_> = bodies.iter().map(|b| b.semi_axes).collect();
    let mut quaternions: Vec<_> = bodies.iter().map(|b| b.quaternion).collect();
    let (mut forces, mut torques): (Vec<[f64; 3]>, Vec<[f64; 3]>) = (Vec::new(), Vec::new());
    for _ in 0..count {
        forces.push(usual_vector(u)?);
        torques.push(usual_vector(u)?);
    }
    if one_in(u, 4)? {
        forces[0][0] = number(u)?;
        torques[0][1] = number(u)?;
    }
    let extrapolated: bool = u.arbitrary()?;
    let mut changes = vec![[0.0; 6]; count];
    let mut loads_before = vec![[f64::INFINITY; 6]; count];
    let step = step(u)?.time_step;
    show("forces and torques", &(&forces, &torques, extrapolated));
    let null_unless = |wanted: bool, pointer: *mut f64| {
        if wanted {
            pointer
        } else {
            ptr::null_mut()
        }
    };
    for _ in 0..3 {
        let mut motion = sized::<EllgranMotion>();
        motion.count = count;
        motion.positions = positions.as_mut_ptr().cast();
        motion.velocities = velocities.as_mut_ptr().cast();
        motion.angular_momenta = momenta.as_mut_ptr().cast();
        motion.forces = forces.as_ptr().cast();
        motion.torques = torques.as_ptr().cast();
        motion.masses = masses.as_ptr();
        motion.semi_axes = semi_axes.as_ptr().cast();
        motion.semi_axes_stride = size_of::<[f64; 3]>();
        motion.quaternions = quaternions.as_mut_ptr().cast();
        motion.quaternions_stride = size_of::<[f64; 4]>();
        motion.velocity_changes = null_unless(extrapolated, changes.as_mut_ptr().cast());
        motion.loads_before = null_unless(extrapolated, loads_before.as_mut_ptr().cast());
        // SAFETY: the arrays are as long as the struct says.
        if !succeeded(unsafe { ellgran_start_step(workspace.0, &motion, step) }) {
            return Ok(());
        }
        for q in &quaternions {
            let square: f64 = q.iter().map(|x| x * x).sum();
            assert!((square - 1.0).abs() < 1e-12, "quaternion {q:?}");
        }
        // SAFETY: as above.
        if !succeeded(unsafe { ellgran_finish_step(workspace.0, &motion, step) }) {
            return Ok(());
        }
        let mut spins = vec![[f64::NAN; 3]; count];
        // SAFETY: as above.
        if !succeeded(unsafe {
            ellgran_angular_velocities(workspace.0, &motion, spins.as_mut_ptr().cast())
        }) {
            return Ok(());
        }
    }
    Ok(())
}

fn servo(u: &mut Bytes) -> arbitrary::Result<()> {
    let values = numbers(u, 8)?;
    let mut servo = sized::<EllgranServo>();
    servo.target = values[0].abs();
    servo.gain = values[1].abs();
    servo.largest_speed = values[2].abs();
    servo.steady_velocity = values[3];
    for _ in 0..3 {
        let before = servo;
        // SAFETY: valid.
        let status = unsafe {
            ellgran_servo_follow(
                &mut servo,
                values[4],
                values[5].abs(),
                values[6].abs(),
                values[7].abs(),
            )
        };
        if succeeded(status) {
            assert!(servo.velocity.abs() <= servo.largest_speed, "{servo:?}");
            assert!(servo.steady_velocity.is_finite(), "{servo:?}");
        } else {
            let numbers = |s: &EllgranServo| [s.velocity, s.steady_velocity];
            assert!(same_bits(&numbers(&servo), &numbers(&before)));
        }
    }
    Ok(())
}
