// SPDX-License-Identifier: MIT OR Apache-2.0
//! What can be wrong: with the driver, the GPU, the arguments, a grain; each is a status of its own with a message that says what to do.

#![allow(unsafe_code)]
// Each block calls functions of the interface with pointers to locals that outlive the call.
#![allow(clippy::undocumented_unsafe_blocks)]

#[path = "support/mod.rs"]
mod support;

use ellgran::c_api::status::{
    ELLGRAN_ERROR_ARGUMENT, ELLGRAN_ERROR_NULL_POINTER, ELLGRAN_ERROR_PARTICLE,
};
use ellgran_gpu::arrays::{
    EllgranGpuCounts, EllgranGpuGrains, EllgranGpuList, EllgranGpuLoads, EllgranGpuMotion,
    ELLGRAN_GPU_ANY_SHAPES, ELLGRAN_GPU_MIXED, ELLGRAN_GPU_SPHERES,
};
use ellgran_gpu::c_api::gpu::{
    ellgran_gpu_free, ellgran_gpu_open, ellgran_gpu_open_current, EllgranGpu,
};
use ellgran_gpu::c_api::scene::{
    ellgran_gpu_add_plane, ellgran_gpu_add_wall, ellgran_gpu_check, ellgran_gpu_counts,
    ellgran_gpu_new_list, ellgran_gpu_scene_free, ellgran_gpu_scene_new,
    ellgran_gpu_scene_set_precision, EllgranGpuScene,
};
use ellgran_gpu::c_api::step::{
    ellgran_gpu_compute_pairs, ellgran_gpu_compute_plane, ellgran_gpu_compute_wall,
    ellgran_gpu_prepare, ellgran_gpu_start_step,
};
use ellgran_gpu::status::{
    ELLGRAN_GPU_ERROR_ASSEMBLER, ELLGRAN_GPU_ERROR_DRIVER, ELLGRAN_GPU_ERROR_KERNEL,
    ELLGRAN_GPU_ERROR_LAWS, ELLGRAN_GPU_ERROR_MEMORY, ELLGRAN_GPU_ERROR_NO_DEVICE,
    ELLGRAN_GPU_ERROR_NO_DRIVER, ELLGRAN_GPU_ERROR_OLD_DEVICE, ELLGRAN_GPU_ERROR_OLD_DRIVER,
    ELLGRAN_GPU_ERROR_POINTER,
};
use std::path::Path;
use support::{fail, laws, new, open, succeed, with_driver, Array, Engine, Tally};

const DRIVER: &str = "ELLGRAN_GPU_DRIVER";
const NULL: *mut EllgranGpu = core::ptr::null_mut();

/// That a GPU cannot be opened.
fn cannot_open(ordinal: i32, status: i32, words: &[&str]) {
    let mut gpu = NULL;
    fail(
        unsafe { ellgran_gpu_open(ordinal, &mut gpu) },
        status,
        words,
    );
    assert!(gpu.is_null());
}

#[test]
fn no_driver() {
    let settings = [(DRIVER, "/nowhere/libcuda.so.1")];
    with_driver("no_driver", &settings, || {
        let words = [
            "/nowhere/libcuda.so.1",
            "No such file",
            "Install the driver",
            DRIVER,
        ];
        cannot_open(0, ELLGRAN_GPU_ERROR_NO_DRIVER, &words);
    });
}

/// A shared library with one function of the driver.
fn driver_with_one_function(place: &Path) -> String {
    let (source, library) = (place.join("driver.c"), place.join("libcuda.so.1"));
    std::fs::write(
        &source,
        "int cuInit(unsigned flags) { return (int) flags; }\n",
    )
    .unwrap();
    let made = std::process::Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .args([&library, &source])
        .status();
    assert!(made.unwrap().success());
    library.to_str().unwrap().to_owned()
}

#[test]
fn a_driver_that_lacks_a_function() {
    let place = tempfile::tempdir().unwrap();
    let library = driver_with_one_function(place.path());
    let settings = [(DRIVER, &*library)];
    with_driver("a_driver_that_lacks_a_function", &settings, || {
        let words = ["has no cuDriverGetVersion", "install a newer"];
        cannot_open(0, ELLGRAN_GPU_ERROR_OLD_DRIVER, &words);
    });
}

#[test]
fn an_old_driver() {
    let settings = [("ELLGRAN_STAND_IN_VERSION", "10020")];
    with_driver("an_old_driver", &settings, || {
        let words = ["CUDA 10.2", "need one of CUDA 11.0", "install a newer"];
        cannot_open(0, ELLGRAN_GPU_ERROR_OLD_DRIVER, &words);
    });
}

