// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts with walls of planes, cylinders, cones and spheres, at rest and in motion, against those of the library's walls.

use crate::device::{near, Device};
use crate::scene::{Scene, STEP, TIME_STEP};
use crate::{laws, ELASTIC, LINEAR, MINDLIN, TOLERANCE, TOTAL, VISCOELASTIC, WHOLE};
use ellgran::contact::Particle;
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::one_particle::MOST_CONTACTS;
use ellgran::walls::{
    compute_wall, End, Motion, ShapeParameters, Side, Wall, WallHistoryLayout, WallInput,
    WallOutput,
};
use ellgran_kernels::contacts::{self, Load};
use ellgran_kernels::shapes::{Ellipsoids, Kind, Spheroids};
use ellgran_kernels::walls::{contacts_with_wall, MovingWall, WallMotion};

const STEPS: usize = 20;

/// The middle of the scenes, whose grains fill a box of about 7.
pub const MIDDLE: Vector3 = Vector3 {
    x: 3.5,
    y: 3.4,
    z: 3.3,
};

/// A shape about the middle.
fn shape(name: &str, side: Side, radii: [f64; 2], ends: End) -> Wall {
    let mut wall = Wall::new();
    add(&mut wall, name, side, radii, ends);
    wall
}

fn add(wall: &mut Wall, name: &str, side: Side, radii: [f64; 2], ends: End) {
    let bounds = match ends {
        End::None if name == "cylinder" => [f64::NEG_INFINITY, f64::INFINITY],
        _ => [-2.5, 2.6],
    };
    let parameters = ShapeParameters {
        point: MIDDLE,
        axis: Vector3::new(0.2, -0.1, 1.0).normalised(),
        radii,
        bounds,
        ends: [ends; 2],
        side,
    };
    wall.add_shape(name, &parameters).unwrap();
}

/// How a wall moves.
#[derive(Clone, Copy)]
pub enum Moves {
    No,
    /// It turns and goes somewhere.
    Yes,
    /// It turns about the shapes' axis and stays where it is.
    AlongItself,
}

impl Moves {
    fn at(self, time: f64) -> Motion {
        let spin = Vector3::new(0.3, -0.2, 0.9);
        let velocity = Vector3::new(0.3, 0.1, -0.2);
        match self {
            Moves::No => Motion::REST,
            Moves::Yes => {
                let half = 0.5 * spin.norm() * time;
                let axis = spin.normalised() * half.sin();
                Motion {
                    origin: MIDDLE,
                    displacement: velocity * time,
                    axes: Motion::axes_of([half.cos(), axis.x, axis.y, axis.z]),
                    velocity,
                    angular_velocity: spin,
                    velocity_change: Vector3::new(-0.02, 0.03, 0.05),
                    angular_velocity_change: Vector3::new(0.04, 0.02, -0.07),
                    along_itself: false,
                }
            }
            Moves::AlongItself => Motion {
                origin: MIDDLE,
                angular_velocity: Vector3::new(0.2, -0.1, 1.0) * 2.0,
                along_itself: true,
                ..Motion::REST
            },
        }
    }
}

/// Steps of a scene beside a wall: how many contacts there were.
fn compare<K: Kind>(words: &str, scene: Scene, wall: Wall, moves: Moves) -> usize {
    let surfaces = wall.surfaces().unwrap();
    let kernel: &mut Kernel<'_> = &mut |k, scene, motion, layout, state, histories| {
        let moving = MovingWall {
            surfaces: &surfaces,
            motion,
            layout,
            wall_type: 1,
        };
        contacts_with_wall::<K>(k, scene, &moving, state, histories).unwrap()
    };
    compare_to::<K>(words, scene, wall, moves, MOST_CONTACTS, kernel)
}

