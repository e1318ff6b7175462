// SPDX-License-Identifier: MIT OR Apache-2.0
//! The bound of the stable step of grains with many contacts against the step with which small motions about the present state begin to
//! grow, seen by integrating all grains: never above it, and how far below at most. And the step for an error against collisions.

use crate::support::motion::{Motion, Partner, Rigid};
use crate::support::random::Stream;
use crate::support::scene::{
    advance, advance_plane, array, body, laws, position, wall, Felt, Memory, Rotation, Vector,
};
use crate::support::stability::overlapping;
use ellgran::contact::prepare_body;
use ellgran::contact::stable_step::{
    least_stable_step, step_for_error, ContactExtremes, StepContact, SUMS,
};
use ellgran::contact::staged::{StagedContact, WallSurface};
use ellgran::contact::{Body, Laws};
use ellgran::geometry::facet_shares::Share;
use ellgran::vector::Vector3;
use ellgran::walls::MovingPlane;

/// Grains, and planes through which they press.
struct Scene {
    name: String,
    grains: Vec<Body>,
    planes: Vec<MovingPlane>,
}

/// Who meets whom.
#[derive(Clone, Copy)]
enum Meeting {
    Pair(usize, usize),
    Plane(usize, usize),
}

impl Scene {
    fn meetings(&self) -> Vec<Meeting> {
        let count = self.grains.len();
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| Meeting::Pair(i, j)));
        let planes = (0..count)
            .flat_map(|i| (0..self.planes.len()).map(move |plane| Meeting::Plane(i, plane)));
        pairs.chain(planes).collect()
    }

    fn felt(
        &self,
        laws: &Laws,
        meeting: Meeting,
        grain: &dyn Fn(usize) -> Body,
        step: f64,
        memory: &mut Memory,
    ) -> Option<Felt> {
        match meeting {
            Meeting::Pair(i, j) => advance(laws, &grain(i), &grain(j), step, memory),
            Meeting::Plane(i, plane) => {
                advance_plane(laws, &grain(i), &self.planes[plane], step, memory)
            }
        }
    }

    /// The bound, and what is extreme.
    fn bound(&self, laws: &Laws) -> (f64, ContactExtremes) {
        let prepared: Vec<_> = self
            .grains
            .iter()
            .map(|g| prepare_body(g, Some(1)).unwrap())
            .collect();
        let inverse = |k: usize| 1.0 / self.grains[k].mass;
        let mut sums = vec![[0.0; SUMS]; prepared.len()];
        let mut extremes = ContactExtremes::default();
        let law = laws.get(1, 1);
        for meeting in self.meetings() {
            match meeting {
                Meeting::Pair(i, j) => {
                    let pair = [&prepared[i], &prepared[j]];
                    let found = StepContact::of_pair(law, pair, [inverse(i), inverse(j)]).unwrap();
                    if let Some(c) = found {
                        c.add_to_first(&mut sums[i]);
                        c.add_to_second(&mut sums[j]);
                        extremes.add(&c, [i as i64 + 1, j as i64 + 1], [1, 1]);
                    }
                }
                Meeting::Plane(i, plane) => {
                    let p = &self.planes[plane].plane;
                    let surface = WallSurface {
                        point: p.point,
                        normal: p.normal,
                        direction: p.normal.cross(Vector3::new(0.6, 0.5, 0.4)).normalised(),
                        curvatures: [0.0; 2],
                        turning_radii: [f64::INFINITY; 2],
                        velocity: Vector3::ZERO,
                        velocity_change: Vector3::ZERO,
                        share: Share::WHOLE,
                    };
                    if let Some(staged) = StagedContact::of_wall(&prepared[i], &surface) {
                        let c = StepContact::of_wall(
                            law,
                            &prepared[i],
                            &staged,
                            inverse(i),
                            self.grains[i].mass,
                        )
                        .unwrap();
                        c.add_to_first(&mut sums[i]);
                        extremes.add(&c, [i as i64 + 1, 0], [1, 1]);
                    }
                }
            }
        }
        assert!(extremes.touching > 0, "{}", self.name);
        (least_stable_step(&sums).0, extremes)
    }

    /// Whether small motions about the present state grow, all loads of that state held.
    fn grows(&self, laws: &Laws, step: f64) -> bool {
        let meetings = self.meetings();
        let mut memories: Vec<Memory> = meetings.iter().map(|_| Memory::new(laws)).collect();
        let still = |k: usize| self.grains[k];
        let rest: Vec<Option<Felt>> = meetings
            .iter()
            .zip(&mut memories)
            .map(|(m, memory)| {
                let felt = self.felt(laws, *m, &still, 0.0, memory);
                match laws.layout().rests {
                    // What relaxes has come to rest.
                    Some(_) => self.felt(laws, *m, &still, 1e6, memory),
                    None => felt,
                }
            })
            .collect();
        let shallowest = rest
            .iter()
            .flatten()
            .map(|f| f.geometry.penetration)
            .fold(f64::INFINITY, f64::min);
        // So small that what grows a hundred times is small still: an attractive force would be cut off.
        let amplitude = 1e-7 * shallowest / step;
        let mut random = Stream::new(5);
        let mut moving: Vec<Rigid> = self
            .grains
            .iter()
            .map(|g| {
                let mut g = *g;
                let size = g.semi_axes[0];
                for k in 0..3 {
                    g.velocity[k] = amplitude * random.uniform(-1.0, 1.0);
                    g.angular_velocity[k] = amplitude / size * random.uniform(-1.0, 1.0);
                }
                Rigid::new(g)
            })
            .collect();
        let first: Vec<f64> = moving.iter().map(Rigid::kinetic_energy).collect();
        let none = Vector::zeros();
        let mut excess = vec![[none; 2]; moving.len()];
        for _ in 0..300 {
            for half in 0..2 {
                for (grain, [force, torque]) in moving.iter_mut().zip(&excess) {
                    grain.kick(*force, *torque, 0.5 * step);
                }
                if half == 1 {
                    continue;
                }
                for grain in &mut moving {
                    grain.drift(step);
                }
                // Between the steps: a mode that changes its sign in every step has no velocity at their ends.
                if moving
                    .iter()
                    .zip(&first)
                    .any(|(g, e)| g.kinetic_energy() > 1e4 * e)
                {
                    return true;
                }
                excess.fill([none; 2]);
                let now = |k: usize| moving[k].body;
                for ((meeting, memory), rest) in meetings.iter().zip(&mut memories).zip(&rest) {
                    let felt = self.felt(laws, *meeting, &now, step, memory);
                    let (Some(f), Some(r)) = (felt, rest) else {
                        if rest.is_some() {
                            return true;
                        }
                        continue;
                    };
                    let force = f.force - r.force;
                    let (i, j) = match *meeting {
                        Meeting::Pair(i, j) => (i, Some(j)),
                        Meeting::Plane(i, _) => (i, None),
                    };
                    excess[i][0] -= force;
                    excess[i][1] += f.torque_i - r.torque_i;
                    if let Some(j) = j {
                        excess[j][0] += force;
                        excess[j][1] += f.torque_j - r.torque_j;
                    }
                }
            }
        }
        false
    }

    /// The step at which motions begin to grow over the bound, to 2 %.
    fn limit_over_bound(&self, laws: &Laws) -> f64 {
        let (bound, _) = self.bound(laws);
        assert!(bound > 0.0 && bound.is_finite(), "{}", self.name);
        // Modes that a longer step makes unstable may fall between two steps that are tried: from below.
        let mut factor = 0.97;
        while !self.grows(laws, factor * bound) {
            factor *= 1.02;
            assert!(factor < 6.0, "{}: stable at six times the bound", self.name);
        }
        factor / 1.02
    }
}