#[test]
fn a_stub_for_linking() {
    let settings = [("ELLGRAN_STAND_IN_INIT", "34")];
    with_driver("a_stub_for_linking", &settings, || {
        cannot_open(0, ELLGRAN_GPU_ERROR_NO_DRIVER, &["stub"]);
    });
}

#[test]
fn no_gpu() {
    let settings = [("ELLGRAN_STAND_IN_DEVICES", "0")];
    with_driver("no_gpu", &settings, || {
        cannot_open(0, ELLGRAN_GPU_ERROR_NO_DEVICE, &["CUDA_VISIBLE_DEVICES"]);
    });
}

#[test]
fn no_such_gpu() {
    with_driver("no_such_gpu", &[], || {
        for ordinal in [1, -1] {
            let words = [&*format!("no GPU {ordinal}"), "finds 1"];
            cannot_open(ordinal, ELLGRAN_GPU_ERROR_NO_DEVICE, &words);
        }
        fail(
            unsafe { ellgran_gpu_open(0, core::ptr::null_mut()) },
            ELLGRAN_ERROR_NULL_POINTER,
            &["gpu"],
        );
    });
}

#[test]
fn an_old_gpu() {
    let settings = [("ELLGRAN_STAND_IN_GENERATION", "61")];
    with_driver("an_old_gpu", &settings, || {
        let words = ["Stand-in is of generation sm_61", "sm_70"];
        cannot_open(0, ELLGRAN_GPU_ERROR_OLD_DEVICE, &words);
    });
}

#[test]
fn what_the_assembler_says() {
    let settings = [("ELLGRAN_STAND_IN_ASSEMBLER", "218")];
    with_driver("what_the_assembler_says", &settings, || {
        let words = ["CUDA_ERROR_INVALID_PTX", "ptxas fatal"];
        cannot_open(0, ELLGRAN_GPU_ERROR_ASSEMBLER, &words);
    });
}

#[test]
fn ptx_that_is_too_new() {
    let settings = [("ELLGRAN_STAND_IN_ASSEMBLER", "222")];
    with_driver("ptx_that_is_too_new", &settings, || {
        cannot_open(0, ELLGRAN_GPU_ERROR_OLD_DRIVER, &["too old"]);
    });
}

/// A result that this library does not know is told with its number.
#[test]
fn another_failure() {
    let settings = [("ELLGRAN_STAND_IN_INIT", "12345")];
    with_driver("another_failure", &settings, || {
        cannot_open(0, ELLGRAN_GPU_ERROR_DRIVER, &["cuInit", "12345"]);
    });
}

#[test]
fn the_context_of_this_thread() {
    with_driver("the_context_of_this_thread", &[], || {
        let mut gpu = NULL;
        let status = unsafe { ellgran_gpu_open_current(&mut gpu) };
        fail(status, ELLGRAN_GPU_ERROR_NO_DEVICE, &["ellgran_gpu_open"]);
        let engine = Engine::new();
        succeed(unsafe { ellgran_gpu_open_current(&mut gpu) });
        // Calls bring the context with them, and leave the thread as it was.
        engine.leave();
        let mut scene = core::ptr::null_mut();
        let laws = laws("hertz 1e7 0.3");
        unsafe {
            succeed(ellgran_gpu_scene_new(
                gpu,
                laws,
                ELLGRAN_GPU_SPHERES,
                &mut scene,
            ));
            ellgran_gpu_scene_free(scene);
            ellgran_gpu_free(gpu);
        }
        assert_eq!(engine.tally(Tally::Allocations), engine.tally(Tally::Frees));
    });
}

#[test]
fn laws_without_a_kernel() {
    with_driver("laws_without_a_kernel", &[], || {
        let gpu = open();
        for (words, word) in [
            ("hertz 1e7 0.3 factors hale conservative no", "hale"),
            ("nfd 1e7 0.3 10 10 viscosity memory", "viscosity memory"),
            (
                "hertz 1e7 0.3 tangential tfd 0.5 displacement hysteretic",
                "displacement hysteretic",
            ),
            (
                "hertz 1e7 0.3 tangential mindlin 0.5 rolling sds 1e3 1 0.1",
                "rolling",
            ),
        ] {
            let mut scene = core::ptr::null_mut();
            let status = unsafe { ellgran_gpu_scene_new(gpu, laws(words), 0, &mut scene) };
            fail(status, ELLGRAN_GPU_ERROR_LAWS, &[word, "host"]);
        }
        let mut scene = core::ptr::null_mut();
        let status = unsafe { ellgran_gpu_scene_new(gpu, laws("hertz 1e7 0.3"), 4, &mut scene) };
        fail(status, ELLGRAN_ERROR_ARGUMENT, &["shapes = 4"]);
        unsafe {
            succeed(ellgran_gpu_scene_new(
                gpu,
                laws("hertz 1e7 0.3"),
                0,
                &mut scene,
            ));
            let status = ellgran_gpu_scene_set_precision(scene, 2);
            fail(status, ELLGRAN_ERROR_ARGUMENT, &["precision = 2"]);
            succeed(ellgran_gpu_scene_set_precision(scene, ELLGRAN_GPU_MIXED));
            ellgran_gpu_scene_free(scene);
        }
    });
}

