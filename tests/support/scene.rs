// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies, laws and contacts in the words of a deck, results in nalgebra's types.

use ellgran::contact::one_contact;
use ellgran::contact::prepare_body;
use ellgran::contact::{Body, ContactForces, Laws, MotionChange, OneContact, Particle, Step};
use ellgran::force::syntax::parse;
use ellgran::force::{LawParameters, PairLaw};
use ellgran::geometry::Plane;
use ellgran::walls::{one_contact_with_plane, MovingPlane};

pub type Vector = nalgebra::Vector3<f64>;
pub type Rotation = nalgebra::UnitQuaternion<f64>;

pub fn vector(v: ellgran::vector::Vector3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub fn plain(v: Vector) -> ellgran::vector::Vector3 {
    ellgran::vector::Vector3::new(v.x, v.y, v.z)
}

pub fn array(v: Vector) -> [f64; 3] {
    [v.x, v.y, v.z]
}

/// `(w, x, y, z)`.
pub fn quaternion(q: Rotation) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

pub fn rotation(q: [f64; 4]) -> Rotation {
    Rotation::from_quaternion(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]))
}

/// A body at rest, of type 1 and mass 1.
pub fn body(semi_axes: [f64; 3], position: Vector, turn: Rotation) -> Body {
    Body {
        position: array(position),
        quaternion: quaternion(turn),
        semi_axes,
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
        mass: 1.0,
        particle_type: 1,
        identifier: 1,
    }
}

pub fn position(b: &Body) -> Vector {
    Vector::from(b.position)
}

/// Sum of the largest semi-axes: the scale of rounding errors of a length.
pub fn size(i: &Body, j: &Body) -> f64 {
    let largest = |b: &Body| b.semi_axes.into_iter().fold(0.0, f64::max);
    largest(i) + largest(j)
}

/// The words of a deck, all of them read.
pub fn parameters(deck: &str) -> LawParameters {
    let words: Vec<&str> = deck.split_whitespace().collect();
    let (parameters, read) = parse(&words).unwrap_or_else(|e| panic!("{deck}: {e}"));
    assert_eq!(read, words.len(), "{deck}");
    parameters
}

pub fn pair_law(deck: &str) -> PairLaw {
    let p = parameters(deck);
    PairLaw::resolve(&p, &p).unwrap()
}

/// One deck per type; unlike types are mixed.
pub fn laws(decks: &[&str]) -> Laws {
    let n = decks.len();
    let mut table = vec![None; n * n];
    for (k, deck) in decks.iter().enumerate() {
        table[k * n + k] = Some(parameters(deck));
    }
    Laws::new(n, &table, true).unwrap()
}

/// What a pair remembers.
#[derive(Clone, Debug)]
pub struct Memory {
    pub touching: bool,
    pub history: Vec<f64>,
}

impl Memory {
    pub fn new(laws: &Laws) -> Self {
        Memory {
            touching: false,
            history: vec![0.0; laws.layout().length],
        }
    }
}

/// A touching pair.
#[derive(Clone, Copy, Debug)]
pub struct Felt {
    pub geometry: OneContact,
    pub forces: ContactForces,
    /// On `j`.
    pub force: Vector,
    pub torque_i: Vector,
    pub torque_j: Vector,
    /// On `j`.
    pub tangential: Vector,
    pub normal: Vector,
    pub contact_point: Vector,
}

fn felt((geometry, forces): (OneContact, ContactForces)) -> Felt {
    Felt {
        geometry,
        forces,
        force: vector(forces.force),
        torque_i: vector(forces.torque_i),
        torque_j: vector(forces.torque_j),
        tangential: vector(forces.tangential_force),
        normal: vector(geometry.normal),
        contact_point: vector(geometry.contact_point),
    }
}

/// One contact with memory; `time_step` 0 leaves the history where it is.
pub fn advance(
    laws: &Laws,
    i: &Body,
    j: &Body,
    time_step: f64,
    memory: &mut Memory,
) -> Option<Felt> {
    advance_at_step(laws, (i, None), (j, None), time_step, memory)
}

