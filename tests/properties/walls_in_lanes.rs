// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do walls give the same on every instruction set? Grains at each kind of surface, at rest and in motion, in two steps, so that what
//! is remembered counts.

use crate::support::random::Stream;
use crate::support::scene::{body, laws, plain, Vector};
use ellgran::contact::{prepare_body, Body, Laws, MotionChange, Particle, Step};
use ellgran::simd::InstructionSet;
use ellgran::tallies::Tallies;
use ellgran::vector::Vector3;
use ellgran::walls::{
    compute_wall, End, Mesh, Motion, ShapeParameters, Side, Wall, WallInput, WallOutput,
};

/// Deeper contacts are left out: there Hertz' law has ended.
const DEEPEST: f64 = 0.05;
const TIME_STEP: f64 = 1e-3;
/// By which share of the largest number of its kind a result may be off: rounding, times what a curvature of aspect ratio 5 makes
/// of it.
const TOLERANCE: f64 = 1e-11;

const RADIUS: f64 = 6.0;

fn shape(name: &str, side: Side) -> Wall {
    let mut wall = Wall::new();
    let bounds = if name == "cylinder" {
        [f64::NEG_INFINITY, f64::INFINITY]
    } else {
        [-2.0 * RADIUS, 2.0 * RADIUS]
    };
    wall.add_shape(name, &parameters(side, bounds, [End::None; 2]))
        .unwrap();
    wall
}

fn parameters(side: Side, bounds: [f64; 2], ends: [End; 2]) -> ShapeParameters {
    ShapeParameters {
        point: Vector3::ZERO,
        axis: Vector3::new(0.0, 0.6, 0.8),
        radii: [RADIUS, 0.5 * RADIUS],
        bounds,
        ends,
        side,
    }
}

/// A cylinder that is closed at both ends, grains within; or two discs and a cylinder with an edge at one end, which act on both sides.
fn drum(side: Side, ends: [End; 2]) -> Wall {
    let mut wall = Wall::new();
    let parameters = parameters(side, [-0.8 * RADIUS, 0.7 * RADIUS], ends);
    wall.add_shape("cylinder", &parameters).unwrap();
    wall
}

/// A floor with a step in it: faces, a fold, an edge, free edges and corners.
fn stairs() -> Wall {
    let p = Vector3::new;
    let face = |a: Vector3, u: Vector3, v: Vector3| [[a, a + u, a + u + v], [a, a + u + v, a + v]];
    let (wide, high, deep) = (p(0.0, 6.0, 0.0), p(0.0, 0.0, 2.0), p(4.0, 0.0, 0.0));
    let at = |x: f64, z: f64| p(x, -3.0, z);
    let faces = [
        face(at(-4.0, 0.0), deep, wide),
        face(at(0.0, 0.0), high, wide),
        face(at(0.0, 2.0), deep, wide),
    ];
    let mut wall = Wall::new();
    wall.add_mesh(Mesh::new(faces.concat()).unwrap());
    wall
}

/// An inclined floor of triangles about as large as grains, the corners without rounding.
fn sheet() -> Wall {
    let at = |i: i32, j: i32| {
        let [x, y] = [i, j].map(f64::from);
        Vector3::new(x, y, 0.5 * x - 0.25 * y)
    };
    let mut triangles = vec![];
    for i in -8..8 {
        for j in -8..8 {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let mut wall = Wall::new();
    wall.add_mesh(Mesh::new(triangles).unwrap());
    wall
}

/// A block from without, larger than a grain: most of them touch one face, some are within it.
fn block() -> Wall {
    let mut wall = Wall::new();
    wall.add_block([-4.0, -5.0, -6.0], [4.0, 5.0, 4.0]).unwrap();
    wall
}

/// A place in the frame of the wall from where a grain touches two parts of a surface, or two faces of it, if it is one of those that
/// have such places.
pub fn corner(surface: &str, stream: &mut Stream) -> Option<Vector3> {
    let [a, b, c] = [0; 3].map(|_| stream.uniform(0.2, 1.2));
    match surface {
        "within a drum" => {
            let axis = Vector3::new(0.0, 0.6, 0.8);
            let across = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 0.8, -0.6)];
            let (sin, cos) = (5.0 * c).sin_cos();
            let outwards = across[0] * cos + across[1] * sin;
            Some(axis * (0.7 * RADIUS - a) + outwards * (RADIUS - b))
        }
        "stairs" => Some(Vector3::new(-a, 2.0 * c - 1.0, b)),
        _ => None,
    }
}

/// The names of all kinds of surfaces, and a wall of each.
pub fn surfaces() -> Vec<(&'static str, Wall)> {
    vec![
        ("plane", shape("plane", Side::Inside)),
        ("within a cylinder", shape("cylinder", Side::Inside)),
        ("outside a cylinder", shape("cylinder", Side::Outside)),
        ("within a cone", shape("cone", Side::Inside)),
        ("outside a cone", shape("cone", Side::Outside)),
        ("within a sphere", shape("sphere", Side::Inside)),
        ("outside a sphere", shape("sphere", Side::Outside)),
        ("stairs", stairs()),
        ("sheet", sheet()),
        ("outside a block", block()),
        ("within a drum", drum(Side::Inside, [End::Closed; 2])),
        ("at a cup", drum(Side::OfCentre, [End::Closed, End::Open])),
    ]
}

