// SPDX-License-Identifier: MIT OR Apache-2.0
//! The kernels, run on the host index by index, against the library's lists in lanes: the same grains, the same laws, step after
//! step.

mod device;
mod meshes;
mod mixed;
mod scene;
mod walls;

use device::Device;
use ellgran::contact::Laws;
use ellgran_kernels::shapes::{Ellipsoids, Kind, Spheres, Spheroids};
use scene::Scene;

/// Of force, torque and history, relative to the largest of the scene.
const TOLERANCE: f64 = 1e-12;
const STEPS: usize = 60;
/// By which the gaps of candidates may be too wide to touch.
const MARGIN: f64 = 0.2;

const ELASTIC: &str = "hertz 1e7 0.3";
const ELASTIC_PLAIN: &str = "hertz 1e7 0.3 conservative no";
const MINDLIN: &str = "hertz 1e7 0.3 damping restitution 0.7 tangential mindlin 0.5";
const VISCOELASTIC: &str = "nfd 1e7 0.3 300 200 tangential tfd 0.5 conservative no";
const WHOLE: &str = "nfd 1e7 0.3 300 200 tangential tfd 0.5 conservative yes";
const TOTAL: &str = "nfd 1e7 0.3 300 200 tangential tfd 0.5 displacement total";
const LINEAR: &str = "lsd 1e5 10 tangential linear 5e4 3 0.4";

fn laws(words: &str) -> Laws {
    let words: Vec<&str> = words.split(' ').collect();
    let (parameters, _) = ellgran::force::syntax::parse(&words).unwrap();
    Laws::new(1, &[Some(parameters)], true).unwrap()
}

/// How many pairs touched and how many were marked, over all steps, and how often candidates were selected.
#[derive(Debug, Default)]
struct Counts {
    selections: usize,
    touching: usize,
    marked: usize,
    /// The largest difference of a load, as a share of the largest load of the scene.
    difference: f64,
}

/// Steps of the lists, and in each the same forces by the kernels, which keep histories of their own.
fn compare<K: Kind, const FRICTION: bool, const CONSERVATIVE: bool>(
    words: &str,
    scene: Scene,
) -> Counts {
    compare_to::<K, FRICTION, CONSERVATIVE>(TOLERANCE, words, scene)
}

/// The same to this tolerance: with a greater one than that of double precision, in mixed precision.
fn compare_to<K: Kind, const FRICTION: bool, const CONSERVATIVE: bool>(
    tolerance: f64,
    words: &str,
    mut scene: Scene,
) -> Counts {
    let laws = laws(words);
    let features = laws.features();
    assert_eq!(features.friction, FRICTION);
    // On spheres the conservative terms vanish.
    assert_eq!(features.conservative && !K::SPHERES, CONSERVATIVE);
    let mut lists = scene.lists(&laws);
    let mut device = Device::new(&scene, &laws);
    device.mixed = tolerance > TOLERANCE;
    let mut counts = Counts::default();
    for step in 0..STEPS {
        let before = scene.motion.clone();
        scene.start_step();
        device.check_start(&scene, &before);
        scene.forces_in_lanes(&laws, &mut lists, step > 0);
        device.prepare::<K>(&scene);
        if step == 0 || device.largest_way(&scene) > 0.5 * MARGIN {
            device.select::<K>(&scene, &laws, MARGIN);
            counts.selections += 1;
        }
        device.compute::<K, FRICTION, CONSERVATIVE>(&laws);
        let (touching, marked) = device.compare(&scene, &lists, &laws, tolerance);
        counts.difference = counts.difference.max(device.largest_difference(&scene));
        counts.touching += touching;
        counts.marked += marked;
        let before = scene.motion.clone();
        scene.finish_step();
        device.check_finish(&scene, &before);
    }
    assert!(counts.touching > 50 * STEPS, "{counts:?}");
    // Most steps are on candidates of an earlier one.
    assert!(counts.selections < STEPS / 2, "{counts:?}");
    counts
}

#[test]
fn spheres() {
    compare::<Spheres, false, false>(ELASTIC, Scene::spheres());
    compare::<Spheres, true, false>(MINDLIN, Scene::spheres());
    compare::<Spheres, true, false>(VISCOELASTIC, Scene::spheres());
    compare::<Spheres, true, false>(LINEAR, Scene::spheres());
}