/// The same where the motions at the step are known: the bodies have those of the half step.
pub fn advance_at_step(
    laws: &Laws,
    i: (&Body, Option<MotionChange>),
    j: (&Body, Option<MotionChange>),
    time_step: f64,
    memory: &mut Memory,
) -> Option<Felt> {
    let [i, j] = [i, j].map(|(body, change)| Particle {
        change,
        ..prepare_body(body, Some(laws.types())).unwrap()
    });
    one_contact::one_contact(
        laws,
        &i,
        &j,
        &step(time_step),
        &mut memory.touching,
        &mut memory.history,
    )
    .unwrap()
    .map(felt)
}

/// One contact of a pair that never met before, with time standing still.
pub fn touch(laws: &Laws, i: &Body, j: &Body) -> Option<Felt> {
    advance(laws, i, j, 0.0, &mut Memory::new(laws))
}

/// The plane through the origin with this normal, at rest.
pub fn wall(normal: Vector) -> MovingPlane {
    MovingPlane {
        plane: Plane {
            point: plain(Vector::zeros()),
            normal: plain(normal),
        },
        velocity: plain(Vector::zeros()),
        velocity_change: plain(Vector::zeros()),
    }
}

/// One contact with a plane of type 1.
pub fn advance_plane(
    laws: &Laws,
    i: &Body,
    plane: &MovingPlane,
    time_step: f64,
    memory: &mut Memory,
) -> Option<Felt> {
    advance_plane_at_step(laws, (i, None), plane, time_step, memory)
}

/// The same where the motion at the step is known.
pub fn advance_plane_at_step(
    laws: &Laws,
    (i, change): (&Body, Option<MotionChange>),
    plane: &MovingPlane,
    time_step: f64,
    memory: &mut Memory,
) -> Option<Felt> {
    let i = Particle {
        change,
        ..prepare_body(i, Some(laws.types())).unwrap()
    };
    one_contact_with_plane(
        laws,
        &i,
        plane,
        1,
        &step(time_step),
        &mut memory.touching,
        &mut memory.history,
    )
    .unwrap()
    .map(felt)
}

/// Geometry, touching or not, contact point halfway.
pub fn geometry(i: &Body, j: &Body) -> OneContact {
    one_contact::geometry(
        &prepare_body(i, None).unwrap(),
        &prepare_body(j, None).unwrap(),
        0.5,
        None,
    )
}

fn step(time_step: f64) -> Step {
    Step {
        time_step,
        advance_history: time_step > 0.0,
    }
}

/// The scale of a contact's force: its own size, or that of the elastic part where they nearly cancel.
pub fn force_scale(f: &Felt) -> f64 {
    let elastic = 2.5 * f.forces.elastic_energy / f.geometry.penetration;
    f.force.norm().max(elastic)
}

/// Largest difference of force and torques, relative to the force and to the force times `arm`.
pub fn difference(f: &Felt, force: Vector, torque_i: Vector, torque_j: Vector, arm: f64) -> f64 {
    let scale = force_scale(f);
    let torque = (f.torque_i - torque_i)
        .norm()
        .max((f.torque_j - torque_j).norm());
    ((f.force - force).norm() / scale).max(torque / (scale * arm))
}

/// What rounding of coordinates of this size does to a force at this penetration, relative; `sharpness` is size over the
/// smallest radius of curvature.
pub fn rounding(size: f64, penetration: f64, sharpness: f64) -> f64 {
    f64::EPSILON * (32.0 * size / penetration + 256.0 * sharpness + 256.0)
}

/// The same for the law of a deck: the viscous part of `tfd` goes with the square root of what is left until it slides, and
/// so do the errors.
pub fn rounding_of(deck: &str, rounding: f64) -> f64 {
    let viscous = deck.contains("nfd") || deck.contains("relaxation");
    if viscous && deck.contains("tfd") {
        rounding.sqrt()
    } else {
        rounding
    }
}