const LAWS: [(&str, &str); 7] = [
    ("elastic", "hertz 1e7 0.3"),
    (
        "frictional",
        "hertz 1e7 0.3 tangential mindlin 1e9 displacement total",
    ),
    ("restitution", "hertz 1e7 0.3 damping restitution 0.3"),
    (
        "viscous and frictional",
        "nfd 1e7 0.3 1000 1000 tangential tfd 0.5",
    ),
    ("overdamped", "nfd 1e7 0.3 1e5 1e5 tangential tfd 1e9"),
    ("linear", "lsd 60 0.002 tangential linear 40 0.001 1e9"),
    (
        "linear, overdamped",
        "lsd 60 0.2 tangential linear 40 0.1 1e9",
    ),
];

fn grain(semi_axes: [f64; 3], place: Vector, turn: Rotation) -> Body {
    let mut grain = body(semi_axes, place, turn);
    grain.mass = 2500.0 * 4.0 / 3.0 * core::f64::consts::PI * semi_axes.iter().product::<f64>();
    grain
}

/// Overlaps of all contacts here, in units of the small semi-axis: what is linear in them is left out of the bound.
const OVERLAP: f64 = 1e-5;

fn two_grains(aspect: f64, seed: u64) -> Scene {
    let mut random = Stream::new(seed);
    let (a, b) = (random.semi_axes(aspect), random.semi_axes(aspect));
    let first = grain(a.map(|a| 1e-3 * a), Vector::zeros(), random.rotation());
    let size = random.log_uniform(0.3, 3.0);
    let place = random.direction() * (1e-3 * a[0].max(a[1]).max(a[2]));
    let second = grain(b.map(|b| 1e-3 * size * b), place, random.rotation());
    let least = a.iter().chain(&b).fold(f64::INFINITY, |x, y| x.min(*y));
    let (first, second) = overlapping(first, second, OVERLAP * 1e-3 * size.min(1.0) * least);
    Scene {
        name: format!("two grains of aspect ratio up to {aspect}, {seed}"),
        grains: vec![first, second],
        planes: vec![],
    }
}

