// SPDX-License-Identifier: MIT OR Apache-2.0
//! A wall that keeps the force with which it presses.

use super::growing::{given, growing, Output};
use super::status::{at_border, Failure, ELLGRAN_ERROR_ARGUMENT};
use crate::message::Number;
use crate::walls::{Servo, ServoLoad};
use libc::size_t;

/// The settings of a servo and its state, which the caller keeps from step to step and over restarts: at first zeros.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranServo {
    /// `sizeof(EllgranServo)`; `ELLGRAN_INIT` sets it.
    pub size: size_t,
    /// Force with which the wall is to press, in its direction, 0 or more.
    pub target: f64,
    /// Share of the error that one step takes away at most, above 0 and at most 1; 0.5 serves.
    pub gain: f64,
    /// Largest speed of the wall, above 0.
    pub largest_speed: f64,
    /// State, written: the part of the velocity that does not come from the present error.
    pub steady_velocity: f64,
    /// State, written: the velocity in its direction with which the wall moves in the next step.
    pub velocity: f64,
}

growing!(EllgranServo);

/// The velocity for the next step of a wall that keeps a force.
///
/// `force` is that with which the wall presses in its direction, minus the component of `EllgranWallLoad.force` along it; `stiffness`
/// and `damping` those of `EllgranWallLoad`; all three summed over ranks. The gain is relative to these: a step corrects the
/// share `gain` of the error, if what is behind the particles that touch does not give way, and the force does not overshoot from
/// step to step whatever the material, the number of contacts and the time step. A wall that must go on moving keeps its force
/// without an error. A wall that touches nothing approaches with `largest_speed`, or stays with a target of 0.
///
/// # Safety
/// `servo` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_servo_follow(
    servo: *mut EllgranServo,
    force: f64,
    stiffness: f64,
    damping: f64,
    time_step: f64,
) -> i32 {
    at_border("ellgran_servo_follow", || {
        // SAFETY: promised by the caller, for all of this function.
        let mut state = *unsafe { given(servo, "servo") }?;
        // SAFETY: `servo` is NULL or valid for writes, by this function's safety section; the reference of the line above is gone.
        let mut out = unsafe { Output::new(servo, "servo") }?;
        let wrong = |name: &str, value: f64, range: &str| {
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("servo: {name} = {} must be {range}", Number(value)),
            )
        };
        let positive = "a finite number greater than 0";
        for (name, value, holds, range) in [
            (
                "target",
                state.target,
                state.target >= 0.0 && state.target.is_finite(),
                "a finite number, 0 or greater: a wall presses and does not pull",
            ),
            (
                "gain",
                state.gain,
                state.gain > 0.0 && state.gain <= 1.0,
                "greater than 0 and at most 1",
            ),
            (
                "largest_speed",
                state.largest_speed,
                state.largest_speed > 0.0 && state.largest_speed.is_finite(),
                positive,
            ),
            (
                "time_step",
                time_step,
                time_step > 0.0 && time_step.is_finite(),
                positive,
            ),
            ("force", force, force.is_finite(), "finite"),
            (
                "stiffness",
                stiffness,
                stiffness >= 0.0 && stiffness.is_finite(),
                "a finite number, 0 or greater",
            ),
            (
                "damping",
                damping,
                damping >= 0.0 && damping.is_finite(),
                "a finite number, 0 or greater",
            ),
            (
                "steady_velocity",
                state.steady_velocity,
                state.steady_velocity.is_finite(),
                "finite",
            ),
        ] {
            if !holds {
                return Err(wrong(name, value, range));
            }
        }
        let mut servo = Servo {
            target: state.target,
            gain: state.gain,
            largest_speed: state.largest_speed,
            steady_velocity: state.steady_velocity,
            velocity: state.velocity,
        };
        let load = ServoLoad {
            force,
            stiffness,
            damping,
        };
        servo.follow(&load, time_step);
        state.steady_velocity = servo.steady_velocity;
        state.velocity = servo.velocity;
        out.write(&state);
        Ok(())
    })
}