/// The load of a grain: of its number, a scene, the motion of the wall, and the layout of the histories; state and histories.
pub type Kernel<'a> = dyn FnMut(usize, &contacts::Scene<'_>, Motion, WallHistoryLayout, &mut u32, &mut [f64]) -> Load
    + 'a;

/// The same of any kernel, which remembers so many contacts of a grain at most.
pub fn compare_to<K: Kind>(
    words: &str,
    mut scene: Scene,
    mut wall: Wall,
    moves: Moves,
    most: usize,
    kernel: &mut Kernel<'_>,
) -> usize {
    let laws = laws(words);
    let mut device = Device::new(&scene, &laws);
    let on_host = wall.histories(&laws);
    let layout = WallHistoryLayout::new(on_host.history, on_host.records.min(most));
    let count = scene.count();
    let mut states = vec![0u32; count];
    let mut histories = vec![0.0; count * layout.length()];
    let mut others = vec![0.0; count * on_host.length()];
    let mut touching = 0;
    for step in 1..=STEPS {
        scene.start_step();
        device.prepare::<K>(&scene);
        let motion = moves.at(step as f64 * TIME_STEP);
        let radius = |k: usize| scene.semi_axes[k].iter().copied().fold(0.0, f64::max);
        let place = |k: usize| Some((Vector3::from_array(scene.motion.positions[k]), radius(k)));
        let near_wall = wall.find_near(&motion, count, place).to_vec();
        let particles: Vec<Particle> = near_wall.iter().map(|&k| device.particle::<K>(k)).collect();
        let (mut forces, mut torques) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count]);
        let load = compute_wall(
            &mut wall,
            &WallInput {
                laws: &laws,
                wall_type: 1,
                near: &particles,
                motion: &motion,
                step: &STEP,
                instruction_set: InstructionSet::choose().unwrap(),
            },
            &mut WallOutput {
                acts_on: &|_| true,
                histories: &mut others,
                forces: &mut forces,
                torques: &mut torques,
            },
            None,
        )
        .unwrap();
        assert!(load.crowded.is_none() || most > MOST_CONTACTS);
        touching += load.contacts;
        let numbers = WallMotion::from(&motion);
        let motion = Motion::from(&numbers);
        let largest = forces.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let mut contacts = 0;
        for k in 0..count {
            let own = &mut histories[k * layout.length()..(k + 1) * layout.length()];
            let other = &others[k * on_host.length()..(k + 1) * on_host.length()];
            let state = &mut states[k];
            let scene = device.lent(&laws);
            let load = kernel(k, &scene, motion, layout, state, own);
            contacts += *state as usize;
            for c in 0..3 {
                let (f, t) = (load.force.to_array()[c], load.torque.to_array()[c]);
                near(f, forces[k][c], largest, TOLERANCE, "force", k);
                near(t, torques[k][c], largest, TOLERANCE, "torque", k);
            }
            for (a, b) in own.iter().zip(other) {
                near(*a, *b, 1.0 + largest, TOLERANCE, "history", k);
            }
        }
        assert_eq!(contacts, load.contacts);
    }
    touching
}

#[test]
fn cylinders() {
    let scene = Scene::spheroids;
    let tube = || shape("cylinder", Side::OfCentre, [2.9, 0.0], End::None);
    assert!(compare::<Spheroids>(WHOLE, scene(), tube(), Moves::No) > 1000);
    compare::<Spheroids>(ELASTIC, scene(), tube(), Moves::Yes);
    compare::<Spheroids>(LINEAR, scene(), tube(), Moves::AlongItself);
    compare::<Ellipsoids>(MINDLIN, Scene::ellipsoids(), tube(), Moves::Yes);
    compare::<Spheroids>(VISCOELASTIC, Scene::spheres(), tube(), Moves::AlongItself);
    let of_step = Scene {
        of_step: true,
        ..Scene::ellipsoids()
    };
    compare::<Ellipsoids>(WHOLE, of_step, tube(), Moves::Yes);
}

