// SPDX-License-Identifier: MIT OR Apache-2.0
//! With which velocity a wall keeps the force with which it presses on the particles.
//!
//! The wall moves along one direction with the velocity `u = e g + w`, `e` the target less the present force. With `K` and `C` the
//! stiffness and the damping of all contacts of the wall, a step of velocity `u` changes the force by `(K dt + C) u` at most:
//! what is behind the particles that touch can only give way further. `g = gain/(K dt + C)` therefore takes away at most the share
//! `gain` of `e` in each step, and no gain below 1 makes the force swing from step to step. The second part, `w`, sums up
//! `e gain^2/4 K dt/(K dt + C)^2` and leaves no error where the wall must go on moving; the two together are damped critically
//! on the spring `K` with the dashpot `C`.
//!
//! As a mechanical system this is a wall without weight behind a dashpot `1/g`, beside a mass of `4 (K dt + C)^2/(K gain^2)`, pushed by the
//! target: it takes energy out of any swinging of the particles, and gives none to it.

/// The settings of a servo, and its state between steps.
///
/// # Example
/// ```
/// use ellgran::walls::{Servo, ServoLoad};
///
/// // A plate on a spring of 1 kN/m, pressed until it feels 5 N. It approaches at 1 cm/s where it touches nothing.
/// let mut plate = Servo { target: 5.0, gain: 0.1, largest_speed: 0.01, steady_velocity: 0.0, velocity: 0.0 };
/// let (mut way, time_step) = (0.0, 1e-4);
/// plate.follow(&ServoLoad { force: 0.0, stiffness: 0.0, damping: 0.0 }, time_step);
/// assert_eq!(plate.velocity, 0.01);
/// for _ in 0..10_000 {
///     plate.follow(&ServoLoad { force: 1e3 * way, stiffness: 1e3, damping: 0.0 }, time_step);
///     way += plate.velocity * time_step;
/// }
/// assert!((1e3 * way - 5.0).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Servo {
    /// Force with which the wall is to press, 0 or more.
    pub target: f64,
    /// Share of the error that one step takes away at most, above 0 and at most 1.
    pub gain: f64,
    /// Largest speed of the wall, above 0.
    pub largest_speed: f64,
    /// `w` of this module: the part of the velocity that does not come from the present error.
    pub steady_velocity: f64,
    /// Velocity in the direction in which it presses, for the next step.
    pub velocity: f64,
}

/// What a wall feels, over all its particles.
#[derive(Clone, Copy, Debug)]
pub struct ServoLoad {
    /// Force with which the wall presses, in the direction of the servo.
    pub force: f64,
    /// Stiffness of its contacts ([`super::WallLoad::stiffness`]).
    pub stiffness: f64,
    /// Their damping.
    pub damping: f64,
}

impl Servo {
    /// The velocity for the next step, of length `time_step` > 0, to `velocity`.
    ///
    /// A wall that touches nothing approaches with the largest speed; with a target of 0 it stays.
    pub fn follow(&mut self, load: &ServoLoad, time_step: f64) {
        let error = (self.target - load.force).clamp(f64::MIN, f64::MAX);
        let resistance = load.stiffness * time_step + load.damping;
        let limit = self.largest_speed;
        if !(resistance > 0.0) {
            self.steady_velocity = 0.0;
            self.velocity = if error == 0.0 {
                0.0
            } else {
                limit.copysign(error)
            };
            return;
        }
        let wanted = self.gain * error / resistance;
        let velocity = wanted + self.steady_velocity;
        self.velocity = velocity.clamp(-limit, limit);
        // What the limit cut off must not be made up for later.
        if velocity == self.velocity {
            // The share of the spring in the resistance, which may be infinite.
            let elastic = 1.0 / (1.0 + load.damping / (load.stiffness * time_step));
            let steady = self.steady_velocity + 0.25 * self.gain * elastic * wanted;
            self.steady_velocity = steady.clamp(-limit, limit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn servo(gain: f64) -> Servo {
        Servo {
            target: 1.0,
            gain,
            largest_speed: 1e3,
            steady_velocity: 0.0,
            velocity: 0.0,
        }
    }

    /// A spring that recedes at a steady speed, with a dashpot beside it.
    #[test]
    fn the_force_on_a_receding_spring_is_the_target() {
        let time_step = 1e-3;
        for gain in [0.01, 0.1, 0.5, 1.0] {
            for (stiffness, damping) in [(50.0, 0.0), (50.0, 0.01), (50.0, 5.0)] {
                let mut servo = servo(gain);
                let (mut wall, mut spring, away) = (0.0, 0.0, 0.3);
                let mut force: f64 = 0.0;
                let mut highest: f64 = 0.0;
                let steps = (200.0 / gain * (1.0 + damping / (stiffness * time_step))) as usize;
                for _ in 0..steps {
                    wall += servo.velocity * time_step;
                    spring += away * time_step;
                    force = stiffness * (wall - spring) + damping * (servo.velocity - away);
                    highest = highest.max(force);
                    let load = ServoLoad {
                        force,
                        stiffness,
                        damping,
                    };
                    servo.follow(&load, time_step);
                }
                println!("gain {gain}, damping {damping}: force {force}, highest {highest}");
                assert!((force - 1.0).abs() < 1e-6, "{gain} {damping}: {force}");
                // of a force that begins at 0, on a spring that recedes already
                assert!(highest < 1.3, "{gain} {damping}: overshoots to {highest}");
            }
        }
    }

    #[test]
    fn no_faster_than_the_largest_speed() {
        let mut servo = servo(0.5);
        servo.largest_speed = 0.25;
        let nothing = ServoLoad {
            force: 0.0,
            stiffness: 0.0,
            damping: 0.0,
        };
        servo.follow(&nothing, 1e-3);
        assert_eq!(servo.velocity, 0.25);
        servo.target = 0.0;
        servo.follow(&nothing, 1e-3);
        assert_eq!(servo.velocity, 0.0);
        let pressed = ServoLoad {
            force: 1e9,
            stiffness: 1.0,
            damping: 0.0,
        };
        for _ in 0..10 {
            servo.follow(&pressed, 1e-3);
            assert_eq!((servo.velocity, servo.steady_velocity), (-0.25, 0.0));
        }
    }
}
