// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts with planes, against those of one contact at a time; their histories follow the grains into another order.

use crate::engine_arrays::Layout::{self, Columns, Rows};
use crate::scene::{Scene, STEP, TIME_STEP};
use crate::support::{new, succeed, with_driver, Engine};
use crate::walls::through_the_host;
use crate::{
    gpu_scene, laws_on_host, near, step_of, OnDevice, MINDLIN, TOLERANCE, VISCOELASTIC, WHOLE,
};
use ellgran::c_api::plane::EllgranPlane;
use ellgran::c_api::rigid_wall::{
    ellgran_wall_add_shape, ellgran_wall_free, ellgran_wall_new, EllgranWall, EllgranWallShape,
    ELLGRAN_SIDE_INSIDE,
};
use ellgran::contact::{prepare_body, Body};
use ellgran::geometry::Plane;
use ellgran::vector::Vector3;
use ellgran::walls::{one_contact_with_plane, MovingPlane};
use ellgran_gpu::arrays::{EllgranGpuHistories, ELLGRAN_GPU_ANY_SHAPES};
use ellgran_gpu::c_api::gpu::ellgran_gpu_free;
use ellgran_gpu::c_api::scene::{
    ellgran_gpu_add_plane, ellgran_gpu_histories, ellgran_gpu_new_list, ellgran_gpu_scene_free,
};
use ellgran_gpu::c_api::step::{
    ellgran_gpu_compute_pairs, ellgran_gpu_compute_plane, ellgran_gpu_prepare,
};

/// Two planes, of which one is there before the first list.
const PLANES: [([f64; 3], [f64; 3], [f64; 3]); 2] = [
    ([0.0, 0.0, 0.05], [0.1, -0.2, 1.0], [0.3, 0.1, -0.2]),
    ([0.0, 0.1, 0.0], [0.0, 3.0, 0.5], [0.0, 0.0, 0.4]),
];
/// What each has more at the step.
const VELOCITY_CHANGE: [f64; 3] = [-0.02, 0.03, 0.05];
const STEPS: usize = 20;
/// When there is a new list.
const NEW_LIST: usize = 11;

fn compare(arrays: Layout, words: &str, mut scene: Scene) {
    let laws = laws_on_host(words);
    let layout = laws.layout();
    let (gpu, made) = gpu_scene(words, ELLGRAN_GPU_ANY_SHAPES);
    let count = scene.count();
    let owned = count;
    let mut device = OnDevice::new(Engine::new(), &scene, owned, false, arrays);
    let stream = device.engine.stream;
    let step = step_of(TIME_STEP);
    let mut numbers = [7; 2];
    let mut touched = vec![[false; 2]; count];
    let mut remembered = vec![[vec![0.0; layout.length], vec![0.0; layout.length]]; count];
    let mut touching = 0;
    unsafe {
        succeed(ellgran_gpu_add_plane(made, stream, &mut numbers[0]));
        let (grains, list) = (device.grains(), device.neighbour_list());
        succeed(ellgran_gpu_new_list(made, &grains, &list, stream));
        succeed(ellgran_gpu_add_plane(made, stream, &mut numbers[1]));
        assert_eq!(numbers, [0, 1]);
        for now in 0..STEPS {
            scene.start_step();
            if now == NEW_LIST {
                device.begin_anew(&scene, 3, false);
                let (grains, list) = (device.grains(), device.neighbour_list());
                succeed(ellgran_gpu_new_list(made, &grains, &list, stream));
                let wall = with_planes();
                for (at, number) in numbers.into_iter().enumerate() {
                    // The second plane is the part before the first one.
                    let part = 1 - at;
                    let records: Vec<Vec<f64>> = (device.order.iter())
                        .map(|&k| record(at, part, touched[k][at], &remembered[k][at]))
                        .collect();
                    let of_host = |row: usize| &records[row][..];
                    let of_wall = (wall.cast_const(), part as i32);
                    through_the_host((made, number), &device, of_wall, words, &of_host);
                }
                ellgran_wall_free(wall);
            } else {
                device.write_all(&scene);
            }
            let (grains, loads) = (device.grains(), device.to_load());
            let planes = PLANES.map(|(point, normal, velocity)| EllgranPlane {
                point,
                normal,
                velocity,
                velocity_change: VELOCITY_CHANGE,
                ..new()
            });
            device.engine.in_a_step(|| {
                succeed(ellgran_gpu_prepare(made, &grains, stream));
                // There are no pairs: it writes zeros.
                succeed(ellgran_gpu_compute_pairs(
                    made, &grains, &step, &loads, stream,
                ));
                for (plane, number) in planes.iter().zip(numbers) {
                    succeed(ellgran_gpu_compute_plane(
                        made, &grains, number, plane, 1, &step, &loads, stream,
                    ));
                }
            });
            let loads = device.loads();
            let mut expected = vec![[0.0; 6]; count];
            let mut largest = 0.0f64;
            for k in 0..count {
                for (at, (point, normal, velocity)) in PLANES.iter().enumerate() {
                    let wall = MovingPlane {
                        plane: Plane {
                            point: Vector3::from_array(*point),
                            normal: Vector3::from_array(*normal).normalised(),
                        },
                        velocity: Vector3::from_array(*velocity),
                        velocity_change: Vector3::from_array(VELOCITY_CHANGE),
                    };
                    let found = one_contact_with_plane(
                        &laws,
                        &particle(&scene, k),
                        &wall,
                        1,
                        &STEP,
                        &mut touched[k][at],
                        &mut remembered[k][at],
                    );
                    let Some((_, f)) = found.unwrap() else {
                        continue;
                    };
                    touching += 1;
                    largest = largest.max(f.force.norm());
                    for c in 0..3 {
                        expected[k][c] -= f.force.to_array()[c];
                        expected[k][3 + c] += f.torque_i.to_array()[c];
                    }
                }
            }
            for k in 0..count {
                for c in 0..6 {
                    near(loads[k][c], expected[k][c], largest, TOLERANCE, "load", k);
                }
            }
            for (at, number) in numbers.into_iter().enumerate() {
                let mut histories = new::<EllgranGpuHistories>();
                succeed(ellgran_gpu_histories(made, number, &mut histories));
                assert_eq!((histories.count, histories.length), (count, layout.length));
                let e = &device.engine;
                let states: Vec<u32> = e.read_at(histories.touching.addr() as u64, count);
                let values: Vec<f64> =
                    e.read_at(histories.histories.addr() as u64, count * layout.length);
                for (row, &k) in device.order.iter().enumerate() {
                    assert_eq!(states[row] != 0, touched[k][at]);
                    let own = &values[row * layout.length..(row + 1) * layout.length];
                    for (own, other) in own.iter().zip(&remembered[k][at]) {
                        near(*own, *other, 1.0 + largest, TOLERANCE, "history", k);
                    }
                }
            }
        }
        ellgran_gpu_scene_free(made);
        ellgran_gpu_free(gpu);
    }
    assert!(touching > 200, "{touching}");
}