/// Five grains in a row that touch their neighbours.
struct Row {
    engine: Engine,
    scene: *mut EllgranGpuScene,
    positions: Array<[f64; 3]>,
    velocities: Array<[f64; 3]>,
    momenta: Array<[f64; 3]>,
    masses: Array<f64>,
    semi_axes: Array<[f64; 3]>,
    quaternions: Array<[f64; 4]>,
    types: Array<i32>,
    identifiers: Array<i32>,
    starts: Array<u32>,
    neighbours: Array<u32>,
    loads: Array<[f64; 6]>,
}

const COUNT: usize = 5;

impl Row {
    fn new() -> Row {
        let gpu = open();
        let mut scene = core::ptr::null_mut();
        let laws = laws("hertz 1e7 0.3 damping restitution 0.7 tangential mindlin 0.5");
        unsafe {
            let status = ellgran_gpu_scene_new(gpu, laws, ELLGRAN_GPU_ANY_SHAPES, &mut scene);
            succeed(status);
            ellgran_gpu_free(gpu);
        }
        let engine = Engine::new();
        Row {
            positions: engine.put(&[0, 1, 2, 3, 4].map(|k| [1.9 * f64::from(k), 0.0, 0.0])),
            velocities: engine.put(&[[0.0; 3]; COUNT]),
            momenta: engine.put(&[[0.0; 3]; COUNT]),
            masses: engine.put(&[1.0; COUNT]),
            semi_axes: engine.put(&[[1.0; 3]; COUNT]),
            quaternions: engine.put(&[[1.0, 0.0, 0.0, 0.0]; COUNT]),
            types: engine.put(&[1; COUNT]),
            identifiers: engine.put(&[10, 11, 12, 13, 14]),
            starts: engine.put(&[0, 1, 3, 5, 7, 8]),
            neighbours: engine.put(&[1, 0, 2, 1, 3, 2, 4, 3]),
            loads: engine.put(&[[0.0; 6]; COUNT]),
            engine,
            scene,
        }
    }

    fn grains(&self) -> EllgranGpuGrains {
        EllgranGpuGrains {
            owned_count: COUNT,
            count: COUNT,
            positions: self.positions.vectors(),
            velocities: self.velocities.vectors(),
            angular_momenta: self.momenta.vectors(),
            masses: self.masses.pointer(),
            semi_axes: self.semi_axes.vectors(),
            quaternions: self.quaternions.vectors(),
            types: self.types.pointer(),
            identifiers: self.identifiers.pointer(),
            ..new()
        }
    }

    fn motion(&self) -> EllgranGpuMotion {
        EllgranGpuMotion {
            count: COUNT,
            positions: self.positions.vectors(),
            velocities: self.velocities.vectors(),
            angular_momenta: self.momenta.vectors(),
            quaternions: self.quaternions.vectors(),
            semi_axes: self.semi_axes.vectors(),
            masses: self.masses.pointer(),
            forces: self.loads.loads().forces,
            torques: self.loads.loads().torques,
            ..new()
        }
    }

    fn list(&self) -> EllgranGpuList {
        EllgranGpuList {
            starts: self.starts.pointer(),
            neighbours: self.neighbours.pointer(),
            margin: 0.1,
            ..new()
        }
    }

    fn new_list(&self) -> i32 {
        unsafe {
            ellgran_gpu_new_list(self.scene, &self.grains(), &self.list(), self.engine.stream)
        }
    }

    fn prepare(&self) -> i32 {
        unsafe { ellgran_gpu_prepare(self.scene, &self.grains(), self.engine.stream) }
    }

    fn compute(&self) -> i32 {
        let step = ellgran::c_api::particles::EllgranStep {
            advance_history: 1,
            time_step: 1e-5,
            ..new()
        };
        let (loads, stream) = (self.loads.loads(), self.engine.stream);
        unsafe { ellgran_gpu_compute_pairs(self.scene, &self.grains(), &step, &loads, stream) }
    }

