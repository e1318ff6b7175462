// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grains in a box, as both engines get them.

use super::shapes::{self, add, scale, Quaternion, Random, Vector, IDENTITY};

/// One grain. Lengths are semi-axes; the angular momentum is in the world frame.
#[derive(Clone, Debug)]
pub struct Grain {
    pub kind: usize,
    pub semi_axes: Vector,
    pub density: f64,
    pub position: Vector,
    pub quaternion: Quaternion,
    pub velocity: Vector,
    pub angular_momentum: Vector,
}

impl Grain {
    pub fn new(semi_axes: Vector, position: Vector) -> Grain {
        Grain {
            kind: 1,
            semi_axes,
            density: 1000.0,
            position,
            quaternion: IDENTITY,
            velocity: [0.0; 3],
            angular_momentum: [0.0; 3],
        }
    }

    pub fn sphere(radius: f64, position: Vector) -> Grain {
        Grain::new([radius; 3], position)
    }

    pub fn turned(mut self, quaternion: Quaternion) -> Grain {
        self.quaternion = quaternion;
        self
    }

    pub fn moving(mut self, velocity: Vector) -> Grain {
        self.velocity = velocity;
        self
    }

    pub fn mass(&self) -> f64 {
        shapes::mass(self.density, self.semi_axes)
    }

    /// Gives the angular velocity (world frame) through the angular momentum.
    pub fn spinning(mut self, angular_velocity: Vector) -> Grain {
        self.angular_momentum = shapes::angular_momentum(
            self.mass(),
            self.semi_axes,
            self.quaternion,
            angular_velocity,
        );
        self
    }
}

/// Grains in a box.
#[derive(Clone, Debug)]
pub struct Scene {
    pub grains: Vec<Grain>,
    pub low: Vector,
    pub high: Vector,
    /// Boundary command, e.g. `f f f` or `p p p`.
    pub boundary: String,
    pub kinds: usize,
}

impl Scene {
    /// Open boundaries, box as wide as told in every direction.
    pub fn open(half_width: f64, grains: Vec<Grain>) -> Scene {
        let kinds = grains.iter().map(|g| g.kind).max().unwrap_or(1);
        Scene {
            grains,
            low: [-half_width; 3],
            high: [half_width; 3],
            boundary: "f f f".into(),
            kinds,
        }
    }

    pub fn periodic(low: Vector, high: Vector, grains: Vec<Grain>) -> Scene {
        let kinds = grains.iter().map(|g| g.kind).max().unwrap_or(1);
        Scene {
            grains,
            low,
            high,
            boundary: "p p p".into(),
            kinds,
        }
    }
}

/// A crowd of ellipsoids in a periodic box, close enough to collide many times.
pub fn crowd(count: usize) -> Scene {
    let mut random = Random(64);
    let side = (1..).find(|n| n * n * n >= count).unwrap();
    let cell = 2.4e-2;
    let mut grains = vec![];
    for k in 0..count {
        let place = [k % side, k / side % side, k / side / side].map(|c| c as f64 + 0.5);
        let jitter: Vector = std::array::from_fn(|_| random.between(-0.05, 0.05));
        let mut axes = [1.5e-2, 1e-2, 0.8e-2];
        axes.rotate_left(k % 3);
        let axes = scale(random.between(0.75, 1.05), axes);
        let grain = Grain {
            density: 2500.0,
            ..Grain::new(axes, scale(cell, add(place, jitter))).turned(random.quaternion())
        };
        let velocity = scale(random.between(0.5, 1.5), random.direction());
        let spin = scale(random.between(5.0, 80.0), random.direction());
        grains.push(grain.moving(velocity).spinning(spin));
    }
    Scene::periodic([0.0; 3], [side as f64 * cell; 3], grains)
}

/// Colliding grains, periodic along y, with room for walls across x and z.
pub fn between_walls() -> Scene {
    let mut scene = crowd(64);
    scene.boundary = "f p f".into();
    for axis in [0, 2] {
        scene.low[axis] -= 0.03;
        scene.high[axis] += 0.03;
    }
    scene
}
