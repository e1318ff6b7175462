// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which pairs of bodies are tried: random ones, and ones made to be hard.

use crate::support::random::Stream;
use crate::support::scene::{body, quaternion, rotation, size, Rotation, Vector};
use ellgran::contact::Body;
use ellgran::geometry::ellipsoid::{LARGEST_SEMI_AXIS, LEAST_SEMI_AXIS};

/// A pair, and the length by which it may move in a step without leaving its contact.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    pub i: Body,
    pub j: Body,
    pub depth: f64,
}

/// What makes the pairs of a block hard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Family {
    AnyShape,
    Needles,
    Discs,
    Spheres,
    SizeRatio,
    Overlap,
    CoincidentCentres,
    Parallel,
    Crossed,
    TipToTip,
    NearlySpherical,
    CurvatureRatio,
    Quaternions,
    Units,
}

impl Family {
    pub const ALL: [Family; 14] = [
        Family::AnyShape,
        Family::Needles,
        Family::Discs,
        Family::Spheres,
        Family::SizeRatio,
        Family::Overlap,
        Family::CoincidentCentres,
        Family::Parallel,
        Family::Crossed,
        Family::TipToTip,
        Family::NearlySpherical,
        Family::CurvatureRatio,
        Family::Quaternions,
        Family::Units,
    ];

    /// As the table names it.
    pub fn name(self) -> &'static str {
        match self {
            Family::AnyShape => "any shape, aspect ratio to 1000",
            Family::Needles => "needles, aspect ratio to 1000",
            Family::Discs => "discs, aspect ratio to 1000",
            Family::Spheres => "spheres, size ratio to 1e4",
            Family::SizeRatio => "size ratio to 1e4",
            Family::Overlap => "overlap from 1e-15 to complete",
            Family::CoincidentCentres => "centres coincident or nearly so",
            Family::Parallel => "exactly parallel axes",
            Family::Crossed => "axes crossed at right angles",
            Family::TipToTip => "tip to tip and rim to rim",
            Family::NearlySpherical => "nearly spherical, 1e-16 to 1e-6",
            Family::CurvatureRatio => "B/A to 1e10",
            Family::Quaternions => "quaternions of any length",
            Family::Units => "lengths from 1e-19 to 1e19",
        }
    }

    /// One pair at rest. `revolution`: of bodies of revolution alone, which have a closed form of their own in a list.
    pub fn draw(self, stream: &mut Stream, revolution: bool) -> Drawn {
        let mut shapes = Shapes { stream, revolution };
        match self {
            Family::AnyShape => {
                let bodies = [shapes.any(1000.0), shapes.any(1000.0)];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-6, 1.0);
                shapes.touching(bodies, depth)
            }
            Family::Needles => {
                let bodies = [shapes.needle(1000.0), shapes.needle(1000.0)];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-6, 1.0);
                shapes.touching(bodies, depth)
            }
            Family::Discs => {
                let bodies = [shapes.disc(1000.0), shapes.disc(1000.0)];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-6, 1.0);
                shapes.touching(bodies, depth)
            }
            Family::Spheres => {
                let mut sphere = || [shapes.stream.log_uniform(1e-4, 1.0); 3];
                let bodies = [sphere(), sphere()];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-12, 2.0);
                shapes.touching(bodies, depth)
            }
            Family::SizeRatio => {
                let ratio = shapes.stream.log_uniform(1e-4, 1.0);
                let bodies = [shapes.any(10.0), shapes.any(10.0).map(|a| a * ratio)];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-6, 1.0);
                shapes.touching(bodies, depth)
            }
            Family::Overlap => {
                let bodies = [shapes.any(10.0), shapes.any(10.0)];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-15, 2.0);
                shapes.touching(bodies, depth)
            }
            Family::CoincidentCentres => shapes.coincident(),
            Family::Parallel => shapes.aligned(Rotation::identity()),
            Family::Crossed => {
                let axis = (shapes.stream.uniform(0.0, 3.0) as usize).min(2);
                let mut turn = [1.0, 0.0, 0.0, 0.0];
                turn[1 + axis] = 1.0;
                shapes.aligned(rotation(turn))
            }
            Family::TipToTip => shapes.tip_to_tip(),
            Family::NearlySpherical => {
                let near = shapes.stream.log_uniform(1e-16, 1e-6);
                let mut one = || {
                    let radius = shapes.stream.log_uniform(0.1, 1.0);
                    let mut a = [radius; 3];
                    for a in &mut a {
                        *a *= 1.0 + near * shapes.stream.uniform(-1.0, 1.0);
                    }
                    if revolution {
                        a[1] = a[0];
                    }
                    a
                };
                let bodies = [one(), one()];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-12, 2.0);
                shapes.touching(bodies, depth)
            }
            Family::CurvatureRatio => shapes.side_by_side(),
            Family::Quaternions => {
                let bodies = [shapes.any(10.0), shapes.any(10.0)];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-6, 1.0);
                let mut drawn = shapes.touching(bodies, depth);
                for body in [&mut drawn.i, &mut drawn.j] {
                    let length = shapes.stream.log_uniform(1e-307, 1e307);
                    body.quaternion = body.quaternion.map(|q| q * length);
                }
                drawn
            }
            Family::Units => {
                let bodies = [shapes.any(1000.0), shapes.any(1000.0)];
                let depth = smallest(bodies) * shapes.stream.log_uniform(1e-6, 1.0);
                let mut drawn = shapes.touching(bodies, depth);
                // Both semi-axes and centres stay in range.
                let unit = shapes.stream.log_uniform(1e-16, 1e19);
                drawn.depth *= unit;
                for body in [&mut drawn.i, &mut drawn.j] {
                    body.semi_axes = body
                        .semi_axes
                        .map(|a| (a * unit).clamp(LEAST_SEMI_AXIS, LARGEST_SEMI_AXIS));
                    body.position = body.position.map(|x| x * unit);
                }
                drawn
            }
        }
    }
}