    fn check(&self) -> i32 {
        unsafe { ellgran_gpu_check(self.scene, &self.grains(), self.engine.stream) }
    }

    /// Sets a value of grain 3, whose identifier is 13.
    fn set<T: Copy>(&self, array: &Array<T>, value: T) {
        self.engine.write(array, 3, &[value]);
    }
}

#[test]
fn a_grain_that_cannot_be_used_is_named() {
    with_driver("a_grain_that_cannot_be_used_is_named", &[], || {
        let row = Row::new();
        succeed(row.new_list());
        succeed(row.compute());
        succeed(row.check());
        let named = |words: &[&str]| {
            let words: Vec<&str> = [&["particle 13: "], words].concat();
            // In a step, and told once.
            succeed(row.prepare());
            fail(row.check(), ELLGRAN_ERROR_PARTICLE, &words);
            succeed(row.check());
            // With a new list, and with the next after it.
            fail(row.new_list(), ELLGRAN_ERROR_PARTICLE, &words);
        };
        let good = |what: &str| {
            succeed(row.new_list());
            assert_eq!(row.check(), 0, "{what}");
        };
        row.set(&row.positions, [f64::NAN, 1.0, 0.0]);
        named(&["position = [NaN, 1.0, 0.0]", "finite"]);
        row.set(&row.positions, [5.7, 0.0, 0.0]);
        good("position");
        row.set(&row.velocities, [0.0, f64::INFINITY, 0.0]);
        named(&["velocity = [0.0, inf, 0.0]"]);
        row.set(&row.velocities, [0.0; 3]);
        good("velocity");
        row.set(&row.momenta, [0.0, 0.0, 1e300]);
        named(&["angular momentum = [0.0, 0.0, 1e300]"]);
        row.set(&row.momenta, [0.0; 3]);
        good("angular momentum");
        row.set(&row.masses, 0.0);
        named(&["mass = [0.0]"]);
        row.set(&row.masses, 1.0);
        good("mass");
        row.set(&row.types, 2);
        named(&["type = 2", "between 1 and 1"]);
        row.set(&row.types, 1);
        good("type");
        row.set(&row.quaternions, [0.0; 4]);
        named(&["quaternion (w, x, y, z) = [0.0, 0.0, 0.0, 0.0]"]);
        row.set(&row.quaternions, [1.0, 0.0, 0.0, 0.0]);
        good("quaternion");
        row.set(&row.semi_axes, [-1.0, 1.0, 1.0]);
        named(&["semi-axes = [-1.0, 1.0, 1.0]"]);
        row.set(&row.semi_axes, [1.0; 3]);
        good("semi-axes");
        row.set(&row.semi_axes, [1e-7, 1.0, 1.0]);
        named(&["1e6 times the smallest"]);
        row.set(&row.semi_axes, [1.0; 3]);
        good("semi-axes");
        // Shapes that have changed without a new list.
        row.set(&row.semi_axes, [1.0, 0.9, 0.8]);
        succeed(row.prepare());
        let words = ["particle 13: semi-axes = [1.0, 0.9, 0.8]", "ANY_SHAPES"];
        fail(row.check(), ELLGRAN_ERROR_PARTICLE, &words);
        good("another kind of shape, with a new list");
    });
}

/// What nobody has asked for is told with the next list.
#[test]
fn a_fault_before_a_new_list_is_told_with_it() {
    with_driver("a_fault_before_a_new_list_is_told_with_it", &[], || {
        let row = Row::new();
        succeed(row.new_list());
        row.set(&row.positions, [f64::NAN, 1.0, 0.0]);
        succeed(row.prepare());
        row.set(&row.positions, [5.7, 0.0, 0.0]);
        let words = ["particle 13: position: components must be finite"];
        fail(row.new_list(), ELLGRAN_ERROR_PARTICLE, &words);
        succeed(row.new_list());
    });
}

#[test]
fn a_grain_that_cannot_be_moved_is_named() {
    with_driver("a_grain_that_cannot_be_moved_is_named", &[], || {
        let row = Row::new();
        succeed(row.new_list());
        row.set(&row.momenta, [0.0, 0.0, 1e3]);
        let stream = row.engine.stream;
        let start = |time_step: f64| unsafe {
            ellgran_gpu_start_step(row.scene, &row.motion(), time_step, stream)
        };
        succeed(start(1.0));
        fail(
            row.check(),
            ELLGRAN_ERROR_PARTICLE,
            &["particle 13: it would turn"],
        );
        fail(
            start(f64::NAN),
            ELLGRAN_ERROR_ARGUMENT,
            &["time_step = NaN"],
        );
    });
}