fn grain_on_planes(aspect: f64, seed: u64, planes: usize) -> Scene {
    let mut random = Stream::new(seed);
    let axes = random.semi_axes(aspect).map(|a| 1e-3 * a);
    let turn = random.rotation();
    let one = grain(axes, Vector::zeros(), turn);
    let least = axes.iter().fold(f64::INFINITY, |x, y| x.min(*y));
    let planes = (0..planes)
        .map(|_| {
            let normal = random.direction();
            let local = turn.inverse_transform_vector(&normal);
            let reach = local.component_mul(&Vector::from(axes)).norm() - OVERLAP * least;
            let mut plane = wall(normal);
            plane.plane.point = Vector3::from_array(array(-normal * reach));
            plane
        })
        .collect();
    Scene {
        name: format!("a grain of aspect ratio up to {aspect} on planes, {seed}"),
        grains: vec![one],
        planes,
    }
}

/// An affine image of a packing of spheres of radius 1 whose centres are these.
fn packing(name: &str, centres: &[Vector], axes: [f64; 3]) -> Scene {
    let turn = Rotation::from_euler_angles(0.3, -0.7, 1.1);
    let stretch = Vector::from(axes) * 1e-3;
    let grains = centres
        .iter()
        .map(|c| {
            let place = turn * c.component_mul(&stretch) * (1.0 - 0.5 * OVERLAP);
            grain(array(stretch), place, turn)
        })
        .collect();
    Scene {
        name: format!("{name}, axes {axes:?}"),
        grains,
        planes: vec![],
    }
}

fn chain(count: usize, axes: [f64; 3]) -> Scene {
    let centres: Vec<Vector> = (0..count).map(|k| Vector::z() * (2.0 * k as f64)).collect();
    packing("chain", &centres, axes)
}

