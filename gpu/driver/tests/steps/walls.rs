// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts with walls of other shapes than planes, of triangles too, one at rest and others in motion, against those of the library's walls; their histories follow
//! the grains into another order.

use crate::engine_arrays::Layout::{self, Columns, Rows};
use crate::planes::particle;
use crate::scene::{Scene, STEP, TIME_STEP};
use crate::support::{self, new, succeed, with_driver, Engine};
use crate::{
    gpu_scene, laws_on_host, near, step_of, OnDevice, ELASTIC, MINDLIN, TOLERANCE, VISCOELASTIC,
    WHOLE,
};
use ellgran::c_api::law::ellgran_laws_free;
use ellgran::c_api::rigid_wall::{
    ellgran_wall_add_shape, ellgran_wall_add_triangles, ellgran_wall_free,
    ellgran_wall_histories_length, ellgran_wall_histories_used, ellgran_wall_new, EllgranWall,
    EllgranWallMotion, EllgranWallShape, ELLGRAN_END_CLOSED, ELLGRAN_END_NONE, ELLGRAN_END_OPEN,
    ELLGRAN_SIDE_OF_CENTRE, ELLGRAN_SIDE_OUTSIDE,
};
use ellgran::c_api::status::ELLGRAN_ERROR_ARGUMENT;
use ellgran::contact::Particle;
use ellgran::geometry::triangles::Triangle;
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::{
    compute_wall, End, Mesh, Motion, ShapeParameters, Side, Wall, WallInput, WallOutput,
};
use ellgran_gpu::arrays::{EllgranGpuHistories, ELLGRAN_GPU_ANY_SHAPES};
use ellgran_gpu::c_api::gpu::ellgran_gpu_free;
use ellgran_gpu::c_api::scene::{
    ellgran_gpu_add_wall, ellgran_gpu_check, ellgran_gpu_histories, ellgran_gpu_new_list,
    ellgran_gpu_read_wall_histories, ellgran_gpu_scene_free, ellgran_gpu_write_wall_histories,
    EllgranGpuScene,
};
use ellgran_gpu::c_api::step::{
    ellgran_gpu_compute_pairs, ellgran_gpu_compute_wall, ellgran_gpu_prepare,
};
use std::ffi::CStr;

const STEPS: usize = 20;
/// Particles are prepared in another way here than on the device, and faces that share a contact multiply rounding.
const BOUND: f64 = 10.0 * TOLERANCE;
/// When there is a new list.
const NEW_LIST: usize = 11;