#[test]
fn a_list_that_is_wrong_is_refused() {
    with_driver("a_list_that_is_wrong_is_refused", &[], || {
        let row = Row::new();
        succeed(row.new_list());
        succeed(row.compute());
        let loads = row.engine.read(&row.loads);
        row.engine.write(&row.neighbours, 5, &[5]);
        let words = ["particle 13: its row names a neighbour that is not one of the grains"];
        fail(row.new_list(), ELLGRAN_ERROR_PARTICLE, &words);
        // Itself.
        row.engine.write(&row.neighbours, 5, &[3]);
        fail(row.new_list(), ELLGRAN_ERROR_PARTICLE, &words);
        row.engine.write(&row.neighbours, 5, &[2]);
        // There is no list now.
        fail(row.prepare(), ELLGRAN_ERROR_ARGUMENT, &["no list"]);
        fail(row.compute(), ELLGRAN_ERROR_ARGUMENT, &["no list"]);
        row.engine.write(&row.starts, 3, &[9]);
        let words = ["particle 12: starts[2] and starts[3]"];
        fail(row.new_list(), ELLGRAN_ERROR_PARTICLE, &words);
        row.engine.write(&row.starts, 3, &[5]);
        // A pair in one row alone, and one twice in a row.
        row.engine.write(&row.neighbours, 5, &[0]);
        let words = ["particle 12: its row names a grain whose row does not name it"];
        fail(row.new_list(), ELLGRAN_ERROR_PARTICLE, &words);
        row.engine.write(&row.neighbours, 5, &[2]);
        row.engine.write(&row.neighbours, 1, &[0, 0]);
        let words = ["particle 11: its row names a neighbour twice"];
        fail(row.new_list(), ELLGRAN_ERROR_PARTICLE, &words);
        row.engine.write(&row.neighbours, 1, &[0, 2]);
        // What was remembered is still there.
        succeed(row.new_list());
        succeed(row.compute());
        assert!(loads[0][0] < 0.0);
        for (now, before) in row.engine.read(&row.loads).iter().zip(&loads) {
            assert!((now[0] - before[0]).abs() < 1e-9 * loads[0][0].abs());
        }
    });
}

#[test]
fn arguments() {
    with_driver("arguments", &[], || {
        let row = Row::new();
        let stream = row.engine.stream;
        fail(
            row.prepare(),
            ELLGRAN_ERROR_ARGUMENT,
            &["ellgran_gpu_new_list"],
        );
        let with = |change: &dyn Fn(&mut EllgranGpuGrains, &mut EllgranGpuList)| {
            let (mut grains, mut list) = (row.grains(), row.list());
            change(&mut grains, &mut list);
            unsafe { ellgran_gpu_new_list(row.scene, &grains, &list, stream) }
        };
        let status = with(&|g, _| g.positions.first = core::ptr::null_mut());
        fail(status, ELLGRAN_ERROR_NULL_POINTER, &["positions"]);
        let status = with(&|_, l| l.starts = core::ptr::null());
        fail(status, ELLGRAN_ERROR_NULL_POINTER, &["starts"]);
        let status = with(&|g, _| g.owned_count = 6);
        fail(
            status,
            ELLGRAN_ERROR_ARGUMENT,
            &["owned_count = 6", "count = 5"],
        );
        let status = with(&|_, l| l.margin = -1.0);
        fail(status, ELLGRAN_ERROR_ARGUMENT, &["margin = -1.0"]);
        let status = with(&|g, _| g.size = 0);
        fail(
            status,
            ELLGRAN_ERROR_ARGUMENT,
            &["size = 0", "EllgranGpuGrains"],
        );
        // An array of the host.
        let host = [[0.0f64; 3]; COUNT];
        let status = with(&|g, _| g.velocities.first = host.as_ptr().cast_mut().cast());
        let words = ["velocities", "not a pointer to memory of the GPU"];
        fail(status, ELLGRAN_GPU_ERROR_POINTER, &words);
        // An owner that is no owned grain, and a place that is none.
        for table in [&[0, 1, 2, 5, 4], &[0, 1, 2, -1, 4]] {
            let table = row.engine.put::<i32>(table);
            let status = with(&|g, _| g.owners = table.pointer());
            fail(status, ELLGRAN_ERROR_PARTICLE, &["particle 13", "owners"]);
            let status = with(&|g, _| {
                g.body_places = table.pointer();
                g.body_count = COUNT;
            });
            let words = ["particle 13", "body_places"];
            fail(status, ELLGRAN_ERROR_PARTICLE, &words);
        }
        // A stream that is none.
        let (grains, list) = (row.grains(), row.list());
        let none = core::ptr::without_provenance_mut(1);
        let status = unsafe { ellgran_gpu_new_list(row.scene, &grains, &list, none) };
        fail(
            status,
            ELLGRAN_GPU_ERROR_DRIVER,
            &["CUDA_ERROR_INVALID_HANDLE"],
        );
        succeed(row.new_list());
        let mut fewer = row.grains();
        fewer.count = 4;
        fewer.owned_count = 4;
        let status = unsafe { ellgran_gpu_prepare(row.scene, &fewer, stream) };
        fail(status, ELLGRAN_ERROR_ARGUMENT, &["owned_count = 4"]);
        let mut other = row.grains();
        other.velocity_changes = row.positions.pointer();
        let status = unsafe { ellgran_gpu_prepare(row.scene, &other, stream) };
        fail(status, ELLGRAN_ERROR_ARGUMENT, &["velocity_changes"]);
        let mut plane = 0;
        succeed(unsafe { ellgran_gpu_add_plane(row.scene, stream, &mut plane) });
        let at = ellgran::c_api::plane::EllgranPlane {
            normal: [0.0, 0.0, 1.0],
            ..new()
        };
        let step = new::<ellgran::c_api::particles::EllgranStep>();
        let compute = |plane: i32, wall_type: i32| unsafe {
            let (grains, loads) = (row.grains(), row.loads.loads());
            ellgran_gpu_compute_plane(
                row.scene, &grains, plane, &at, wall_type, &step, &loads, stream,
            )
        };
        succeed(compute(plane, 1));
        fail(
            compute(1, 1),
            ELLGRAN_ERROR_ARGUMENT,
            &["no wall 1", "made 1"],
        );
        fail(compute(0, 2), ELLGRAN_ERROR_ARGUMENT, &["wall_type = 2"]);
    });
}