/// At rest; turned, in motion; and moving along itself.
pub fn motions() -> [Motion; 3] {
    let moving = Motion {
        origin: Vector3::new(0.3, -0.2, 0.1),
        displacement: Vector3::new(0.2, 0.1, -0.3),
        axes: Motion::axes_of([0.9, 0.1, -0.3, 0.2]),
        velocity: Vector3::new(0.3, -0.1, 0.2),
        angular_velocity: Vector3::new(0.2, 0.1, -0.4),
        velocity_change: Vector3::new(0.06, 0.02, -0.05),
        angular_velocity_change: Vector3::new(-0.07, 0.03, 0.04),
        along_itself: false,
    };
    let along_itself = Motion {
        displacement: Vector3::ZERO,
        axes: None,
        along_itself: true,
        ..moving
    };
    [Motion::REST, moving, along_itself]
}

/// The same, and whether particles come with a change.
pub fn motions_and_changes() -> [(Motion, bool); 4] {
    let [rest, moving, along_itself] = motions();
    [
        (rest, true),
        (moving, false),
        (moving, true),
        (along_itself, true),
    ]
}

/// A body somewhere about the surfaces, of one of these types.
pub fn random_body(stream: &mut Stream, types: usize) -> Body {
    let semi_axes = stream.semi_axes(5.0);
    let place = Vector::from_fn(|_, _| stream.uniform(-1.3 * RADIUS, 1.3 * RADIUS));
    let mut b = body(semi_axes, place, stream.rotation());
    b.particle_type = 1 + (stream.uniform(0.0, types as f64) as i32).min(types as i32 - 1);
    b.velocity = stream.direction().into();
    b.angular_velocity = stream.direction().into();
    b
}

pub fn random_change(stream: &mut Stream) -> MotionChange {
    MotionChange {
        velocity: plain(stream.direction() * 0.1),
        omega: plain(stream.direction() * 0.1),
    }
}