/// With discs, rims and tips.
#[test]
fn ends() {
    for side in [Side::Inside, Side::Outside, Side::OfCentre] {
        for ends in [End::Open, End::Closed] {
            // From within, a grain that is far outside is far behind the wall.
            let radius = if side == Side::Inside { 4.9 } else { 2.4 };
            let drum = shape("cylinder", side, [radius, 0.0], ends);
            let found = compare::<Ellipsoids>(WHOLE, Scene::ellipsoids(), drum, Moves::Yes);
            assert!(found > 100, "{side:?} {ends:?} {found}");
            let funnel = shape("cone", side, [0.0, radius], ends);
            compare::<Spheroids>(TOTAL, Scene::spheroids(), funnel, Moves::No);
            let funnel = shape("cone", side, [radius, 0.6 * radius], ends);
            compare::<Ellipsoids>(MINDLIN, Scene::ellipsoids(), funnel, Moves::AlongItself);
        }
    }
}

#[test]
fn spheres() {
    for side in [Side::Inside, Side::Outside, Side::OfCentre] {
        let ball = || {
            let radius = if side == Side::Inside { 6.4 } else { 2.6 };
            shape("sphere", side, [radius, 0.0], End::None)
        };
        let found = compare::<Ellipsoids>(WHOLE, Scene::ellipsoids(), ball(), Moves::Yes);
        assert!(found > 100, "{side:?} {found}");
        compare::<Spheroids>(MINDLIN, Scene::spheroids(), ball(), Moves::No);
        compare::<Spheroids>(VISCOELASTIC, Scene::spheres(), ball(), Moves::AlongItself);
    }
}

/// Parts of one wall are told apart in the histories.
#[test]
fn several_parts() {
    let mut wall = shape("plane", Side::OfCentre, [0.0; 2], End::None);
    add(&mut wall, "cylinder", Side::OfCentre, [2.0, 0.0], End::None);
    add(&mut wall, "sphere", Side::OfCentre, [2.3, 0.0], End::None);
    let found = compare::<Ellipsoids>(WHOLE, Scene::ellipsoids(), wall, Moves::Yes);
    assert!(found > 1000, "{found}");
}

/// More contacts than there is room for are an error, and leave all as it was.
#[test]
fn too_many_contacts_are_an_error() {
    let mut wall = Wall::new();
    for _ in 0..=MOST_CONTACTS {
        add(&mut wall, "plane", Side::OfCentre, [0.0; 2], End::None);
    }
    let laws = laws(WHOLE);
    let scene = Scene::ellipsoids();
    let mut device = Device::new(&scene, &laws);
    device.prepare::<Ellipsoids>(&scene);
    let surfaces = wall.surfaces().unwrap();
    let layout = WallHistoryLayout::new(laws.layout().length, MOST_CONTACTS);
    let moving = MovingWall {
        surfaces: &surfaces,
        motion: Motion::REST,
        layout,
        wall_type: 1,
    };
    let mut wrong = 0;
    for k in 0..scene.count() {
        let (mut state, mut histories) = (0, vec![0.0; layout.length()]);
        let scene = device.lent(&laws);
        let found =
            contacts_with_wall::<Ellipsoids>(k, &scene, &moving, &mut state, &mut histories);
        assert_eq!(state, 0);
        assert!(histories.iter().all(|x| *x == 0.0));
        wrong += usize::from(found.is_err());
    }
    assert!(wrong > 10, "{wrong}");
}

/// They have kernels of their own.
#[test]
fn triangles_are_no_such_surface() {
    let mut wall = shape("sphere", Side::Inside, [2.0, 0.0], End::None);
    let corner = |x: f64, y: f64| Vector3::new(x, y, 0.0);
    let triangle = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
    wall.add_mesh(ellgran::walls::Mesh::new(vec![triangle]).unwrap());
    assert_eq!(wall.surfaces().unwrap_err(), 1);
}