fn smallest(bodies: [[f64; 3]; 2]) -> f64 {
    bodies.concat().into_iter().fold(f64::INFINITY, f64::min)
}

struct Shapes<'a> {
    stream: &'a mut Stream,
    revolution: bool,
}

impl Shapes<'_> {
    fn any(&mut self, aspect: f64) -> [f64; 3] {
        let mut a = self.stream.semi_axes(aspect);
        if self.revolution {
            // Prolate and oblate ones: two of the three are equal.
            let k = (self.stream.uniform(0.0, 3.0) as usize).min(2);
            a[k] = a[(k + 1) % 3];
        }
        a
    }

    fn needle(&mut self, aspect: f64) -> [f64; 3] {
        let thin = self.stream.log_uniform(1.0 / aspect, 1.0);
        let other = if self.revolution {
            thin
        } else {
            thin * self.stream.log_uniform(1.0, 2.0f64.min(1.0 / thin))
        };
        [1.0, thin, other]
    }

    fn disc(&mut self, aspect: f64) -> [f64; 3] {
        let thin = self.stream.log_uniform(1.0 / aspect, 1.0);
        let other = if self.revolution {
            1.0
        } else {
            self.stream.log_uniform(0.5f64.max(thin), 1.0)
        };
        [1.0, other, thin]
    }

    /// Two bodies that turn anyhow, and whose surfaces overlap by this along a common normal. Half of the normals are spread
    /// evenly over the surface of a body that is stretched to a ball: flat sides are not met by chance.
    fn touching(&mut self, [a, b]: [[f64; 3]; 2], depth: f64) -> Drawn {
        let i = body(a, Vector::zeros(), self.stream.rotation());
        let j = body(b, Vector::zeros(), self.stream.rotation());
        let n = self.stream.direction();
        let n = if self.stream.uniform(0.0, 1.0) < 0.5 {
            n
        } else {
            (rotation(i.quaternion) * n.component_div(&Vector::from(a))).normalize()
        };
        along(i, j, n, depth)
    }

    fn coincident(&mut self) -> Drawn {
        let a = self.any(1000.0);
        let same = self.stream.uniform(0.0, 1.0) < 0.5;
        let b = if same { a } else { self.any(1000.0) };
        let turn = self.stream.rotation();
        let other = if self.stream.uniform(0.0, 1.0) < 0.3 {
            turn
        } else {
            self.stream.rotation()
        };
        let i = body(a, Vector::zeros(), turn);
        let mut j = body(b, Vector::zeros(), other);
        let apart = match self.stream.uniform(0.0, 4.0) as usize {
            0 => 0.0,
            // Denormal, too.
            1 => self.stream.log_uniform(1e-300, 1e-30) * 1e-20,
            _ => self.stream.log_uniform(1e-30, 1e-2),
        };
        j.position = (self.stream.direction() * apart).into();
        let depth = smallest([a, b]);
        Drawn { i, j, depth }
    }

    /// Two bodies of which one is turned against the other by `turn` exactly, one above the other along one of their axes, or
    /// along any direction.
    fn aligned(&mut self, turn: Rotation) -> Drawn {
        let a = self.any(1000.0);
        let same = self.stream.uniform(0.0, 1.0) < 0.5;
        let b = if same { a } else { self.any(1000.0) };
        // Half of them along the axes of the world, where products are exact.
        let common = if self.stream.uniform(0.0, 1.0) < 0.5 {
            Rotation::identity()
        } else {
            self.stream.rotation()
        };
        let i = body(a, Vector::zeros(), common);
        let mut j = body(b, Vector::zeros(), common * turn);
        if turn == Rotation::identity() {
            j.quaternion = i.quaternion;
        }
        let k = self.stream.uniform(0.0, 4.0) as usize;
        let n = if k < 3 {
            common * Vector::ith(k, 1.0)
        } else {
            self.stream.direction()
        };
        let depth = smallest([a, b]) * self.stream.log_uniform(1e-12, 2.0);
        along(i, j, n, depth)
    }

    /// The ends of the longest axes against each other, on one line or a little off it.
    fn tip_to_tip(&mut self) -> Drawn {
        let mut one = || {
            if self.stream.uniform(0.0, 1.0) < 0.5 {
                self.needle(1000.0)
            } else {
                self.disc(1000.0)
            }
        };
        let [a, b] = [one(), one()];
        let common = if self.stream.uniform(0.0, 1.0) < 0.5 {
            Rotation::identity()
        } else {
            self.stream.rotation()
        };
        let axis = common * Vector::x();
        // About the common axis: rims lie in one plane, or cross.
        let roll = match self.stream.uniform(0.0, 3.0) as usize {
            0 => 0.0,
            1 => std::f64::consts::FRAC_PI_2,
            _ => self.stream.uniform(0.0, std::f64::consts::PI),
        };
        let i = body(a, Vector::zeros(), common);
        let mut j = body(
            b,
            Vector::zeros(),
            Rotation::from_scaled_axis(axis * roll) * common,
        );
        // The radius of curvature of the tips is the scale of what they can overlap.
        let radius = [a, b].map(|a| (a[1] * a[1]).min(a[2] * a[2]) / a[0]);
        let depth = radius[0].min(radius[1]) * self.stream.log_uniform(1e-6, 10.0);
        let off = if self.stream.uniform(0.0, 1.0) < 0.5 {
            0.0
        } else {
            self.stream.log_uniform(1e-17, 1e-3)
        };
        let beside = common * Vector::new(0.0, 1.0, 0.3);
        j.position = (axis * (a[0] + b[0] - depth) + beside * off).into();
        Drawn { i, j, depth }
    }

    /// Long flanks on each other: `B/A` is the square of the aspect ratio.
    fn side_by_side(&mut self) -> Drawn {
        let thin = self.stream.log_uniform(1e-5, 1e-2);
        let a = if self.revolution {
            [1.0, thin, thin]
        } else {
            [1.0, thin, thin * self.stream.log_uniform(1.0, 2.0)]
        };
        let common = self.stream.rotation();
        let tilt = if self.stream.uniform(0.0, 1.0) < 0.3 {
            0.0
        } else {
            self.stream.log_uniform(1e-12, 1e-1)
        };
        let turn = Rotation::from_scaled_axis(common * Vector::y() * tilt);
        let i = body(a, Vector::zeros(), common);
        let mut j = body(a, Vector::zeros(), turn * common);
        if tilt == 0.0 {
            j.quaternion = quaternion(common);
        }
        let depth = thin * self.stream.log_uniform(1e-6, 0.5);
        along(i, j, common * Vector::y(), depth)
    }
}

/// The surface point with outward normal `n`, from the centre.
pub fn witness(b: &Body, n: &Vector) -> Vector {
    let turn = rotation(b.quaternion);
    let a = Vector::from(b.semi_axes);
    let z = a.component_mul(&(turn.inverse() * n));
    turn * a.component_mul(&z) / z.norm()
}

fn along(i: Body, mut j: Body, n: Vector, depth: f64) -> Drawn {
    let depth = depth.min(size(&i, &j));
    j.position = (witness(&i, &n) + witness(&j, &n) - n * depth).into();
    Drawn { i, j, depth }
}