/// Walls that have no kernel, that are taken for others, and that a grain touches in too many places.
#[test]
fn walls_that_will_not_do() {
    use ellgran::c_api::rigid_wall::{
        ellgran_wall_add_shape, ellgran_wall_free, ellgran_wall_new, EllgranWallShape,
        ELLGRAN_SIDE_INSIDE,
    };
    with_driver("walls_that_will_not_do", &[], || unsafe {
        let row = Row::new();
        let stream = row.engine.stream;
        let mut numbers = [7; 2];
        let add = |wall, number: &mut i32| ellgran_gpu_add_wall(row.scene, wall, stream, number);
        let mut wall = core::ptr::null_mut();
        let status = add(wall, &mut numbers[0]);
        fail(status, ELLGRAN_ERROR_NULL_POINTER, &["wall"]);
        succeed(ellgran_wall_new(&mut wall));
        let status = add(wall, &mut numbers[0]);
        fail(status, ELLGRAN_ERROR_ARGUMENT, &["no parts"]);
        // Nine planes under all grains of the row.
        let shape = EllgranWallShape {
            name: c"plane".as_ptr(),
            point: [5.7, 0.0, -0.99],
            axis: [0.0, 0.0, 1.0],
            side: ELLGRAN_SIDE_INSIDE,
            ..new()
        };
        succeed(ellgran_wall_add_shape(wall, &shape));
        succeed(add(wall, &mut numbers[0]));
        for _ in 0..8 {
            succeed(ellgran_wall_add_shape(wall, &shape));
        }
        succeed(add(wall, &mut numbers[1]));
        assert_eq!(numbers, [0, 1]);
        ellgran_wall_free(wall);

        let mut plane = 0;
        succeed(ellgran_gpu_add_plane(row.scene, stream, &mut plane));
        assert_eq!(plane, 2);
        succeed(row.new_list());
        let step = new::<ellgran::c_api::particles::EllgranStep>();
        let (grains, loads) = (row.grains(), row.loads.loads());
        let compute = |number: i32, wall_type: i32| {
            let rest = core::ptr::null();
            ellgran_gpu_compute_wall(
                row.scene, &grains, number, rest, wall_type, &step, &loads, stream,
            )
        };
        succeed(compute(0, 1));
        succeed(row.check());
        fail(compute(3, 1), ELLGRAN_ERROR_ARGUMENT, &["no wall 3"]);
        fail(compute(2, 1), ELLGRAN_ERROR_ARGUMENT, &["compute_plane"]);
        fail(compute(0, 2), ELLGRAN_ERROR_ARGUMENT, &["wall_type = 2"]);
        let at = ellgran::c_api::plane::EllgranPlane {
            normal: [0.0, 0.0, 1.0],
            ..new()
        };
        let status =
            ellgran_gpu_compute_plane(row.scene, &grains, 0, &at, 1, &step, &loads, stream);
        fail(status, ELLGRAN_ERROR_ARGUMENT, &["compute_wall"]);
        succeed(compute(1, 1));
        let words = ["particle 10", "more than 8 places"];
        fail(row.check(), ELLGRAN_ERROR_PARTICLE, &words);
        succeed(row.check());
    });
}