/// Numbers in groups of one kind, each group by its name.
pub type Groups = Vec<(&'static str, Vec<f64>)>;

/// Holds groups of numbers to the expected ones: to [`TOLERANCE`] of the largest of each group.
pub fn assert_same(what: &str, found: &Groups, expected: &Groups) {
    for ((name, a), (_, b)) in found.iter().zip(expected) {
        let largest = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert_eq!(a.len(), b.len(), "{what}: {name}");
        for (a, b) in a.iter().zip(b) {
            let apart = (a - b).abs();
            assert!(
                apart <= TOLERANCE * largest,
                "{what}: {name} {a:e} and {b:e}"
            );
        }
    }
}

/// What one instruction set makes of the particles, number by number, in groups of one kind.
struct Result {
    groups: Groups,
    contacts: usize,
}

fn advance(
    set: InstructionSet,
    wall: &mut Wall,
    laws: &Laws,
    motion: &Motion,
    particles: &[Particle],
) -> Result {
    let length = wall.histories(laws).length();
    let mut histories = vec![0.0; particles.len() * length];
    let (mut forces, mut torques) = (
        vec![[0.0; 3]; particles.len()],
        vec![[0.0; 3]; particles.len()],
    );
    let mut tallies = Tallies::default();
    let mut particles = particles.to_vec();
    let mut load = Default::default();
    for _ in 0..2 {
        let balls = |k: usize| Some((particles[k].position, particles[k].radius));
        let near = wall.find_near(motion, particles.len(), balls).to_vec();
        let near: Vec<Particle> = near.iter().map(|k| particles[*k]).collect();
        load = compute_wall(
            wall,
            &WallInput {
                laws,
                wall_type: 1,
                near: &near,
                motion,
                step: &Step {
                    time_step: TIME_STEP,
                    advance_history: true,
                },
                instruction_set: set,
            },
            &mut WallOutput {
                acts_on: &|_| true,
                histories: &mut histories,
                forces: &mut forces,
                torques: &mut torques,
            },
            Some(&mut tallies),
        )
        .unwrap();
        for p in &mut particles {
            p.position = p.position + p.velocity * TIME_STEP;
        }
    }
    let record = |of: fn(&ellgran::walls::RecordedWallContact) -> Vec<f64>| {
        wall.contacts().iter().flat_map(of).collect::<Vec<f64>>()
    };
    // What is remembered of a grain begins with a count; points, normals, memories and energies are of different sizes.
    let layout = laws.layout();
    let mut groups = vec![
        ("force", forces.concat()),
        ("torque", torques.concat()),
        (
            "load",
            [load.force, load.torque].map(|v| v.to_array()).concat(),
        ),
        ("springs", vec![load.stiffness]),
        ("penetration", record(|c| vec![c.penetration])),
        ("point", record(|c| c.point.to_array().into())),
        (
            "viscous force",
            record(|c| c.forces.viscous_force.to_array().into()),
        ),
        (
            "frictional force",
            record(|c| c.forces.frictional_force.to_array().into()),
        ),
        (
            "tangential force",
            record(|c| c.forces.tangential_force.to_array().into()),
        ),
        ("elastic energy", record(|c| vec![c.forces.elastic_energy])),
        (
            "tangential energy",
            record(|c| vec![c.forces.tangential_energy]),
        ),
        (
            "powers",
            record(|c| vec![c.forces.viscous_power, c.forces.tangential_power]),
        ),
        ("dissipation", vec![tallies.viscous_dissipation]),
        ("work", vec![tallies.tangential_work]),
    ];
    if length > 0 {
        let record = wall.histories(laws).record;
        let head = record - layout.length;
        let records: Vec<&[f64]> = histories
            .chunks_exact(length)
            .flat_map(|h| h[1..1 + h[0] as usize * record].chunks_exact(record))
            .collect();
        let part = |range: std::ops::Range<usize>| {
            records
                .iter()
                .flat_map(|r| r[range.clone()].to_vec())
                .collect::<Vec<f64>>()
        };
        let at = head + layout.memory.unwrap();
        groups.push(("place and normal", part(0..head)));
        groups.push(("memory", part(at..at + 3)));
        if let Some(energy) = layout.energy {
            groups.push((
                "energy of the memory",
                part(head + energy..head + energy + 1),
            ));
        }
    }
    Result {
        groups,
        contacts: load.contacts,
    }
}

/// Grains that touch in at least so many places, none of them deep, of those that `random` gives; the wall records its contacts.
pub fn touching<T>(
    wall: &mut Wall,
    motion: &Motion,
    (types, least): (usize, usize),
    mut random: impl FnMut() -> (T, Particle),
) -> Vec<T> {
    let elastic = laws(&vec!["hertz 1e3 0.3"; types]);
    (0..60_000)
        .filter_map(|_| {
            let (grain, particle) = random();
            let one = [particle];
            let ball = |_: usize| Some((one[0].position, one[0].radius));
            if wall.find_near(motion, 1, ball).is_empty() {
                return None;
            }
            advance(InstructionSet::Scalar, wall, &elastic, motion, &one);
            let contacts = wall.contacts();
            let shallow = contacts.iter().all(|c| c.penetration < DEEPEST);
            (contacts.len() >= least && shallow).then_some(grain)
        })
        .take(60)
        .collect()
}

#[test]
fn every_instruction_set_gives_the_numbers_of_one_contact_at_a_time() {
    let full = "nfd 1e3 0.3 0.5 0.5 tangential tfd 0.5";
    let smooth = "hertz 1e3 0.3 damping relaxation 0.01 tangential mindlin 0.5";
    let scenes = [
        ("full law", laws(&[full])),
        ("elastic", laws(&["hertz 1e3 0.3 conservative yes"])),
        (
            "spheres' law",
            laws(&[
                "hertz 1e3 0.3 damping restitution 0.7 tangential mindlin 0.5 displacement total",
            ]),
        ),
        ("three materials, one without friction", {
            laws(&[smooth; 3])
                .with_friction(&[0.5, 0.0, 0.2, 0.0, 0.5, 0.5, 0.2, 0.5, 0.5])
                .unwrap()
        }),
        (
            "with what resists rolling",
            laws(&["hertz 1e3 0.3 tangential mindlin 0.5 rolling sds 30 0.3 0.5"]),
        ),
        (
            "springs of partial slip",
            laws(&["nfd 1e3 0.3 0.5 0.5 tangential tfd 0.5 displacement hysteretic"]),
        ),
    ];
    let mut stream = Stream::new(17);
    for (surface, mut wall) in surfaces() {
        wall.records_contacts = true;
        for (scene, laws) in &scenes {
            for (motion, of_step) in &motions_and_changes() {
                let of_step = *of_step;
                let types = laws.types();
                let particles = touching(&mut wall, motion, (types, 1), || {
                    let mut particle =
                        prepare_body(&random_body(&mut stream, types), Some(types)).unwrap();
                    particle.change = of_step.then(|| random_change(&mut stream));
                    (particle, particle)
                });
                assert!(particles.len() > 30, "{surface}: {}", particles.len());
                let one = advance(InstructionSet::Scalar, &mut wall, laws, motion, &particles);
                for set in InstructionSet::ALL.into_iter().filter(|s| s.is_available()) {
                    let all = advance(set, &mut wall, laws, motion, &particles);
                    let what = format!("{surface}, {scene}, {}", set.name());
                    assert_eq!(all.contacts, one.contacts, "{what}");
                    assert_same(&what, &all.groups, &one.groups);
                }
            }
        }
    }
}