/// The planes as parts of one wall, in the other order.
fn with_planes() -> *mut EllgranWall {
    let mut wall = core::ptr::null_mut();
    unsafe {
        succeed(ellgran_wall_new(&mut wall));
        for (point, normal, _) in PLANES.iter().rev() {
            let shape = EllgranWallShape {
                name: c"plane".as_ptr(),
                point: *point,
                axis: *normal,
                side: ELLGRAN_SIDE_INSIDE,
                ..new()
            };
            succeed(ellgran_wall_add_shape(wall, &shape));
        }
    }
    wall
}

/// What a wall of the host with two planes remembers of one of them: how many contacts, the part, a point, the normal, the history.
fn record(at: usize, part: usize, touches: bool, history: &[f64]) -> Vec<f64> {
    let mut record = vec![0.0; 1 + 2 * (7 + history.len())];
    if touches {
        let normal = Vector3::from_array(PLANES[at].1).normalised();
        record[0] = 1.0;
        record[1] = (part + 1) as f64;
        record[5..8].copy_from_slice(&(-normal).to_array());
        record[8..8 + history.len()].copy_from_slice(history);
    }
    record
}

pub fn particle(scene: &Scene, k: usize) -> ellgran::contact::Particle {
    let m = &scene.motion;
    let body = Body {
        position: m.positions[k],
        quaternion: m.quaternions[k],
        semi_axes: scene.semi_axes[k],
        velocity: m.velocities[k],
        angular_velocity: omega(scene, k),
        mass: scene.masses[k],
        particle_type: 1,
        identifier: k as i64 + 1,
    };
    prepare_body(&body, Some(1)).unwrap()
}

/// From the angular momentum.
fn omega(scene: &Scene, k: usize) -> [f64; 3] {
    let m = &scene.motion;
    let body = ellgran::geometry::Ellipsoid::new(scene.semi_axes[k], m.quaternions[k]).unwrap();
    let momentum = Vector3::from_array(m.angular_momenta[k]);
    ellgran::contact::particle::angular_velocity(&body, scene.masses[k], momentum).to_array()
}

#[test]
fn planes() {
    with_driver("planes::planes", &[], || {
        compare(Rows, WHOLE, Scene::spheroids());
        compare(Columns, MINDLIN, Scene::ellipsoids());
        compare(Rows, VISCOELASTIC, Scene::ellipsoids());
        compare(Columns, VISCOELASTIC, Scene::spheres());
    });
}