/// Shapes about the middle of the scenes, of three walls, of which one is there before the first list: name, radii, bounds, ends, outside.
type Given = (&'static CStr, [f64; 2], [f64; 2], i32, bool);
const WALLS: [&[Given]; 3] = [
    &[
        (c"cylinder", [2.9, 0.0], [0.0; 2], ELLGRAN_END_NONE, false),
        (c"sphere", [2.2, 0.0], [0.0; 2], ELLGRAN_END_NONE, false),
    ],
    &[
        (c"cone", [2.0, 0.0], [-2.5, 2.0], ELLGRAN_END_CLOSED, true),
        (
            c"cylinder",
            [1.5, 0.0],
            [-2.0, 2.6],
            ELLGRAN_END_OPEN,
            false,
        ),
    ],
    // Triangles follow it.
    &[(c"sphere", [1.2, 0.0], [0.0; 2], ELLGRAN_END_NONE, false)],
];
/// The one with triangles.
const WITH_TRIANGLES: usize = 2;
const MIDDLE: [f64; 3] = [3.5, 3.4, 3.3];
const AXIS: [f64; 3] = [0.2, -0.1, 1.0];
const VELOCITY: [f64; 3] = [0.3, 0.1, -0.2];
const SPIN: [f64; 3] = [0.3, -0.2, 0.9];
/// What these have more at the step.
const VELOCITY_CHANGE: [f64; 3] = [-0.02, 0.03, 0.05];
const SPIN_CHANGE: [f64; 3] = [0.04, 0.02, -0.07];

/// A block. Of grains whose centre is nearly at an uneven surface, as some of these would be, rounding decides which faces are hidden by others:
/// the kernels' own tests have such surfaces, with the same grains on both sides.
fn triangles() -> Vec<Triangle> {
    const HALF: [f64; 3] = [2.0, 1.7, 1.4];
    let corner = |bits: usize| {
        let along = |k: usize| {
            if bits >> k & 1 == 1 {
                HALF[k]
            } else {
                -HALF[k]
            }
        };
        Vector3::from_array(MIDDLE) + Vector3::new(along(0), along(1), along(2))
    };
    let sides = (0..3).flat_map(|axis| [(axis, 0), (axis, 1 << axis)]);
    let faces = sides.flat_map(|(axis, side)| {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let [a, b, c, d] = [side, side + u, side + u + v, side + v].map(corner);
        [[a, b, c], [a, c, d]]
    });
    faces.collect()
}

fn through_c(shapes: &[Given], triangles: &[Triangle]) -> *mut EllgranWall {
    let mut wall = core::ptr::null_mut();
    unsafe {
        succeed(ellgran_wall_new(&mut wall));
        for (name, radii, bounds, end, outside) in shapes {
            let shape = EllgranWallShape {
                name: name.as_ptr(),
                point: MIDDLE,
                axis: AXIS,
                radii: *radii,
                bounds: *bounds,
                ends: [*end; 2],
                side: if *outside {
                    ELLGRAN_SIDE_OUTSIDE
                } else {
                    ELLGRAN_SIDE_OF_CENTRE
                },
                ..new()
            };
            succeed(ellgran_wall_add_shape(wall, &shape));
        }
        if !triangles.is_empty() {
            let corners: Vec<f64> = triangles
                .iter()
                .flatten()
                .flat_map(|p| p.to_array())
                .collect();
            let status = ellgran_wall_add_triangles(wall, triangles.len(), corners.as_ptr());
            succeed(status);
        }
    }
    wall
}

fn on_host(shapes: &[Given]) -> Wall {
    let mut wall = Wall::new();
    for (name, radii, bounds, end, outside) in shapes {
        let endless = *bounds == [0.0; 2];
        let parameters = ShapeParameters {
            point: Vector3::from_array(MIDDLE),
            axis: Vector3::from_array(AXIS).normalised(),
            radii: *radii,
            bounds: if endless {
                [f64::NEG_INFINITY, f64::INFINITY]
            } else {
                *bounds
            },
            ends: [match *end {
                ELLGRAN_END_NONE => End::None,
                ELLGRAN_END_OPEN => End::Open,
                _ => End::Closed,
            }; 2],
            side: if *outside {
                Side::Outside
            } else {
                Side::OfCentre
            },
        };
        wall.add_shape(name.to_str().unwrap(), &parameters).unwrap();
    }
    wall
}

/// The first wall is at rest, the others move and turn.
fn motions(time: f64) -> [EllgranWallMotion; 3] {
    let half = 0.5 * SPIN.iter().map(|x| x * x).sum::<f64>().sqrt() * time;
    let axis = Vector3::from_array(SPIN).normalised() * half.sin();
    let moving = EllgranWallMotion {
        origin: MIDDLE,
        displacement: VELOCITY.map(|v| v * time),
        quaternion: [half.cos(), axis.x, axis.y, axis.z],
        velocity: VELOCITY,
        angular_velocity: SPIN,
        velocity_change: VELOCITY_CHANGE,
        angular_velocity_change: SPIN_CHANGE,
        ..new()
    };
    [new(), moving, moving]
}

fn motion_on_host(m: &EllgranWallMotion) -> Motion {
    if m.quaternion == [0.0; 4] {
        return Motion::REST;
    }
    Motion {
        origin: Vector3::from_array(m.origin),
        displacement: Vector3::from_array(m.displacement),
        axes: Motion::axes_of(m.quaternion),
        velocity: Vector3::from_array(m.velocity),
        angular_velocity: Vector3::from_array(m.angular_velocity),
        velocity_change: Vector3::from_array(m.velocity_change),
        angular_velocity_change: Vector3::from_array(m.angular_velocity_change),
        along_itself: false,
    }
}

/// What a scene remembers of a wall, or of a plane that is a part of it: as the host does (`of_host`, by the rows of the list), and it goes to
/// the host and back.
pub unsafe fn through_the_host<'h>(
    (made, number): (*mut EllgranGpuScene, i32),
    device: &OnDevice,
    (wall, part): (*const EllgranWall, i32),
    words: &str,
    of_host: &dyn Fn(usize) -> &'h [f64],
) {
    let laws = support::laws(words);
    let (grains, stream) = (device.grains(), device.engine.stream);
    let (count, length) = unsafe {
        (
            device.order.len(),
            ellgran_wall_histories_length(wall, laws),
        )
    };
    let read = || unsafe {
        let mut values = vec![0.0; count * length];
        let to = values.as_mut_ptr();
        succeed(ellgran_gpu_read_wall_histories(
            made, number, wall, laws, part, to, stream,
        ));
        values
    };
    let write = |values: &[f64]| unsafe {
        let from = values.as_ptr();
        ellgran_gpu_write_wall_histories(made, &grains, number, wall, laws, part, from, stream)
    };
    let values = read();
    let mut contacts = 0;
    for row in 0..if length > 0 { count } else { 0 } {
        let own = &values[row * length..(row + 1) * length];
        contacts += own[0] as usize;
        let other = of_host(row);
        assert_eq!((own.len(), own[0]), (other.len(), other[0]));
        for (own, other) in own.iter().zip(other) {
            near(*own, *other, 1.0 + other.abs(), TOLERANCE, "history", row);
        }
    }
    assert!(contacts > 5 || length == 0, "{contacts}");
    // Zeros are nothing.
    succeed(write(&vec![0.0; values.len()]));
    assert!(read().iter().all(|x| *x == 0.0));
    if let Some(first) = values.iter().step_by(length.max(1)).position(|n| *n > 0.0) {
        for (place, number) in [
            (0, 0.5),
            (1, 99.0),
            (2, f64::NAN),
            (length - 1, f64::INFINITY),
        ] {
            let mut wrong = values.clone();
            // The last of them in a record that is in use.
            let used = unsafe { ellgran_wall_histories_used(wall, laws, &values[first * length]) };
            let place = place.min(used - 1);
            wrong[first * length + place] = number;
            let status = write(&wrong);
            let name = format!("histories[{}]", first * length + place);
            support::fail(
                status,
                ELLGRAN_ERROR_ARGUMENT,
                &[&name, &format!("grain {first}")],
            );
        }
    }
    succeed(write(&values));
    assert_eq!(read(), values);
    unsafe { ellgran_laws_free(laws) };
}