#[test]
fn spheroids() {
    compare::<Spheroids, false, true>(ELASTIC, Scene::spheroids());
    compare::<Spheroids, false, false>(ELASTIC_PLAIN, Scene::spheroids());
    compare::<Spheroids, true, true>(MINDLIN, Scene::spheroids());
    compare::<Spheroids, true, false>(VISCOELASTIC, Scene::spheroids());
    let counts = compare::<Spheroids, true, true>(WHOLE, Scene::spheroids());
    assert!(counts.selections > 2, "{counts:?}");
    compare::<Spheroids, true, true>(TOTAL, Scene::spheroids());
}

#[test]
fn spheres_among_spheroids() {
    compare::<Spheroids, true, true>(WHOLE, Scene::spheres_and_spheroids());
}

#[test]
fn three_semi_axes() {
    compare::<Ellipsoids, false, true>(ELASTIC, Scene::ellipsoids());
    compare::<Ellipsoids, true, true>(MINDLIN, Scene::ellipsoids());
    compare::<Ellipsoids, true, false>(VISCOELASTIC, Scene::ellipsoids());
    compare::<Ellipsoids, true, true>(WHOLE, Scene::ellipsoids());
    compare::<Ellipsoids, true, false>(LINEAR, Scene::ellipsoids());
}

/// Viscous forces take velocities that are extrapolated to the step.
#[test]
fn velocities_of_the_step() {
    let of_step = |scene: Scene| Scene {
        of_step: true,
        ..scene
    };
    compare::<Spheroids, true, true>(MINDLIN, of_step(Scene::spheroids()));
    compare::<Ellipsoids, true, true>(WHOLE, of_step(Scene::ellipsoids()));
}

/// Contacts that the search in lanes hands back are taken by the second kernel.
#[test]
fn deep_contacts_are_marked_and_taken() {
    let counts = compare::<Spheroids, true, true>(WHOLE, Scene::flat_discs());
    assert!(counts.marked > STEPS, "{counts:?}");
    let counts = compare::<Ellipsoids, true, true>(WHOLE, Scene::flat_blocks());
    assert!(counts.marked > STEPS, "{counts:?}");
}

/// Each grain gets the force of the one contact: momentum is conserved to the last bit of each force.
#[test]
fn both_sides_of_a_pair_agree_to_the_last_bit() {
    let laws = laws(WHOLE);
    let scene = Scene::pair();
    let mut device = Device::new(&scene, &laws);
    device.prepare::<Ellipsoids>(&scene);
    device.select::<Ellipsoids>(&scene, &laws, 0.1);
    device.compute::<Ellipsoids, true, true>(&laws);
    let [a, b] = [device.loads[0].force, device.loads[1].force];
    assert!(a.norm() > 0.0);
    assert_eq!(a, -b);
}

#[test]
fn planes() {
    device::planes::<Spheroids, true, true>(&laws(WHOLE), Scene::spheroids(), TOLERANCE);
    device::planes::<Ellipsoids, true, true>(&laws(MINDLIN), Scene::ellipsoids(), TOLERANCE);
    device::planes::<Ellipsoids, true, false>(&laws(VISCOELASTIC), Scene::ellipsoids(), TOLERANCE);
}

/// What a device is given and cannot use is said, by grain.
#[test]
fn a_fault_has_its_number() {
    use ellgran_kernels::preparation::Fault;
    type Break = fn(&mut Scene);
    let cases: [(Fault, Break); 9] = [
        (Fault::Position, |s| s.motion.positions[3][1] = f64::NAN),
        (Fault::Velocity, |s| {
            s.motion.velocities[3][0] = f64::INFINITY
        }),
        (Fault::AngularVelocity, |s| {
            s.motion.angular_momenta[3][2] = 1e300;
        }),
        (Fault::Mass, |s| s.masses[3] = 0.0),
        (Fault::Type, |s| s.types[3] = 2),
        (Fault::SemiAxis, |s| s.semi_axes[3][0] = -1.0),
        (Fault::AspectRatio, |s| s.semi_axes[3] = [1e-7, 1.0, 1.0]),
        (Fault::Quaternion, |s| s.motion.quaternions[3] = [0.0; 4]),
        (Fault::Kind, |s| s.semi_axes[3] = [1.0, 2.0, 3.0]),
    ];
    for (fault, break_it) in cases {
        let mut scene = Scene::spheroids();
        break_it(&mut scene);
        for k in 0..5 {
            let prepared = device::prepare_one::<Spheroids>(&scene, k);
            assert_eq!(prepared.err(), (k == 3).then_some(fault));
        }
    }
}