/// Those of which more are beside a grain than a kernel has room for, and those that an engine lends.
#[test]
fn triangles_that_will_not_do() {
    use ellgran::c_api::engine_walls::{ellgran_wall_lend_triangles, EllgranLentTriangles};
    use ellgran::c_api::rigid_wall::{
        ellgran_wall_add_triangles, ellgran_wall_free, ellgran_wall_new,
    };
    with_driver("triangles_that_will_not_do", &[], || unsafe {
        let row = Row::new();
        let stream = row.engine.stream;
        let mut number = 7;
        let mut wall = core::ptr::null_mut();
        succeed(ellgran_wall_new(&mut wall));
        // Stripes under all grains of the row, and narrow ones under the third.
        let edges = (0..12).map(|k| f64::from(k) - 2.0);
        let narrow = (1..2400).map(|k| 3.0 + f64::from(k) / 2400.0);
        let mut edges: Vec<f64> = edges.chain(narrow).collect();
        edges.sort_by(f64::total_cmp);
        let corner = |x: f64, y: f64| [x, y, -0.999 - 1e-3 * x.sin()];
        let stripe = |x: &[f64]| {
            let [a, b, c, d] =
                [(0, -3.0), (1, -3.0), (1, 3.0), (0, 3.0)].map(|(k, y)| corner(x[k], y));
            [[a, b, c], [a, c, d]]
        };
        let triangles: Vec<[[f64; 3]; 3]> = edges.windows(2).flat_map(stripe).collect();
        let corners = triangles.as_flattened().as_flattened();
        let status = ellgran_wall_add_triangles(wall, triangles.len(), corners.as_ptr());
        succeed(status);
        succeed(ellgran_gpu_add_wall(row.scene, wall, stream, &mut number));
        let lent = new::<EllgranLentTriangles>();
        succeed(ellgran_wall_lend_triangles(wall, &lent));
        let status = ellgran_gpu_add_wall(row.scene, wall, stream, &mut number);
        fail(status, ELLGRAN_ERROR_ARGUMENT, &["part 1", "lent"]);
        ellgran_wall_free(wall);
        succeed(row.new_list());
        let step = new::<ellgran::c_api::particles::EllgranStep>();
        let (grains, loads) = (row.grains(), row.loads.loads());
        let rest = core::ptr::null();
        succeed(ellgran_gpu_compute_wall(
            row.scene, &grains, number, rest, 1, &step, &loads, stream,
        ));
        let words = ["particle 12", "more than 512 triangles"];
        fail(row.check(), ELLGRAN_ERROR_PARTICLE, &words);
        succeed(row.check());
    });
}

/// As a rank that has none, or ghosts alone.
#[test]
fn no_grains() {
    with_driver("no_grains", &[], || {
        let row = Row::new();
        let stream = row.engine.stream;
        let loads = row.loads.loads();
        let step = new::<ellgran::c_api::particles::EllgranStep>();
        for count in [0, COUNT] {
            let grains = EllgranGpuGrains {
                owned_count: 0,
                count,
                ..row.grains()
            };
            let list = new::<EllgranGpuList>();
            let motion = EllgranGpuMotion {
                count: 0,
                ..row.motion()
            };
            unsafe {
                succeed(ellgran_gpu_new_list(row.scene, &grains, &list, stream));
                succeed(ellgran_gpu_start_step(row.scene, &motion, 1e-5, stream));
                succeed(ellgran_gpu_prepare(row.scene, &grains, stream));
                let status = ellgran_gpu_compute_pairs(row.scene, &grains, &step, &loads, stream);
                succeed(status);
                succeed(ellgran_gpu_check(row.scene, &grains, stream));
            }
        }
        // And then some.
        succeed(row.new_list());
        succeed(row.compute());
        assert!(row.engine.read(&row.loads)[0][0] < 0.0);
    });
}