/// A grain and its twelve neighbours in the densest packing.
fn crowd(axes: [f64; 3]) -> Scene {
    let mut centres = vec![Vector::zeros()];
    for [a, b] in [[0, 1], [0, 2], [1, 2]] {
        for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let mut c = Vector::zeros();
            c[a] = signs[0] * 2f64.sqrt();
            c[b] = signs[1] * 2f64.sqrt();
            centres.push(c);
        }
    }
    packing(
        "thirteen grains, the middle one with twelve contacts",
        &centres,
        axes,
    )
}

/// The scenes under all laws: the least and the largest limit over bound.
fn span(scenes: &[Scene], names: &[&str]) -> [f64; 2] {
    let mut span = [f64::INFINITY, 0.0f64];
    for (name, deck) in LAWS
        .iter()
        .filter(|(n, _)| names.is_empty() || names.contains(n))
    {
        let laws = laws(&[deck]);
        let mut of_law = [f64::INFINITY, 0.0f64];
        for scene in scenes {
            let ratio = scene.limit_over_bound(&laws);
            assert!(ratio > 0.96, "{}, {name}: {ratio}", scene.name);
            of_law = [of_law[0].min(ratio), of_law[1].max(ratio)];
        }
        println!(
            "  {name}: limit over bound {:.2} to {:.2}",
            of_law[0], of_law[1]
        );
        span = [span[0].min(of_law[0]), span[1].max(of_law[1])];
    }
    span
}

#[test]
fn two_grains_and_a_grain_on_planes() {
    println!("two grains");
    let scenes: Vec<Scene> = [1.0, 2.0, 10.0]
        .iter()
        .flat_map(|aspect| (0..3).map(|seed| two_grains(*aspect, seed + 10)))
        .collect();
    let [least, most] = span(&scenes, &[]);
    // Overdamped, where steps go with the square of frequencies and ratios are squared, at most. The limit is found to 2 %.
    assert!(least > 0.98 && most < 1.55, "{least} {most}");

    println!("a grain on a plane");
    let scenes: Vec<Scene> = [1.0, 2.0, 10.0]
        .iter()
        .flat_map(|aspect| (0..3).map(|seed| grain_on_planes(*aspect, seed + 20, 1)))
        .collect();
    // One body: nothing is bounded. Overdamped contacts that recede are smaller after Ting, and damp less.
    let [least, most] = span(&scenes, &[]);
    assert!(least > 0.98 && most < 1.2, "{least} {most}");

    println!("a grain in a corner");
    let scenes: Vec<Scene> = [1.0, 3.0, 10.0]
        .iter()
        .map(|aspect| grain_on_planes(*aspect, 31, 3))
        .collect();
    let [least, most] = span(&scenes, &[]);
    assert!(least > 0.98 && most < 1.2, "{least} {most}");
}

/// Springs of rolling and twisting that are stiffer than the contact itself, and dashpots.
#[test]
fn rolling_and_twisting() {
    let scenes: Vec<Scene> = [1.0, 2.0, 5.0]
        .iter()
        .flat_map(|aspect| [two_grains(*aspect, 41), grain_on_planes(*aspect, 42, 1)])
        .collect();
    for deck in [
        "lsd 60 0 rolling sds 600 0 1e9",
        "lsd 60 0 twisting sds 1e-3 0 1e9",
        "lsd 60 0.001 tangential linear 40 0.001 1e9 rolling sds 200 0.01 1e9 twisting sds 1e-4 1e-8 1e9",
        "hertz 1e7 0.3 tangential mindlin 1e9 displacement total twisting marshall",
    ] {
        let laws = laws(&[deck]);
        let mut span = [f64::INFINITY, 0.0f64];
        for scene in &scenes {
            let ratio = scene.limit_over_bound(&laws);
            span = [span[0].min(ratio), span[1].max(ratio)];
        }
        println!("  {deck}: limit over bound {:.2} to {:.2}", span[0], span[1]);
        assert!(span[0] > 0.98 && span[1] < 1.8, "{deck}: {span:?}");
    }
}