fn compare(arrays: Layout, words: &str, mut scene: Scene) {
    let laws = laws_on_host(words);
    let (gpu, made) = gpu_scene(words, ELLGRAN_GPU_ANY_SHAPES);
    let count = scene.count();
    let mut device = OnDevice::new(Engine::new(), &scene, count, false, arrays);
    let stream = device.engine.stream;
    let step = step_of(TIME_STEP);
    let mut numbers = [7; 3];
    let mut walls = WALLS.map(on_host);
    let triangles = triangles();
    walls[WITH_TRIANGLES].add_mesh(Mesh::new(triangles.clone()).unwrap());
    let lengths: Vec<usize> = walls.iter().map(|w| w.histories(&laws).length()).collect();
    let mut remembered: Vec<Vec<f64>> = lengths.iter().map(|n| vec![0.0; n * count]).collect();
    let mut touching = 0;
    unsafe {
        let given = |at: usize| {
            let own: &[Triangle] = if at == WITH_TRIANGLES {
                &triangles
            } else {
                &[]
            };
            through_c(WALLS[at], own)
        };
        let mut add = |at: usize| {
            let wall = given(at);
            succeed(ellgran_gpu_add_wall(made, wall, stream, &mut numbers[at]));
            // The parts are copied.
            ellgran_wall_free(wall);
        };
        add(0);
        let (grains, list) = (device.grains(), device.neighbour_list());
        succeed(ellgran_gpu_new_list(made, &grains, &list, stream));
        add(1);
        add(2);
        assert_eq!(numbers, [0, 1, 2]);
        for now in 0..STEPS {
            scene.start_step();
            if now == NEW_LIST {
                device.begin_anew(&scene, 3, false);
                let (grains, list) = (device.grains(), device.neighbour_list());
                succeed(ellgran_gpu_new_list(made, &grains, &list, stream));
                for at in 0..numbers.len() {
                    let wall = given(at);
                    let of_host = |row: usize| {
                        let k = device.order[row];
                        &remembered[at][k * lengths[at]..(k + 1) * lengths[at]]
                    };
                    through_the_host((made, numbers[at]), &device, (wall, 0), words, &of_host);
                    ellgran_wall_free(wall);
                }
            } else {
                device.write_all(&scene);
            }
            let (grains, loads) = (device.grains(), device.to_load());
            let motions = motions(now as f64 * TIME_STEP);
            device.engine.in_a_step(|| {
                succeed(ellgran_gpu_prepare(made, &grains, stream));
                // There are no pairs: it writes zeros.
                succeed(ellgran_gpu_compute_pairs(
                    made, &grains, &step, &loads, stream,
                ));
                for (motion, number) in motions.iter().zip(numbers) {
                    succeed(ellgran_gpu_compute_wall(
                        made, &grains, number, motion, 1, &step, &loads, stream,
                    ));
                }
            });
            succeed(ellgran_gpu_check(made, &grains, stream));
            let loads = device.loads();
            let (mut forces, mut torques) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count]);
            for ((wall, motion), histories) in walls.iter_mut().zip(&motions).zip(&mut remembered) {
                let motion = motion_on_host(motion);
                let place = |k: usize| {
                    let largest = scene.semi_axes[k].iter().copied().fold(0.0, f64::max);
                    Some((Vector3::from_array(scene.motion.positions[k]), largest))
                };
                let near_wall = wall.find_near(&motion, count, place).to_vec();
                let particles: Vec<Particle> =
                    near_wall.iter().map(|&k| particle(&scene, k)).collect();
                let load = compute_wall(
                    wall,
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
                        histories,
                        forces: &mut forces,
                        torques: &mut torques,
                    },
                    None,
                );
                touching += load.unwrap().contacts;
            }
            let largest = forces.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
            for k in 0..count {
                let expected = [forces[k], torques[k]].concat();
                for c in 0..6 {
                    near(loads[k][c], expected[c], largest, BOUND, "load", k);
                }
            }
            for (at, number) in numbers.into_iter().enumerate() {
                let mut histories = new::<EllgranGpuHistories>();
                succeed(ellgran_gpu_histories(made, number, &mut histories));
                let length = histories.length;
                // There is room for fewer records where a wall has many parts.
                assert!(histories.count == count && length <= lengths[at]);
                let e = &device.engine;
                let states: Vec<u32> = e.read_at(histories.touching.addr() as u64, count);
                let values: Vec<f64> = e.read_at(histories.histories.addr() as u64, count * length);
                for (row, &k) in device.order.iter().enumerate() {
                    let own = &values[row * length..(row + 1) * length];
                    let other = &remembered[at][k * lengths[at]..(k + 1) * lengths[at]];
                    if length > 0 {
                        let records = walls[at].histories(&laws).records;
                        assert_eq!(states[row].min(records as u32), own[0] as u32);
                    }
                    for (own, other) in own.iter().zip(other) {
                        near(*own, *other, 1.0 + largest, BOUND, "history", k);
                    }
                }
            }
        }
        ellgran_gpu_scene_free(made);
        ellgran_gpu_free(gpu);
    }
    assert!(touching > 1000, "{touching}");
}

#[test]
fn walls() {
    with_driver("walls::walls", &[], || {
        compare(Rows, WHOLE, Scene::spheroids());
        compare(Columns, MINDLIN, Scene::ellipsoids());
        compare(Rows, VISCOELASTIC, Scene::spheres());
        compare(Columns, ELASTIC, Scene::ellipsoids());
    });
}