/// Contacts would advance, and loads be nowhere.
#[test]
fn nothing_is_started_without_loads() {
    with_driver("nothing_is_started_without_loads", &[], || {
        let row = Row::new();
        succeed(row.new_list());
        let before = row.engine.tally(support::Tally::Launches);
        let grains = row.grains();
        let step = ellgran::c_api::particles::EllgranStep {
            advance_history: 1,
            time_step: 1e-3,
            ..new()
        };
        let compute = |loads: &EllgranGpuLoads| unsafe {
            ellgran_gpu_compute_pairs(row.scene, &grains, &step, loads, row.engine.stream)
        };
        let null = core::ptr::null_mut();
        let mut without = row.loads.loads();
        without.forces.first = null;
        fail(compute(&without), ELLGRAN_ERROR_NULL_POINTER, &["forces"]);
        without = row.loads.loads();
        without.torques.first = null;
        fail(compute(&without), ELLGRAN_ERROR_NULL_POINTER, &["torques"]);
        let mut other = row.loads.loads();
        other.add = 2;
        fail(compute(&other), ELLGRAN_ERROR_ARGUMENT, &["add = 2"]);
        // All components of a grain at one place.
        other = row.loads.loads();
        other.torques.per_component = 0;
        let words = ["torques: per_grain = 6", "per_component = 0"];
        fail(compute(&other), ELLGRAN_ERROR_ARGUMENT, &words);
        assert_eq!(row.engine.tally(support::Tally::Launches), before);
    });
}

/// A neighbour that has become another one after the list was looked at.
#[test]
fn a_kernel_that_ends() {
    with_driver("a_kernel_that_ends", &[], || {
        let row = Row::new();
        succeed(row.new_list());
        row.engine.write(&row.neighbours, 0, &[77]);
        // It has moved: its row is looked through again.
        row.engine.write(&row.positions, 0, &[[0.1, 0.0, 0.0]]);
        // That kernel is started, and ends; the next one is not.
        let words = ["has changed since", "715"];
        fail(row.prepare(), ELLGRAN_GPU_ERROR_KERNEL, &words);
        fail(row.check(), ELLGRAN_GPU_ERROR_KERNEL, &words);
        fail(row.compute(), ELLGRAN_GPU_ERROR_KERNEL, &["begin anew"]);
        // All can still be freed.
        unsafe { ellgran_gpu_scene_free(row.scene) };
    });
}

/// A pointer of the host in a step, where pointers are not looked at.
#[test]
fn a_kernel_that_leaves_the_memory() {
    with_driver("a_kernel_that_leaves_the_memory", &[], || {
        let row = Row::new();
        succeed(row.new_list());
        let mut grains = row.grains();
        let host = [[0.0f64; 3]; COUNT];
        grains.positions.first = host.as_ptr().cast_mut().cast();
        let status = unsafe { ellgran_gpu_prepare(row.scene, &grains, row.engine.stream) };
        fail(status, ELLGRAN_GPU_ERROR_KERNEL, &["ILLEGAL_ADDRESS"]);
        fail(row.check(), ELLGRAN_GPU_ERROR_KERNEL, &["ILLEGAL_ADDRESS"]);
    });
}

#[test]
fn too_little_memory() {
    // Enough for the arrays of the engine and for the laws.
    let settings = [("ELLGRAN_STAND_IN_MEMORY", "2200")];
    with_driver("too_little_memory", &settings, || {
        let row = Row::new();
        let words = ["bytes more are needed", "of 2200 are free", "Fewer grains"];
        fail(row.new_list(), ELLGRAN_GPU_ERROR_MEMORY, &words);
        let mut counts = new::<EllgranGpuCounts>();
        succeed(unsafe { ellgran_gpu_counts(row.scene, row.engine.stream, &mut counts) });
        assert!(counts.bytes < 2200 && counts.selections == 0);
        fail(row.prepare(), ELLGRAN_ERROR_ARGUMENT, &["no list"]);
        unsafe { ellgran_gpu_scene_free(row.scene) };
    });
}

/// What a scene has taken it gives back, and a list of the same size takes nothing more.
#[test]
fn memory_is_kept_and_given_back() {
    with_driver("memory_is_kept_and_given_back", &[], || {
        let row = Row::new();
        let tally = |which| row.engine.tally(which);
        succeed(row.new_list());
        succeed(row.new_list());
        let taken = tally(Tally::Allocations);
        for _ in 0..5 {
            succeed(row.new_list());
            succeed(row.compute());
        }
        assert_eq!(tally(Tally::Allocations), taken);
        assert_eq!(tally(Tally::Frees), 0);
        unsafe { ellgran_gpu_scene_free(row.scene) };
        // What the engine has put there stays.
        let of_engine = 11;
        assert_eq!(tally(Tally::Frees), taken - of_engine);
    });
}