/// Relaxing parts stiffer and softer than the static spring, fast and slow beside the oscillation: each is bounded as a spring or as a dashpot.
#[test]
fn memory_of_the_normal_force() {
    let scenes: Vec<Scene> = [1.0, 2.0, 5.0]
        .iter()
        .flat_map(|aspect| [two_grains(*aspect, 41), grain_on_planes(*aspect, 42, 1)])
        .collect();
    for (deck, most) in [
        ("nfd 1e7 0.1 0 1000 viscosity memory", 1.6),
        ("nfd 1e7 0.1 0 1e7 viscosity memory", 1.6),
        ("nfd 1e7 0.45 100 0 viscosity memory", 6.0),
        ("nfd 1e7 0.45 1e6 0 viscosity memory", 6.0),
        (
            "nfd 1e7 0.3 1000 1e6 viscosity memory tangential mindlin 1e9 displacement total",
            6.0,
        ),
        ("nfd 1e7 0.499 1e4 1 viscosity memory", 6.0),
    ] {
        let laws = laws(&[deck]);
        let mut span = [f64::INFINITY, 0.0f64];
        for scene in &scenes {
            let ratio = scene.limit_over_bound(&laws);
            span = [span[0].min(ratio), span[1].max(ratio)];
        }
        println!(
            "  {deck}: limit over bound {:.2} to {:.2}",
            span[0], span[1]
        );
        assert!(span[0] > 0.98 && span[1] < most, "{deck}: {span:?}");
    }
}

#[test]
fn chains_and_a_crowd() {
    // Not tip to tip: such a chain buckles, whatever the step.
    println!("chains of six");
    let scenes = [
        chain(6, [1.0; 3]),
        chain(6, [3.0, 3.0, 1.0]),
        chain(6, [5.0, 1.0, 1.0]),
    ];
    let [least, most] = span(&scenes, &[]);
    assert!(least > 0.98 && most < 1.12, "{least} {most}");

    println!("a crowd");
    let scenes = [crowd([1.0; 3]), crowd([3.0, 1.0, 1.0])];
    let [least, most] = span(
        &scenes,
        &[
            "elastic",
            "frictional",
            "viscous and frictional",
            "overdamped",
        ],
    );
    assert!(least > 0.98 && most < 1.6, "{least} {most}");
}

/// A light grain between two heavy ones, and a heavy one on light ones: the bound does not take the one for the other.
#[test]
fn unequal_masses() {
    let mut scenes = vec![];
    for masses in [[1.0, 1e-3, 1.0], [1e-3, 1.0, 1e-3]] {
        let mut scene = chain(3, [1.0, 1.5, 1.2]);
        for (grain, factor) in scene.grains.iter_mut().zip(masses) {
            grain.mass *= factor;
        }
        scenes.push(scene);
    }
    let [least, most] = span(&scenes, &["elastic", "frictional", "overdamped"]);
    assert!(least > 0.98 && most < 1.3, "{least} {most}");
}

/// What the head of `src/contact/stable_step.rs` derives: an infinite chain of springs has `4 k/m`, and the bound says so.
#[test]
fn the_shortest_wave_of_a_chain() {
    let laws = laws(&["lsd 60 0 conservative no"]);
    let scene = chain(3, [1.0; 3]);
    let (bound, _) = scene.bound(&laws);
    let exact = 2.0 / (4.0 * 60.0 / scene.grains[1].mass).sqrt();
    assert!((bound / exact - 1.0).abs() < 1e-5, "{bound} {exact}");
}

/// The shortest collision passes through the state: along a collision it stays the same.
#[test]
fn the_collision_through_a_contact() {
    for deck in ["hertz 1e7 0.3", "lsd 60 0"] {
        let laws = laws(&[deck]);
        let mut scene = chain(2, [1.0; 3]);
        let speed = 0.05;
        scene.grains[1].velocity = array(position(&scene.grains[0]) - position(&scene.grains[1]))
            .map(|d| d * speed / 2e-3);
        let (_, first) = scene.bound(&laws);
        let (collision, identifiers, _) = first.shortest.unwrap();
        assert_eq!(identifiers, [1, 2]);
        assert!(
            (collision.speed / speed - 1.0).abs() < 1e-3,
            "{collision:?}"
        );
        let mut motion = Motion::new(
            &laws,
            scene.grains[0],
            Partner::Body(Rigid::new(scene.grains[1])),
            collision.time / 2000.0,
        );
        for k in 0..1500 {
            motion.step();
            if k % 100 == 0 {
                let Partner::Body(other) = &motion.j else {
                    unreachable!()
                };
                scene.grains = vec![motion.i.body, other.body];
                let (_, now) = scene.bound(&laws);
                let time = now.shortest.unwrap().0.time;
                // velocities are those of the ends of steps
                assert!(
                    (time / collision.time - 1.0).abs() < 2e-3,
                    "{time} {collision:?}"
                );
            }
        }
        let deepest = scene.bound(&laws).1.deepest.0;
        assert!(deepest > 0.0 && deepest < 0.1, "{deepest}");
    }
}

/// Collisions with the step for an error are right to that error, central and oblique, with the law's rotation and friction to a few
/// times it.
#[test]
fn the_step_for_an_error() {
    for (deck, times) in [
        ("hertz 1e7 0.3", 1.5),
        ("nfd 1e7 0.3 100 100", 1.5),
        ("hertz 1e7 0.3 damping restitution 0.5", 1.5),
        ("lsd 60 0.003", 1.5),
        ("nfd 1e7 0.3 100 100 tangential tfd 0.5", 5.0),
        ("nfd 1e7 0.1 0 1000 viscosity memory", 1.5),
        ("nfd 1e7 0.4 1000 0 viscosity memory", 1.5),
    ] {
        let laws = laws(&[deck]);
        let axes = [1e-3, 1.5e-3, 1e-3];
        let turn = [
            Rotation::from_euler_angles(0.3, 0.4, 0.2),
            Rotation::from_euler_angles(1.3, -0.4, 0.9),
        ];
        let (i, j) = overlapping(
            grain(axes, Vector::zeros(), turn[0]),
            grain(axes, Vector::new(1e-3, 1e-3, 1.5e-3), turn[1]),
            1e-9,
        );
        let speed = 0.1;
        let towards = (position(&i) - position(&j)).normalize();
        let after = |step: f64, wait: f64| {
            let [mut i, mut j] = [i, j];
            let velocity = towards * speed;
            (i.velocity, j.velocity) = (array(velocity * -0.5), array(velocity * 0.5));
            j.position = array(position(&j) - velocity * wait * step);
            let mut motion = Motion::new(&laws, i, Partner::Body(Rigid::new(j)), step);
            let before = motion.kinetic_energy();
            assert!(motion.collide(1_000_000), "{deck}");
            motion.kinetic_energy() / before
        };
        let mut moving = j;
        moving.velocity = array(towards * speed);
        let scene = Scene {
            name: deck.into(),
            grains: vec![i, moving],
            planes: vec![],
        };
        let collision = scene.bound(&laws).1.shortest.unwrap().0;
        let exact = after(collision.time / 40_000.0, 0.5);
        for error in [1e-2, 1e-3] {
            let step = step_for_error(laws.get(1, 1), &collision, error);
            let squares: f64 = (0..16)
                .map(|k| (after(step, 1.0 + (k as f64 + 0.5) / 16.0) - exact).powi(2))
                .sum();
            let found = (squares / 16.0).sqrt();
            println!(
                "{deck}: asked {error:.0e}, T/{:.0}, found {found:.1e}",
                collision.time / step
            );
            assert!(found < times * error, "{deck}: {found} for {error}");
        }
    }
}
